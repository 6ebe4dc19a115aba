"""Trace formats: a table each, recognised by what a file holds; a trace read or written by one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, Registry, TraceError, folder, recording_names, unknown_name
from ...geometry import Pose
from ..assumptions import DIRECTION, Assumption, By, Defect, Fact, Layout
from ..options import TraceOptions
from ..reading import columns
from ..reading.axes import OPENXR, parse_axes
from ..reading.cleaning import UNIT_NAMES, LoadedTrace, clean
from ..reading.columns import Head, is_number
from ..reading.text_table import read_head, read_rows
from ..track import PoseTrack

COLUMNS = ("time_ns", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
GAZE = ("gaze_x", "gaze_y", "gaze_z")
AXES = "world_from_head in OpenXR axes: right-handed, +x right, +y up, -z forward, metres; quaternion x y z w"
_BLOCK = 65536  # rows written at a time


def _write_rows(
    track: PoseTrack, stream: IO[str], separator: str, order: str, *,
    seconds: bool = False, decimals: tuple[int, int] | None = None, gaze: NDArray[np.float64] | None = None,
) -> None:  # fmt: skip
    # What restores the recording's own clock, if readers take that.
    offset = track.epoch_ns if abs(track.epoch_ns) + max(abs(track.start_ns), abs(track.end_ns)) < 2**62 else 0
    columns, row = ["xyzw".index(c) for c in order], ""
    for a in range(0, len(track), _BLOCK):
        part = slice(a, a + _BLOCK)
        position, orientation = track.position_m[part], track.orientation_xyzw[part][:, columns]
        if gaze is not None:
            orientation = np.hstack([orientation, np.nan_to_num(gaze[part])])
        if decimals is not None:  # + 0.0 turns a rounded -0.0 into 0.0
            position, orientation = np.round(position, decimals[0]) + 0.0, np.round(orientation, decimals[1]) + 0.0
            row = separator.join([f"%.{decimals[0]}f"] * 3 + [f"%.{decimals[1]}f"] * orientation.shape[1])
        for time, p, q in zip(track.time_ns[part].tolist(), position.tolist(), orientation.tolist(), strict=True):
            ns = time + offset
            stamp = f"{'-' * (ns < 0)}{abs(ns) // 10**9}.{abs(ns) % 10**9:09d}" if seconds else ns
            stream.write(f"{stamp}{separator}{row % (*p, *q) if row else separator.join(map(repr, p + q))}\n")


def write_native(track: PoseTrack, stream: IO[str], decimals: tuple[int, int] | None = None) -> None:
    """Write header, column names, rows. decimals: of positions, quaternions; None for every bit."""
    columns = COLUMNS if track.gaze is None else (*COLUMNS, *GAZE)
    stream.write(header_text(track.origin, track.rate_hz, track.notes, columns))
    _write_rows(track, stream, ",", "xyzw", decimals=decimals, gaze=track.gaze)


def header_text(origin: str, rate_hz: float, notes: Iterable[str] = (), columns: Iterable[str] = COLUMNS) -> str:
    """Return what is above the rows. origin: of the motion, in words. notes: for readers."""
    head = ["hmdwarp head trace", f"origin: {origin or 'not told'}", f"rate: {rate_hz:.6g} Hz", f"axes: {AXES}", *notes]
    # One line each: a note with a newline in it would become a row.
    return "".join(f"# {' '.join(text.split())}\n" for text in head) + ",".join(columns) + "\n"


def row_text(time_ns: int, pose: Pose) -> str:
    """Return one sample in full precision, for a trace that is written while it grows."""
    numbers = (*pose.position_m.tolist(), *pose.orientation_xyzw.tolist())
    return f"{time_ns},{','.join(map(repr, numbers))}\n"


class TraceFormat:
    """One layout of head-motion files, a table of these fields in this package.

    Most need nothing but `header` and `facts`. Another package subclasses it.
    """

    name = ""  # the name of the format
    summary = ""  # one line for people
    kind: str = ""  # of the table that such files are made into, see `reading.columns.Made`
    header: Sequence[str] = ()  # names of columns that every such file has
    first_words = False  # whether `header` holds the first words of names alone
    facts: Mapping[str, Any] = {}  # what the format states: fields of Layout
    order = ""  # of an orientation's numbers, in words; "": as the names of its columns say
    order_by = By.FILE
    bare: Mapping[str, Any] = {}  # separator, widths and order of quaternions of files of numbers alone
    recognised = ""  # by one of `reading.columns.SNIFFS`
    read_as = ""  # one of `reading.columns.LAYOUTS`
    written_as = ""  # "native" or "text"
    written: Mapping[str, Any] = {}  # what that has to know
    writes = False  # whether `write` works

    def sniff(self, head: Head, options: TraceOptions) -> int:
        """Return how likely the file is of this format, 0 to 100 (certainly); the highest wins."""
        if self.recognised:
            return columns.SNIFFS[self.recognised](head)
        if self.kind:
            return 100 if head.kind == self.kind else 0
        if self.bare and not head.names:
            same = (head.separator or "") == self.bare["separator"] and head.width in self.bare["widths"]
            return 5 if same and all(is_number(field) for field in head.rows[0]) else 0
        found = {name.split(" ")[0] if self.first_words else name for name in head.names}
        return 90 if self.header and set(self.header) <= found else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        """Return the meaning of the columns. Errors: TraceError when a required one is missing."""
        if self.read_as:
            return columns.LAYOUTS[self.read_as](head, options, self.facts)
        if not head.names and self.bare:
            return columns.unnamed_layout(head, options, self.bare["order"], self.facts["unit"])
        return columns.named_layout(head, options, **{**self.facts, **({} if head.made is None else head.made.facts)})

    def assumes(self) -> tuple[Assumption, ...]:
        """Return what is taken where neither a file nor the user says it, and who says so."""
        facts, axes = self.facts, parse_axes(self.facts.get("axes", OPENXR))
        axes_by = facts.get("axes_by", By.DEFAULT)
        unit, scale = facts.get("unit"), facts.get("scale", axes.metres_per_unit or 1.0)
        scale_by = facts.get("scale_by", axes_by if axes.metres_per_unit else By.DEFAULT)
        clock = UNIT_NAMES[unit] if unit else "what makes a tracker's rate"
        way, way_by = DIRECTION[bool(facts.get("inverse"))], facts.get("direction_by", By.DEFAULT)
        order = "as the names say" + (f", {self.bare['order']} without a header" if self.bare else "")
        return (
            Assumption(Fact.CLOCK, clock, By.FORMAT if unit else By.DEFAULT),
            Assumption(Fact.LENGTH, f"{scale:g} m per unit", scale_by, "--scale"),
            Assumption(Fact.AXES, axes.label(), axes_by, "--axes"),
            Assumption(Fact.ORIENTATION, self.order or order, facts.get("order_by", self.order_by), "--quat-order"),
            Assumption(Fact.POSE, way, way_by, "--pose"),
        )

    def read(self, head: Head, options: TraceOptions) -> LoadedTrace:
        """Return the clean track of a file. Errors: TraceError, InputError."""
        if self.kind and head.kind != self.kind:
            what = f"no file of format {self.name} ({head.describe()})"
            raise TraceError(f"{head.path} is {what}: leave --format out, or name its own")
        layout = columns.with_clock(head, self.layout(head, options), options)
        stated = (text.partition(":") for _, text in head.comments)  # such as "# axes: tum-rgbd"
        for value in (value for key, _, value in stated if key.strip().lower() == "axes"):
            with suppress(InputError):  # comments in words count where they name OpenXR
                axes = OPENXR if OPENXR in value.lower() else value
                parse_axes(axes)
                layout = attrs.evolve(layout, axes=axes, axes_by=By.FILE)
                break
        return clean(read_rows(head, layout, options), self.name)

    def write(self, track: PoseTrack, stream: IO[Any]) -> None:
        """Write a track so that reading it gives the same poses bit for bit."""
        if not self.written_as:
            raise TraceError(f"format {self.name} is read, not written")
        if self.written_as == "native":
            write_native(track, stream)
        else:
            written = dict(self.written)
            stream.write(f"# axes: {OPENXR}\n{written.pop('names')}\n")
            _write_rows(track, stream, **written)


def _of_table(name: str, table: dict[str, Any]) -> TraceFormat:
    said = table.pop("facts", {}).items()
    facts: dict[str, Any] = {key: By(value) if key.endswith("_by") else value for key, value in said}
    if caveats := facts.get("caveats"):
        facts["caveats"] = tuple(Defect(**caveat) for caveat in caveats)
    made, order_by = TraceFormat(), By(table.pop("order_by", By.FILE))
    vars(made).update(table, name=name, facts=facts, order_by=order_by, writes="written_as" in table)
    return made


formats: Registry[TraceFormat] = Registry(
    "trace format", __package__, of_table=_of_table, holds_objects=True, columns="can_write=writes"
)
STATED = _of_table("columns", {"read_as": "stated"})  # by --columns


def load_trace(name_or_path: str | Path, options: TraceOptions | None = None) -> LoadedTrace:
    """Read a head trace: its `track` has the poses, `notes` what was repaired or assumed.

    Parameters
    ----------
    name_or_path : str or Path
        A file, or a bare name (no folder, no ending), looked up among the shipped recordings first.
    options : TraceOptions, optional
        Overrides facts of the file, or adds missing ones.

    Returns
    -------
    LoadedTrace

    Raises
    ------
    TraceError
        Naming file and line.
    UnknownNameError
        With the nearest known recording or format.
    """
    options = TraceOptions.checked(options, optional=True)
    text = str(name_or_path)
    if not text or "\x00" in text:
        raise TraceError(f"{text!r} is no file name")
    path, names = Path(text), []
    with suppress(FileNotFoundError):
        names = recording_names()
    is_bare = not isinstance(name_or_path, Path) and path.name == text and not path.suffix
    if is_bare and text in names:
        path = folder("recordings") / f"{text}.csv"
    elif is_bare and names and not path.exists():
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
    if not head.names and head.width >= 5:
        turn, of = ("q=5+6+7+8", "q: x y z w") if head.width > 7 else ("e=5+6+7", "e: angles, with --euler")
        what = f"nothing in the file says what its columns are ({head.describe()})"
        raise TraceError(f"{head.path}: {what}: say --columns t=1,p=2+3+4,{turn} with their numbers ({of})")
    how = f"name the columns in a header line, or say --format ({', '.join(formats.names())})"
    raise TraceError(f"{head.path} is in no known trace format ({head.describe()}): {how}")
