"""A run's time line as trace events, for Perfetto (ui.perfetto.dev) or Chrome's tracing page.

Source: Trace Event Format, Google (2016), JSON array format: ph "X" for what takes time, "s", "t"
and "f" for the flow from a frame to its refresh, "M" for names; ts and dur in microseconds.
"""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..link import TransitStats
from ..pipeline.loop import Refresh
from .recorder import Lines
from .run_summary import EYES

# Rows of the time line from top to bottom, each a process of the format: number and name.
FRAMES, SERVER, CLIENT, DISPLAY = range(1, 5)
SIMULATED, MEASURED = "simulated", "measured"
_NAMES = {
    FRAMES: "frames, from drawing to ready",
    SERVER: "server, as measured",
    CLIENT: "client, as measured",
    DISPLAY: "display",
}


class TraceEvents:
    """Write trace events while a run goes on.

    As a context manager it leaves nothing where the block raises.

    A row has as many lanes as things in it overlap, so that what is in a lane is nested or apart.
    Where a run is killed only the closing bracket is missing, which the format allows.

    path: a new file, unless forced. rate_hz: of the display. scanout_ns: 0 for a display that
    lights up at once.
    Errors: as Lines.
    """

    def __init__(self, path: Path, rate_hz: float, scanout_ns: int = 0, *, force: bool = False) -> None:
        self._path, self._period_ns, self._scanout_ns = path, round(1e9 / rate_hz), scanout_ns
        self._start_ns: int | None = None
        self._events = self._refreshes = 0
        # Ends of what each row's lanes hold last.
        self._lanes: dict[int, list[int]] = {row: [] for row in _NAMES}
        self._transit: TransitStats | None = None
        self._frame_at: tuple[int, int] = (0, 0)
        self._shown: Refresh | None = None
        self._is_missed = False
        self._lines = Lines(path, force=force)
        self._lines.add("[\n")
        for row, name in _NAMES.items():
            self._put({"ph": "M", "name": "process_name", "pid": row, "args": {"name": name}})
            self._put({"ph": "M", "name": "process_sort_index", "pid": row, "args": {"sort_index": row}})

    def add(self, refresh: Refresh, submitted_ns: int | None = None) -> None:
        """Add a refresh and the frame that it shows; its times must be known by now.

        submitted_ns: when the picture was handed to a display; None in a replay, whose warp takes
        no time of its clock: the passes then stand before the refresh, as long as they took here.
        """
        self._end_refresh(refresh.shown_ns)
        transit = refresh.transit
        if transit is not self._transit:
            self._transit = transit
            self._add_frame(refresh)
        flow = {"id": self._refreshes, "cat": "shown", "name": f"frame {transit.number}"}
        lane, at_ns = self._frame_at
        self._put({"ph": "s", **flow, **self._where(FRAMES, lane, at_ns)})
        self._add_passes(refresh, submitted_ns, flow)
        self._shown = refresh

    def work(self, start_ns: int, end_ns: int) -> None:
        """Add how long the client worked on the picture of the next refresh, on the run's clock."""
        lane = self._lane(CLIENT, start_ns, end_ns)
        self._slice(CLIENT, lane, f"work for refresh {self._next}", start_ns, end_ns, {"clock": SIMULATED})

    def missed(self, refresh: Refresh) -> None:
        """Add a refresh at which no new picture was ready: one that was seen before is shown."""
        self._end_refresh(refresh.shown_ns)
        self._shown, self._is_missed = refresh, True

    @property
    def _next(self) -> int:
        return self._refreshes + (self._shown is not None)

    def _add_frame(self, refresh: Refresh) -> None:
        """Add the way of a frame that is shown for the first time."""
        transit, frame = refresh.transit, refresh.frame
        lane = self._lane(FRAMES, transit.sent_ns, transit.ready_ns)
        about = {"frame": transit.number, "bytes": transit.size_bytes, "clock": SIMULATED}
        self._slice(FRAMES, lane, f"frame {transit.number}", transit.sent_ns, transit.ready_ns, about)
        at_ns = transit.sent_ns
        for name, part_ns in transit.parts_ns().items():
            if part_ns:
                self._slice(FRAMES, lane, name, at_ns, at_ns + part_ns, {"frame": transit.number, "clock": SIMULATED})
            at_ns += part_ns
        self._frame_at = lane, transit.sent_ns
        # Where work is a part of the frame's way, it is above already.
        took = {**frame.timings_ms, "render": frame.render_ms}
        at_ns = transit.sent_ns
        for name, is_above in (("render", transit.render_ns), ("encode", transit.encode_ns)):
            if not is_above and (took_ns := round(took.get(name, 0.0) * 1e6)):
                self._measured(SERVER, name, at_ns, at_ns + took_ns, transit.number)
                at_ns += took_ns
        if not transit.decode_ns and (took_ns := round(took.get("decode", 0.0) * 1e6)):
            self._measured(CLIENT, "decode", transit.ready_ns - took_ns, transit.ready_ns, transit.number)

    def _measured(self, row: int, name: str, start_ns: int, end_ns: int, frame: int) -> None:
        lane = self._lane(row, start_ns, end_ns)
        self._slice(row, lane, name, start_ns, end_ns, {"frame": frame, "clock": MEASURED})

    def _add_passes(self, refresh: Refresh, submitted_ns: int | None, flow: dict[str, Any]) -> None:
        """Add the passes of each eye, one after the other."""
        eyes = [[(name, round(took_ms * 1e6)) for name, took_ms in stages] for stages in refresh.stage_ms]
        total_ns = sum(took_ns for stages in eyes for _, took_ns in stages)
        read_ns = refresh.head.read_ns
        start_ns = read_ns if submitted_ns is not None and read_ns is not None else refresh.shown_ns - total_ns
        lane = self._lane(CLIENT, start_ns, start_ns + total_ns)
        about = {"refresh": self._refreshes, "frame": refresh.transit.number, "clock": MEASURED}
        at_ns = start_ns
        for eye, stages in zip(EYES, eyes, strict=False):
            self._slice(CLIENT, lane, f"{eye} eye", at_ns, at_ns + sum(took_ns for _, took_ns in stages), about)
            if eye == EYES[0]:
                self._put({"ph": "t", **flow, **self._where(CLIENT, lane, start_ns)})
            for name, took_ns in stages:
                self._slice(CLIENT, lane, name, at_ns, at_ns + took_ns, about)
                at_ns += took_ns
        if submitted_ns is not None:
            self._put({"ph": "i", "s": "t", "name": "submitted", **self._where(CLIENT, lane, submitted_ns)})

    def _end_refresh(self, next_ns: int | None) -> None:
        """Add the refresh before, which lasts until the next."""
        refresh, self._shown = self._shown, None
        missed, self._is_missed = self._is_missed, False
        if refresh is None:
            return
        start_ns, number = refresh.shown_ns, self._refreshes
        end_ns = next_ns if next_ns is not None else start_ns + self._period_ns
        lane = self._lane(DISPLAY, start_ns, end_ns)
        about = {"refresh": number, "frame": refresh.transit.number, "age_ms": refresh.age_ns * 1e-6}
        name = f"refresh {number}, missed" if missed else f"refresh {number}"
        self._slice(DISPLAY, lane, name, start_ns, end_ns, about)
        self._refreshes += 1
        if missed:
            return
        if self._scanout_ns:
            self._slice(DISPLAY, lane, "scan-out", start_ns, min(end_ns, start_ns + self._scanout_ns), about)
        flow = {"id": number, "cat": "shown", "name": f"frame {refresh.transit.number}", "bp": "e"}
        self._put({"ph": "f", **flow, **self._where(DISPLAY, lane, start_ns)})

    def _lane(self, row: int, start_ns: int, end_ns: int) -> int:
        """Return the first lane that is free from then on, and take it."""
        ends = self._lanes[row]
        lane = next((lane for lane, end in enumerate(ends) if end <= start_ns), len(ends))
        if lane == len(ends):
            ends.append(end_ns)
            name = _NAMES[row] if not lane else f"{_NAMES[row]}, beside"
            self._put({"ph": "M", "name": "thread_name", "pid": row, "tid": lane, "args": {"name": name}})
        ends[lane] = end_ns
        return lane

    def _slice(self, row: int, lane: int, name: str, start_ns: int, end_ns: int, about: dict[str, Any]) -> None:
        where = self._where(row, lane, start_ns)
        self._put({"ph": "X", "cat": "run", "name": name, **where, "dur": (end_ns - start_ns) / 1000, "args": about})

    def _where(self, row: int, lane: int, at_ns: int) -> dict[str, Any]:
        """Return the place of an event; time begins with the first, to keep all digits."""
        if self._start_ns is None:
            self._start_ns = at_ns
        return {"pid": row, "tid": lane, "ts": (at_ns - self._start_ns) / 1000}

    def _put(self, event: dict[str, Any]) -> None:
        self._lines.add(f"{',' if self._events else ''}{json.dumps(event)}\n")
        self._events += 1

    def close(self) -> None:
        """Add the last refresh and end the file. Errors: as Lines.close."""
        self._end_refresh(None)
        self._lines.add("]\n")
        self._lines.close()

    def __enter__(self) -> TraceEvents:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
            return
        with suppress(Exception):  # the exception that ended the run matters more
            self.close()
        with suppress(OSError):
            self._path.unlink()
