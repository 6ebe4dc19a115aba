"""What an experiment runs: pictures of one motion at a few instants, or a stream of frames."""

from __future__ import annotations

from typing import Any

import attrs

from ...link.codec import EXACT

# Of the head, in m/s; of its rotation, in deg/s. 30 and 113 are the median and the 95th percentile
# of recorded heads.
SPEEDS_M_S = (0.25, 0.5, 1.0)
SPEEDS_DEG_S = (30.0, 60.0, 113.0)
USUAL_M_S, USUAL_DEG_S = 0.5, 60.0
LATENCIES_MS = (200.0, 400.0, 600.0)
RATED_MS = (200.0, 400.0, 800.0)  # of the ratings
FULL_SIZE = (1280, 800)
ROTATE = "rotate"
RATE_HZ = 60.0
# All latencies show the same instants, at which the head has moved at full speed for the longest of
# them: between the ease at the start and the turn. 1.2 m of `room` are free at 1 m/s.
ONE_WAY_S, TRACE_S = 1.2, 2.0


@attrs.frozen
class Motion:
    """A motion of one kind at a steady speed."""

    kind: str
    # m/s, or deg/s for ROTATE.
    speed: float

    def __str__(self) -> str:
        return f"{self.kind} {self.speed:g} {'deg/s' if self.kind == ROTATE else 'm/s'}"

    @property
    def amplitude(self) -> float:
        """Return how far it goes before it turns back, in m or degrees."""
        return self.speed * ONE_WAY_S


@attrs.frozen(kw_only=True)
class PictureRun:
    """One warp and fill on frames of one age, looked at while the head moves at full speed."""

    motion: Motion
    latency_ms: float
    warp: str = "forward"
    fill: str = "none"
    # Factors of the rendered picture's pixels on both axes.
    guard: tuple[float, float] = (1.0, 1.0)
    scene: str = "room"
    effects: str = "auto"
    # Of each side of the picture.
    scale: float = 1.0
    # Whether the passes are timed and the change from picture to picture is measured.
    timed: bool = False
    flickers: bool = False

    def __str__(self) -> str:
        more = [word for word, is_so in (("timed", self.timed), ("flicker", self.flickers)) if is_so]
        side = [] if self.scale == 1 else [f"sides times {self.scale:.3g}"]
        return ", ".join([self.caption, self.scene, *side, *more])

    @property
    def shared(self) -> tuple[Any, ...]:
        """What runs have in common that are measured on the same frames."""
        return (self.scene, self.effects, self.motion, self.latency_ms, self.guard, self.scale)

    @property
    def caption(self) -> str:
        """What its picture shows."""
        fill = "" if self.fill == "none" else f" + {self.fill}"
        more = [
            *([f"rendered {size_text(self.guard)} for {size_text((1.0, 1.0))}"] if self.guard != (1.0, 1.0) else []),
            *([f"effects {self.effects}"] if self.effects != "auto" else []),
        ]
        return ", ".join([f"{self.motion}, {self.latency_ms:g} ms: {self.warp}{fill}", *more])


@attrs.frozen(kw_only=True)
class StreamRun:
    """Frames that are coded and sent: what they weigh and how long they take."""

    warp: str = "none"
    codec: str = "h264"
    depth: str = EXACT  # the code of depth
    size: tuple[int, int] = FULL_SIZE
    latency_ms: float = 100.0
    trace: str = "walk"
    # Mbit/s of the link; then rendering, encoding and decoding delay a frame as well.
    bandwidth_mbit: float | None = None

    def __str__(self) -> str:
        link = "" if self.bandwidth_mbit is None else f" {self.bandwidth_mbit:g} Mbit/s,"
        code = "" if self.depth == EXACT else f", depth as {self.depth}"
        return f"{'x'.join(map(str, self.size))}, {self.codec},{link} {self.latency_ms:g} ms, {self.warp}{code}"

    @property
    def caption(self) -> str:
        """What its time line shows."""
        size = "x".join(map(str, self.size))
        return f"way of the last frames: {size}, {self.codec}, {self.bandwidth_mbit:g} Mbit/s, {self.latency_ms:g} ms"


@attrs.frozen(kw_only=True)
class RatingsRun:
    """The ratings that the thesis published: warped against late pictures in one part."""

    part: str
    latency_ms: float

    def __str__(self) -> str:
        return f"published ratings, {self.part}, {self.latency_ms:g} ms"


@attrs.frozen(kw_only=True)
class FactRun:
    """A number of this program that the thesis has too: see FACTS of run_figures."""

    fact: str

    def __str__(self) -> str:
        return f"fact {self.fact}"


Run = PictureRun | StreamRun | RatingsRun | FactRun
Figures = dict[str, float | None]


def size_text(guard: tuple[float, float]) -> str:
    """Return the rendered picture's pixels for FULL_SIZE."""
    return "x".join(str(round(side * factor)) for side, factor in zip(FULL_SIZE, guard, strict=True))


def motions(*kinds: str) -> tuple[Motion, ...]:
    """Return each kind at each of its speeds, the slowest first."""
    return tuple(Motion(kind, speed) for kind in kinds for speed in (SPEEDS_DEG_S if kind == ROTATE else SPEEDS_M_S))


def is_quick(run: Run) -> bool:
    """Return whether --quick keeps the run: of the pictures those at the middle speed."""
    return not isinstance(run, PictureRun) or run.motion == usual(run.motion.kind)


def usual(kind: str) -> Motion:
    """Return a kind at its middle speed."""
    return Motion(kind, USUAL_DEG_S if kind == ROTATE else USUAL_M_S)
