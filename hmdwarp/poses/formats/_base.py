"""What every trace format is made of: recognise it, find its columns, perhaps write it."""

from __future__ import annotations

from typing import IO, TYPE_CHECKING

import attrs

from ...errors import TraceError
from ..defects import Defect
from ..options import TraceOptions
from ..reading.columns import Columns, find_columns

if TYPE_CHECKING:
    from ..reading.cleaning import Cleaned
    from ..reading.head import Head
    from ..reading.rows import Layout
    from ..track import PoseTrack


class TraceFormat:
    """One layout of head-motion files. A new one is one file in this package."""

    name = ""  # as the file is called
    summary = ""  # one line for people
    writes = False  # whether `write` works

    def sniff(self, head: Head, options: TraceOptions) -> int:
        """Return how surely the file is of this format: 0 not at all, 100 certainly.

        The highest wins.
        """
        raise NotImplementedError

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        """Return which columns hold what. Errors: TraceError when a needed one is missing."""
        raise NotImplementedError

    def read(self, head: Head, options: TraceOptions) -> Cleaned:
        """Return the clean track of a file. Errors: TraceError, InputError."""
        from ..reading.cleaning import Cleaner
        from ..reading.rows import RowReader

        layout = self.layout(head, options)
        if layout.time is None and options.rate is None:
            raise TraceError(f"{head.path} has no time ({head.describe()}): give the samples per second with --rate")
        if options.rate is not None:
            layout = attrs.evolve(layout, time=None, clock_ignored=layout.time is not None)
        reader = RowReader(head, layout)
        rows = reader.read()
        layout = attrs.evolve(layout, caveats=(*layout.caveats, *reader.defects))
        cleaner = Cleaner(str(head.path), rows, layout, options, reader.ends_with_newline)
        return cleaner.clean(head.path.stem, self.origin(head))

    def origin(self, head: Head) -> str:
        """Return where the motion comes from, if the file says so."""
        return ""

    def write(self, track: PoseTrack, stream: IO[str]) -> None:
        """Write a track so that reading it gives the same poses bit for bit."""
        raise TraceError(f"format {self.name} is read, not written")


def named_layout(head: Head, options: TraceOptions, **known) -> Layout:
    """Return a layout from the header's names.

    known: facts of the format: unit, axes, device, scale, caveats.
    Errors: TraceError for Euler angles only, and for a quaternion that is missing or of unknown
    order.
    """
    from ..reading.rows import Layout

    if head.names is None:
        raise TraceError(f"{head.path} has no header ({head.describe()}): its columns cannot be told apart")
    found = find_columns(head.names)
    orientation = found.orientation
    if orientation is None:
        raise _no_quaternion(head, found)
    if found.numbered:
        orientation = ordered(head, orientation, options.quat_order)
    elif options.quat_order is not None:
        known["caveats"] = (*known.get("caveats", ()), _order_ignored(options.quat_order))
    facts = {
        "time": found.time,
        "unit": found.time_unit,
        "orientation": orientation,
        "position": found.position,
        "device": found.device,
        "scale": found.length_m or 1.0,
    }
    return Layout(**(facts | known))


def unnamed_layout(head: Head, options: TraceOptions, name: str, order: str, unit: str | None) -> Layout:
    """Return the layout of time, position and quaternion in this order, without a header.

    Asked for by name, the file is what the format says, with w in that order; found by its shape
    alone, the order has to be told.
    Errors: TraceError for fewer columns, or an unknown order.
    """
    from ..reading.rows import Layout

    if head.width < 8:
        raise TraceError(
            f"{head.path}: line {head.first_line}: {head.width} columns, expected 8: time, position and quaternion"
        )
    known = options.quat_order or (order if options.format == name else None)
    return Layout(time=0, position=(1, 2, 3), orientation=ordered(head, (4, 5, 6, 7), known), unit=unit)


def _order_ignored(order: str) -> Defect:
    return Defect(
        "quat-order-named",
        f"--quat-order {order} was given, but the header names x, y, z and w",
        "the names are followed",
    )


def _no_quaternion(head: Head, found: Columns) -> TraceError:
    if found.euler:
        names = ", ".join(found.euler[:4])
        return TraceError(
            f"{head.path} gives Euler angles only ({names}): their order and signs differ "
            "from device to device, and the file does not state them; convert them to quaternions with what you "
            "know of the device"
        )
    return TraceError(
        f"{head.path} has no head orientation as a quaternion among {head.describe()}; see 'hmdwarp list formats'"
    )


def ordered(head: Head, columns: tuple[int, ...], order: str | None) -> tuple[int, int, int, int]:
    """Return four quaternion columns of the file in the order x y z w.

    Errors: TraceError if the order is unknown.
    """
    if order is None:
        raise TraceError(
            f"{head.path}: nothing in the file tells whether w comes first or last in its quaternions "
            f"({head.describe()}); "
            "say --quat-order wxyz or --quat-order xyzw"
        )
    a, b, c, d = columns
    return (b, c, d, a) if order == "wxyz" else (a, b, c, d)


def has(head: Head, *names: str) -> bool:
    """Tell whether the header holds all these names."""
    return head.names is not None and set(names) <= set(head.names)


def whole_number(field: str, digits: int) -> bool:
    """Tell whether the field is an integer of exactly so many digits."""
    return len(field) == digits and field.isdigit()
