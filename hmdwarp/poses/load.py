"""Load a head trace: a file in any known format, or a shipped recording by name."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from ..errors import TraceError, unknown_name
from ..resources import folder, recording_names
from .formats import STATED, TraceFormat, formats
from .options import TraceOptions
from .reading.cleaning import LoadedTrace
from .reading.text_table import Head, read_head


def load_trace(name_or_path: str | Path, options: TraceOptions | None = None) -> LoadedTrace:
    """Read a head trace: its `track` has the poses, `notes` what was repaired or assumed.

    name_or_path: a file, or a bare name (no folder, no ending), which is looked up among the
    shipped recordings first. options: overrides facts of the file, or adds missing ones. Errors:
    TraceError naming file and line; UnknownNameError with the nearest known recording or format.
    """
    options = TraceOptions.checked(options, optional=True)
    text = str(name_or_path)
    if not text or "\x00" in text:
        raise TraceError(f"{text!r} is no file name")
    path, names = Path(text), []
    with suppress(FileNotFoundError):
        names = recording_names()
    if not (isinstance(name_or_path, Path) or path.name != text or path.suffix):
        if text in names:
            path = folder("recordings") / f"{text}.csv"
        elif names and not path.exists():
            raise unknown_name("recording", text, names)
    elif not path.exists() and path.stem in names:
        recording = f"the shipped recording is called '{path.stem}', with no folder or ending"
        raise TraceError(f"{path}: no such file; {recording}")
    head = read_head(path)
    return find_format(head, options).read(head, options)


def find_format(head: Head, options: TraceOptions) -> TraceFormat:
    """Return the named format, or the most likely one. Errors: UnknownNameError, TraceError."""
    if options.columns is not None:
        return STATED
    if options.format is not None:
        return formats.get(options.format)
    scores = {f.name: f.sniff(head, options) for f in formats}
    best = max(scores, key=scores.__getitem__)
    if scores[best] > 0:
        return formats.get(best)
    if head.names is None and head.width >= 5:
        turn, of = ("q=5+6+7+8", "q: x y z w") if head.width > 7 else ("e=5+6+7", "e: angles, with --euler")
        what = f"nothing in the file says what its columns are ({head.describe()})"
        raise TraceError(f"{head.path}: {what}: say --columns t=1,p=2+3+4,{turn} with their numbers ({of})")
    how = f"name the columns in a header line, or say --format ({', '.join(formats.names())})"
    raise TraceError(f"{head.path} is in no known trace format ({head.describe()}): {how}")
