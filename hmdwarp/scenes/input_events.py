"""What people do in a scene: pushes, switches and grabs, by file, by seed and by hand.

A scene that reacts is a function of them: its state at an instant follows from those up to then.
"""

from __future__ import annotations

import math
import random
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ..base import InputError, unknown_name
from .options import SEED, seed_of

ACTIONS = PUSH, SWITCH, GRAB, RELEASE = ("push", "switch", "grab", "release")
INPUT_COLUMNS = ("time_ns", "action", "target", "x", "y", "z", "dx", "dy", "dz")
# Of a seed: mean time between two inputs, which come as those of a Poisson process.
EVERY_S = 0.7
# A ray means a thing if it passes this close to its handle.
_AIM_RAD = math.radians(15)
# Length of a direction, at least: squares of it are normal numbers.
LEAST_WAY = 1e-9
_TIME = attrgetter("time_ns")
Triple = tuple[float, float, float]


@attrs.frozen
class InputEvent:
    """One input: what is done, to what, and the ray of the hand that does it, in the world."""

    time_ns: int
    action: str
    target: str = ""  # name of a thing that reacts; "" for the one that the ray means
    origin_m: Triple = (0.0, 0.0, 0.0)
    direction: Triple = (0.0, 0.0, -1.0)

    def __attrs_post_init__(self) -> None:
        if self.action not in ACTIONS:
            raise unknown_name("action", self.action, list(ACTIONS))
        numbers = (*self.origin_m, *self.direction)
        if not all(map(math.isfinite, numbers)) or not LEAST_WAY <= math.hypot(*self.direction) <= 1 / LEAST_WAY:
            found = f"a hand at {self.origin_m} that points along {self.direction}"
            lengths = f"a length from {LEAST_WAY:g} to {1 / LEAST_WAY:g}"
            raise InputError(f"{found}: expected finite numbers, and a direction of {lengths}")

    @property
    def ray(self) -> tuple[Triple, Triple]:
        return self.origin_m, self.direction

    @property
    def row(self) -> str:
        numbers = map(repr, map(float, (*self.origin_m, *self.direction)))
        return ",".join([str(self.time_ns), self.action, self.target, *numbers]) + "\n"


INPUTS_HEADER = ",".join(INPUT_COLUMNS) + "\n"


@attrs.define(eq=False)
class InputBook:
    """What was done in a scene, and the states that follow: one for each of its histories."""

    # Of each thing, oldest first.
    events: dict[str, list[InputEvent]] = attrs.field(factory=lambda: defaultdict(list))
    # Of each thing: at rest, and after each of its inputs as far as that was needed.
    states: dict[str, list[Any]] = attrs.field(factory=lambda: defaultdict(list))

    def __len__(self) -> int:
        return sum(map(len, self.events.values()))


class InputLog:
    """The inputs of one scene, in the order of their instants, however they came."""

    def __init__(self) -> None:
        self.things: dict[str, Any] = {}  # what reacts (motions.Reacting), by the names that inputs have
        self.book = InputBook()  # of whom the scene is drawn for; another one is another history

    def add(self, event: InputEvent) -> InputEvent | None:
        """Add an input; return it with its target, None where its ray means nothing that takes it.

        One that is there already is left out. Errors: UnknownNameError for a target that does not
        react, InputError for one that does not take the action.
        """
        target = event.target or self._meant(event)
        if not target:
            return None
        if target not in self.things:
            raise unknown_name("thing that reacts", target, list(self.things))
        if event.action not in self.things[target].takes:
            wanted = " or ".join(self.things[target].takes)
            raise InputError(f"{event.action} '{target}': expected {wanted} of what it takes")
        event, events = attrs.evolve(event, target=target), self.book.events[target]
        if event in events[bisect_right(events, event.time_ns - 1, key=_TIME) :]:
            return event
        at = bisect_right(events, event.time_ns, key=_TIME)
        events.insert(at, event)
        del self.book.states[target][at + 1 :]
        return event

    def of(self, target: str, time_ns: int) -> tuple[Sequence[InputEvent], int]:
        """Return the inputs that name a thing, oldest first, and how many are up to an instant."""
        events = self.book.events[target]
        return events, bisect_right(events, time_ns, key=_TIME)

    def __iter__(self) -> Iterator[InputEvent]:
        return iter(sorted((event for events in self.book.events.values() for event in events), key=_TIME))

    def __len__(self) -> int:
        return len(self.book)

    def _meant(self, event: InputEvent) -> str:
        """Return the name of the thing that takes the action and is nearest to the ray, or "".

        A hand that holds something grabs that again, and releases it.
        """
        before = ((name, *self.of(name, event.time_ns)) for name in self.things)
        held = next((name for name, events, count in before if count and events[count - 1].action == GRAB), "")
        if event.action == RELEASE or (event.action == GRAB and held):  # wherever the hand points by then
            return held
        ray, found = np.array(event.direction), [(_AIM_RAD, "")]
        for name, thing in self.things.items():
            if event.action in thing.takes:
                way = thing.handle(event.time_ns) - event.origin_m
                off = math.atan2(float(np.linalg.norm(np.cross(ray, way))), float(ray @ way))
                found.append((off, name))
        return min(found)[1]


def take_inputs(log: InputLog, spec: str, span_ns: tuple[int, int], epoch_ns: int) -> int:
    """Add the inputs of `seed:N`, or those in a file; return how many mean nothing that takes them.

    span_ns: first and last instant of a seed's. epoch_ns: instant 0 of the run on the clock of the
    file. Errors: InputError that names the file, and the line or the input.
    """
    if spec.startswith(SEED):
        found: Iterable[InputEvent] = _by_seed(seed_of(spec), list(log.things.values()), *span_ns)
    else:
        read = [attrs.evolve(event, time_ns=event.time_ns - epoch_ns) for event in read_inputs(Path(spec))]
        found = sorted(read, key=_TIME)
    lost = 0
    for event in found:
        try:
            lost += log.add(event) is None
        except InputError as error:
            raise InputError(f"--input {spec}: {error}") from error
    return lost


def _by_seed(seed: int, things: Sequence[Any], start_ns: int, end_ns: int) -> Iterator[InputEvent]:
    """Yield pushes and switches, EVERY_S apart in the mean: each thing as often, any way level."""
    chance, now_s = random.Random(seed), 0.0
    while things:
        now_s -= EVERY_S * math.log(1.0 - chance.random())
        time_ns = start_ns + round(now_s * 1e9)
        if time_ns > end_ns:
            return
        thing, angle = things[int(chance.random() * len(things))], 2 * math.pi * chance.random()
        yield InputEvent(time_ns, thing.takes[0], thing.name, direction=(math.cos(angle), 0.0, math.sin(angle)))


def inputs_beside(trace: Path) -> Path:
    return trace.with_suffix(".input.csv")


def read_inputs(path: Path) -> list[InputEvent]:
    """Return the inputs in a file, in the order of its lines, which may be any.

    Columns after INPUT_COLUMNS are left out.
    Errors: InputError that names the file, the line and the value.
    """
    try:
        lines = path.read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "it holds bytes that are no text"
        raise InputError(f"{path}: cannot read inputs ({why}): expected a CSV file, or --input seed:N") from error
    rows = [(number, line.strip()) for number, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    if not rows or rows[0][1].split(",")[: len(INPUT_COLUMNS)] != [*INPUT_COLUMNS]:
        found = f"'{rows[0][1][:60]}'" if rows else "nothing"
        raise InputError(f"{path}: begins with {found}: expected {INPUTS_HEADER.strip()}")
    events = []
    for number, text in rows[1:]:
        values = text.split(",")[: len(INPUT_COLUMNS)]
        try:
            if len(values) < len(INPUT_COLUMNS):
                raise InputError(f"{len(values)} values: expected {len(INPUT_COLUMNS)}")
            x, y, z, *way = map(float, values[3:])
            events.append(InputEvent(int(values[0]), values[1], values[2], (x, y, z), (way[0], way[1], way[2])))
        except (ValueError, InputError) as error:
            numbers = "expected whole nanoseconds, an action, a target and six numbers"
            said = error if isinstance(error, InputError) else numbers
            raise InputError(f"{path}, line {number}: '{text[:80]}': {said}") from error
    return events
