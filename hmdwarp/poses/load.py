"""Load a head trace: a file in any known format, or a shipped recording by name."""

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
    """A trace and all facts about its file."""

    track: PoseTrack
    path: Path
    format: str
    defects: list[Defect]  # all defects and their repairs
    segments: list[Segment]  # recordings within the file, of which one was used
    time_unit: str  # of the file's clock, in words
    columns: str  # which were read as what, by name or number
    axes_assumed: bool  # nothing says which they are

    def notes(self) -> list[str]:
        """Return a line for each defect, and one for axes that are only assumed."""
        assumed = [f"the trace's axes: {self.axes}; --axes says otherwise"] if self.axes_assumed else []
        return [*assumed, *map(str, self.defects)]

    @property
    def axes(self) -> str:
        """Axes of the file, who says so, and what the motion shows, in words."""
        return self.track.axes

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.track.rate_hz


def load_trace(name_or_path: str | Path, options: TraceOptions | None = None) -> LoadedTrace:
    """Read a head trace.

    name_or_path: a file, or a bare name (no folder, no ending) of a shipped recording.
    options: overrides facts of the file, or adds missing ones.
    Errors: TraceError naming file and line; UnknownNameError with the nearest known recording or
    format.
    """
    from .finding import find_format
    from .reading.file_head import read_head

    options = options or TraceOptions()
    path = trace_path(name_or_path)
    if not path.exists() and path.stem in _recordings():
        raise TraceError(
            f"{path}: no such file; the shipped recording is called '{path.stem}', without folder and ending"
        )
    head = read_head(path)
    found = find_format(head, options)
    cleaned = found.read(head, options)
    return LoadedTrace(
        track=cleaned.track,
        path=path,
        format=found.name,
        defects=cleaned.defects,
        segments=cleaned.segments,
        time_unit=cleaned.time_unit,
        columns=cleaned.columns,
        axes_assumed=cleaned.axes_assumed,
    )


def trace_path(name_or_path: str | Path) -> Path:
    """Return the path of a trace; a bare name is looked up among the shipped recordings first.

    Errors: TraceError, UnknownNameError.
    """
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
