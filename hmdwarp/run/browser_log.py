"""What browsers say of their sessions: the same summary.json and report as of a live run.

A page sends a line of JSON about its display, then rows of numbers, see docs/web.md. Both come from
a stranger: every value is checked, and how much is written is bounded.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import HmdwarpError, counted
from ..geometry import Pose
from ..headsets import headset_toml
from ..link import ResponseTime, TransitStats, figures_of_parts
from ..poses import Origin, PoseSample
from ..report import POSE_PARTS, OutputFolder, render_live_report
from .browser_bench import MOST_TEXT as MOST_OF_BENCH
from .browser_bench import BrowserBench, write_bench
from .browser_display import FILL, MOST_TEXT, BadLog, BrowserDisplay, facts_of, said_in
from .frame_rows import HEADER, NOT_KNOWN, Moment, Timeline, rows_text, speeds_between
from .live_figures import LiveFigures, Thinned
from .live_summary import live_summary_of
from .recorder import Lines, Recorder
from .run_summary import OWNED

COLUMNS = (
    *("shown_ms", "asked_ms", "frame", "chain", "warp_ms", "script_ms", "render_ms", "decode_ms", "round_ms"),
    *(f"{which}_{part}" for which in ("shown", "drawn") for part in POSE_PARTS),
)
_MOST_SESSIONS, _MOST_REFRESHES = 1000, 1 << 19  # of a server, and of a session: 97 minutes at 90 Hz
_LEAST_REFRESHES = 2
_MOST_MS, _MOST_M = 1e9, 1e7
_RESPONSE = tuple(ResponseTime().parts())
_SENT = ("took_ms", "drawing_ms")  # of a message: since its request came, and of those drawing and coding
_MOST_SENT = 1024  # messages between two reports


def rows_of(data: bytes, after_ms: float, chains: int) -> NDArray[np.float64]:
    """Return a message's rows under COLUMNS. Errors: BadLog for what no session can have.

    after_ms: when the last refresh before them was shown.
    """
    if not data or len(data) % (8 * len(COLUMNS)):
        raise BadLog(f"{len(data)} bytes: expected rows of {8 * len(COLUMNS)}")
    rows = np.frombuffer(data, "<f8").reshape(-1, len(COLUMNS))
    times, poses = rows[:, :9], rows[:, 9:].reshape(-1, 2, 7)
    in_range = np.isfinite(rows).all() and (times >= 0).all() and (times <= _MOST_MS).all()
    if not (in_range and (np.abs(poses[..., :3]) <= _MOST_M).all()):
        raise BadLog("a number out of range")
    if not (np.diff(rows[:, 0], prepend=after_ms) > 0).all() or (rows[:, 1] > rows[:, 0]).any():
        raise BadLog("times that go back, or a frame from the future")
    if (rows[:, 2:4] % 1).any() or (rows[:, 3] >= chains).any():
        raise BadLog("a frame's or chain's number that is none")
    if (np.abs(np.linalg.norm(poses[..., 3:], axis=-1) - 1) > 1e-6).any():
        raise BadLog("an orientation that is no unit quaternion")
    return rows


@attrs.frozen(eq=False)
class _Shown:
    """A refresh, as far as a browser says."""

    shown_ns: int
    head: PoseSample
    transit: TransitStats


class _Session:
    """One display's session: a folder as of a live run, with what a replay of it takes."""

    def __init__(self, display: BrowserDisplay, folder: Path, scene: str, command: str) -> None:
        self.display, self._facts, self._command = display, facts_of(display, scene), command
        self._figures, self._timeline, self._responses = LiveFigures(), Timeline(), Thinned(_RESPONSE)
        self._sent, self._bytes = Thinned(_SENT), 0
        self._out = OutputFolder(folder, owned=(*OWNED, "trace.csv", "headset.toml"))
        self._ending = ExitStack()
        self._rows = Lines(self._out.path("frames.csv"))
        self._rows.add(HEADER)
        self._trace = self._ending.enter_context(Recorder(self._out.path("trace.csv"), by="hmdwarp serve --web"))
        self._trace.begin({"browser": display.browser}, display.rate_hz)
        self._delays = ["delay_ms\n"]
        self.count, self.last_ms, self._first_ns = 0, -math.inf, 0
        self._last: _Shown | None = None

    def take(self, data: bytes) -> None:
        """Add a message's refreshes; those beyond the limit are left out. Errors: BadLog."""
        rows = rows_of(data, self.last_ms, len(self.display.chains))
        for row in rows[: _MOST_REFRESHES - self.count]:
            self._add(dict(zip(COLUMNS, row.tolist(), strict=True)))
        self.last_ms = float(rows[-1, 0])

    def sent(self, took_ms: float, drawing_ms: float, size: int) -> None:
        """Note a message that was sent to the page."""
        self._sent.add((took_ms, drawing_ms))
        self._bytes += size

    def _add(self, row: Mapping[str, float]) -> None:
        shown_ns, asked_ns = round(row["shown_ms"] * 1e6), round(row["asked_ms"] * 1e6)
        parts = {"render_ns": row["render_ms"], "decode_ns": row["decode_ms"]}
        way = max(0.0, row["round_ms"] - row["render_ms"])
        parts |= {"delay_ns": way, "hold_ns": max(0.0, row["shown_ms"] - row["asked_ms"] - way - sum(parts.values()))}
        transit = TransitStats(int(row["frame"]), asked_ns, **{name: round(ms * 1e6) for name, ms in parts.items()})
        before = self._last
        if before is not None and before.transit.number == transit.number:
            transit = before.transit
        else:
            self._delays.append(f"{row['shown_ms'] - row['asked_ms']!r}\n")
        self._first_ns = self._first_ns if self.count else shown_ns
        now = _Shown(shown_ns, PoseSample(shown_ns, _pose(row, "shown"), Origin.MEASURED), transit)
        self._note(now, row, PoseSample(asked_ns, _pose(row, "drawn"), Origin.MEASURED))
        self._last, self.count = now, self.count + 1

    def _note(self, now: _Shown, row: Mapping[str, float], drawn: PoseSample) -> None:
        """Add a refresh to the files and figures of a live run."""
        age_ms, eyes, warp = row["shown_ms"] - row["asked_ms"], self.display.eyes, row["warp_ms"]
        speeds, period_ms = speeds_between(self._last, now), math.nan
        if self._last is not None:
            period_ms = (now.shown_ns - self._last.shown_ns) * 1e-6
            self._miss(period_ms, speeds[0] or 0.0)
        self._figures.misses.add(False, 0.0)
        moment = Moment(
            frame=self.count,
            time_s=(now.shown_ns - self._first_ns) * 1e-9,
            shown_ns=now.shown_ns,
            drawn_ns=drawn.time_ns,
            shows_ns=drawn.time_ns,
            age_ms=age_ms,
            pose_age_ms=row["script_ms"],
            speeds=speeds,
            shown=now.head,
            drawn=drawn,
            warp=self.display.chains[int(row["chain"])],
            fill=FILL,
            eyes=eyes,
        )
        # The pyramid is in the time of the warp: a browser measures a chain as a whole.
        stages = [[warp, 0.0, 0.0, 0.0, warp]] * eyes
        self._rows.add(rows_text(moment, stages, (None,) * eyes))
        self._trace.add(now.head)
        self._timeline.add(now)
        busy = warp * eyes
        self._figures.counts.busy(busy > 1e3 / self.display.rate_hz)
        numbers = [moment.time_s, age_ms, row["script_ms"], period_ms, *speeds, row["render_ms"], busy]
        numbers += [*stages[0], None, *(stages[0] if eyes == 2 else NOT_KNOWN), None]
        self._figures.times.add([math.nan if value is None else value for value in numbers])
        transit = now.transit
        response = (transit.hold_ns * 1e-6, 0.0, transit.delay_ns * 1e-6, transit.decode_ns * 1e-6, busy)
        self._responses.add((transit.render_ns * 1e-6, 0.0, *response))

    def _miss(self, period_ms: float, deg_s: float) -> None:
        """Count refreshes that showed the last picture again, off by how far the head turned."""
        rate_hz = self.display.rate_hz
        missed = min(round(period_ms * rate_hz / 1e3) - 1, _MOST_REFRESHES)
        for late in range(missed):
            self._figures.misses.add(True, deg_s * (1 + late) / rate_hz)
        self._figures.counts.missed += max(missed, 0)

    def close(self) -> str:
        """Write the results; return a line for the log. Errors: as OutputFolder."""
        with self._ending:
            self._rows.close()
        if self.count < _LEAST_REFRESHES:
            self._out.discard()
            return ""
        summary = self._summary()
        self._out.write_text("delays.csv", "".join(self._delays))
        self._out.write_text("headset.toml", headset_toml(self.display.headset))
        page = render_live_report(summary, self._figures.times.column, command=self._command)
        self._out.write_text("report.html", page)
        self._out.write_json("summary.json", summary)
        self._out.commit()
        return f"a browser's session, {counted(self.count, 'refresh')}: {self._out.folder}"

    def _summary(self) -> dict[str, Any]:
        summary = live_summary_of(self._facts, self.count, self._figures, None)
        responses = np.column_stack([self._responses.column(name) for name in _RESPONSE])
        summary["link"] = {
            "frames": {"shown": len(self._delays) - 1},
            "response": "sum",
            "response_ms": figures_of_parts(responses),
            "timeline": self._timeline.as_list(),
            "codec": self.display.codec,
            "mbit_s": 8e-6 * self._bytes / max(summary["live"]["seconds"], 1e-3),
            "server": self._server_figures(),
        }
        return summary

    def _server_figures(self) -> dict[str, float]:
        """Return medians of what a request takes here, and of that beside drawing and coding."""
        took, drawing = (self._sent.column(name) for name in _SENT)
        if not (drawing > 0).any():
            return {}
        own = (took - drawing)[drawing > 0]
        medians = {"took_ms": took, "drawing_ms": drawing, "own_ms": own, "own_share": own / drawing[drawing > 0]}
        return {name: float(np.median(values)) for name, values in medians.items()}


def _pose(row: Mapping[str, float], which: str) -> Pose:
    values = [row[f"{which}_{part}"] for part in POSE_PARTS]
    return Pose(values[:3], values[3:])


class BrowserLogs:
    """The sessions of all browsers, in numbered folders of one.

    say: called with a line about each. Errors: InputError for a folder that cannot be written.
    """

    def __init__(self, folder: Path, scene: str, say: Callable[[str], None], command: str = "") -> None:
        self._folder, self._scene, self._say, self._command = folder, scene, say, command
        self._open: set[BrowserLog] = set()
        self._lock, self._numbers = threading.Lock(), iter(range(1, _MOST_SESSIONS + 1))
        OutputFolder(folder).discard()

    def begin(self) -> BrowserLog:
        """Return the log of a connection."""
        log = BrowserLog(self)
        self._open.add(log)
        return log

    def session(self, display: BrowserDisplay) -> _Session:
        """Begin a folder that is new. Errors: BadLog where there are too many."""
        return _Session(display, self._new("session"), self._scene, self._command)

    def bench(self, said: object) -> None:
        """Write what a page's bench found. Errors: BadLog; as OutputFolder."""
        found = BrowserBench.of(said)
        with OutputFolder(self._new("bench")) as out:
            write_bench(found, out, self._scene, self._command)
        self._say(f"a browser's bench, {counted(len(found.rows), 'row')}: {out.folder}")

    def _new(self, kind: str) -> Path:
        with self._lock:
            for count in self._numbers:
                if not (folder := self._folder / f"{kind}-{count:04d}").exists():
                    return folder
        raise BadLog(f"there were {_MOST_SESSIONS} sessions already")

    def refuse(self, error: Exception) -> None:
        """Say why a browser's report is not taken any more."""
        self._say(f"a browser's report is not taken: {error}")

    def ended(self, log: BrowserLog, session: _Session | None) -> None:
        """Write what a session has found; failures are said."""
        self._open.discard(log)
        try:
            line = session.close() if session is not None else ""
        except HmdwarpError as error:
            line = str(error)
        if line:
            self._say(line)

    def close(self) -> None:
        """Write all sessions that still go on."""
        for log in list(self._open):
            log.close()


class BrowserLog:
    """What one connection says; from one thread at a time."""

    def __init__(self, logs: BrowserLogs) -> None:
        self._logs, self._is_bad, self._lock = logs, False, threading.Lock()
        self._session: _Session | None = None
        self._sent: deque[tuple[float, float, int]] = deque(maxlen=_MOST_SENT)

    def sent(self, took_ms: float, drawing_ms: float, size: int) -> None:
        """Note a message that was sent to the page; from any thread."""
        self._sent.append((took_ms, drawing_ms, size))

    def take(self, data: str | bytes) -> None:
        """Take a line about the display, or refreshes on it; after a wrong one, none."""
        with self._lock:
            if self._is_bad:
                return
            try:
                self._take(data)
            except (BadLog, HmdwarpError) as error:
                self._is_bad = True
                self._logs.refuse(error)

    def _take(self, data: str | bytes) -> None:
        if isinstance(data, str):
            said = said_in(data, MOST_TEXT if '"bench"' not in data[:20] else MOST_OF_BENCH)
            if isinstance(said, dict) and set(said) == {"bench"}:
                self._logs.bench(said["bench"])
                return
            session = self._logs.session(BrowserDisplay.of(said))
            self._end()
            self._session = session
        elif self._session is None:
            raise BadLog("refreshes of no display")
        else:
            self._session.take(data)
            self._tell(self._session)

    def _tell(self, session: _Session) -> None:
        while self._sent:
            session.sent(*self._sent.popleft())

    def _end(self) -> None:
        session, self._session = self._session, None
        if session is not None:
            self._tell(session)
        self._logs.ended(self, session)

    def close(self) -> None:
        """Write the results; safe to call twice."""
        with self._lock:
            self._is_bad = True
            self._end()
