"""Trace formats: a table each, recognised by what a file holds; and a trace read by one of them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import attrs

from ...base import InputError, Registry, TraceError, folder, recording_names, unknown_name
from ..assumptions import DIRECTION, Assumption, By, Defect, Fact, Layout
from ..options import TraceOptions
from ..reading import columns
from ..reading.axes import OPENXR, parse_axes
from ..reading.cleaning import UNIT_NAMES, LoadedTrace, clean
from ..reading.columns import Head, is_number
from ..reading.text_table import RowReader, read_head
from ..track import PoseTrack
from ..writing import WRITERS


class TraceFormat:
    """One layout of head-motion files, a table of these fields in this package.

    Most need nothing but `header` and `facts`. Another package subclasses it.
    """

    name = ""  # the name of the format
    summary = ""  # one line for people
    kind: str = ""  # of the table that such files are made into, see `reading.columns.Made`
    file: str = ""  # what such a file is called, for errors
    header: tuple[str, ...] = ()  # names of columns that every such file has
    first_words = False  # whether `header` holds the first words of names alone
    likelihood = 90  # of a file with that header, see `sniff`
    facts: Mapping[str, Any] = {}  # what the format states: fields of Layout
    order = ""  # of an orientation's numbers, in words; "": as the names of its columns say
    order_by = By.FILE
    bare_order = ""  # of quaternions in files without a header: xyzw or wxyz; "" where there are none
    bare: Mapping[str, Any] = {}  # separator and widths of files of numbers alone that are likely of it
    recognised = ""  # by one of `reading.columns.SNIFFS`
    read_as = ""  # one of `reading.columns.LAYOUTS`
    written_as = ""  # one of `writing.WRITERS`
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
        return self.likelihood if self.header and set(self.header) <= found else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        """Return the meaning of the columns. Errors: TraceError when a required one is missing."""
        if self.read_as:
            return columns.LAYOUTS[self.read_as](head, options, self.facts)
        if not head.names and self.bare_order:
            unit = self.facts.get("unit") if options.format else None
            return columns.unnamed_layout(head, options, self.name, self.bare_order, unit)
        return columns.named_layout(head, options, **{**self.facts, **({} if head.made is None else head.made.facts)})

    def assumes(self) -> tuple[Assumption, ...]:
        """Return what is taken where neither a file nor the user says it, and who says so."""
        facts, axes = self.facts, parse_axes(self.facts.get("axes", OPENXR))
        axes_by = facts.get("axes_by", By.DEFAULT)
        unit, scale = facts.get("unit"), facts.get("scale", axes.metres_per_unit or 1.0)
        scale_by = facts.get("scale_by", axes_by if axes.metres_per_unit else By.DEFAULT)
        clock = UNIT_NAMES[unit] if unit else "what makes a tracker's rate"
        way, way_by = DIRECTION[bool(facts.get("inverse"))], facts.get("direction_by", By.DEFAULT)
        order = self.order or f"as the names say{f', {self.bare_order} without a header' if self.bare_order else ''}"
        return (
            Assumption(Fact.CLOCK, clock, By.FORMAT if unit else By.DEFAULT),
            Assumption(Fact.LENGTH, f"{scale:g} m per unit", scale_by, "--scale"),
            Assumption(Fact.AXES, axes.label(), axes_by, "--axes"),
            Assumption(Fact.ORIENTATION, order, facts.get("order_by", self.order_by), "--quat-order"),
            Assumption(Fact.POSE, way, way_by, "--pose"),
        )

    def read(self, head: Head, options: TraceOptions) -> LoadedTrace:
        """Return the clean track of a file. Errors: TraceError, InputError."""
        if self.kind and head.kind != self.kind:
            what = self.file or f"file of format {self.name}"
            raise TraceError(f"{head.path} is no {what} ({head.describe()}): leave --format out, or name its own")
        layout = columns.with_clock(head, self.layout(head, options), options)
        stated = (text.partition(":") for _, text in head.comments)  # such as "# axes: tum-rgbd"
        for value in (value for key, _, value in stated if key.strip().lower() == "axes"):
            with suppress(InputError):  # comments in words count where they name OpenXR
                axes = OPENXR if OPENXR in value.lower() else value
                parse_axes(axes)
                layout = attrs.evolve(layout, axes=axes, axes_by=By.FILE)
                break
        return clean(RowReader(head, layout, options).read(), self.name)

    def write(self, track: PoseTrack, stream: IO[Any]) -> None:
        """Write a track so that reading it gives the same poses bit for bit."""
        if not self.written_as:
            raise TraceError(f"format {self.name} is read, not written")
        WRITERS[self.written_as](track, stream, **self.written)


def _of_table(name: str, table: dict[str, Any]) -> TraceFormat:
    said = table.pop("facts", {}).items()
    facts: dict[str, Any] = {key: By(value) if key.endswith("_by") else value for key, value in said}
    if caveats := facts.get("caveats"):
        facts["caveats"] = tuple(Defect(**caveat) for caveat in caveats)
    made = TraceFormat()
    made.name, made.facts, made.header = name, facts, tuple(table.pop("header", ()))
    made.order_by, made.writes = By(table.pop("order_by", made.order_by)), "written_as" in table
    for field, value in table.items():
        setattr(made, field, value)
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
