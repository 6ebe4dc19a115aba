"""Load a head trace: a file in any known format, or the name of a recording that comes with the program."""

from __future__ import annotations

from pathlib import Path

import attrs

from ..errors import TraceError
from ..registry import unknown_name
from .defects import Defect
from .options import TraceOptions
from .reading.cleaning import Segment
from .track import PoseTrack


@attrs.frozen(eq=False)
class LoadedTrace:
    """A trace and everything that was found out about its file.

    time_unit: of the file's clock, in words. rate_hz: one over the median step that this unit implies. segments: the recordings
    the file holds, one of them taken. defects: all that was wrong, and what was done.
    """

    track: PoseTrack
    path: Path
    format: str
    defects: list[Defect]
    segments: list[Segment]
    time_unit: str

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.track.rate_hz


def load_trace(name_or_path: str | Path, options: TraceOptions | None = None) -> LoadedTrace:
    """Read a head trace.

    name_or_path: a file, or a bare name (no folder, no ending) of a shipped recording. options: overrides.
    Errors: TraceError naming file and line; UnknownNameError with the nearest known recording or format.
    """
    from .formats._find import find_format
    from .reading.head import read_head

    options = options or TraceOptions()
    path = trace_path(name_or_path)
    if not path.exists() and path.stem in _recordings():
        raise TraceError(
            f"{path}: no such file; the shipped recording is called '{path.stem}', without folder and ending"
        )
    head = read_head(path)
    found = find_format(head, options)
    cleaned = found.read(head, options)
    return LoadedTrace(cleaned.track, path, found.name, cleaned.defects, cleaned.segments, cleaned.time_unit)


def trace_path(name_or_path: str | Path) -> Path:
    """The file meant: shipped recordings first, if it is a bare name. Errors: TraceError, UnknownNameError."""
    text = str(name_or_path)
    if not text or "\x00" in text:
        raise TraceError(f"{text!r} is no file name")
    path = Path(text)
    if isinstance(name_or_path, Path) or path.name != text or path.suffix:
        return path
    from ..resources import folder

    names = _recordings()
    if text in names:
        return folder("recordings") / f"{text}.csv"
    if path.exists() or not names:
        return path
    raise unknown_name("recording", text, names)


def _recordings() -> list[str]:
    from ..resources import recording_names

    try:
        return recording_names()
    except FileNotFoundError:
        return []
