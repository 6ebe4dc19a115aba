"""Definition of a study: parts, conditions, scales, comparisons. All classes are frozen."""

from __future__ import annotations

from collections.abc import Mapping

import attrs

from ..scales import Scale

ORDERS = (WILLIAMS, RANDOM, FIXED, ADAPTIVE) = ("williams", "random", "fixed", "adaptive")
SHOWS = (ONE, PAIR, REFERENCE_FIRST) = ("one", "pair", "reference first")
BLIND = (BOTH, PARTICIPANT, UNBLINDED) = ("both", "participant", "nobody")
ONLY_PART = "main"  # name of the part in a study without [[part]]


@attrs.frozen
class Condition:
    """What a trial shows."""

    name: str  # in tables and comparisons
    # Options of `hmdwarp live`, as the file has them, those of [common] included.
    settings: Mapping[str, object] = attrs.field(factory=dict, hash=False)
    # The hidden reference is shown and rated like the others; only the analysis knows it.
    reference: bool = False


@attrs.frozen
class Part:
    """What one session shows: the thesis had two "runs", each with its own participants."""

    name: str
    conditions: tuple[Condition, ...]

    def condition(self, name: str) -> Condition:
        """Return the condition of that name. Errors: StopIteration."""
        return next(condition for condition in self.conditions if condition.name == name)


@attrs.frozen
class Breaks:
    """Breaks between trials."""

    every: int = 0  # trials between two breaks; 0 for none
    seconds: float = 0.0  # at least


@attrs.frozen
class Sickness:
    """When to ask for sickness, and which answer ends the session."""

    scale: Scale  # asked after the practice too
    every: int = 1  # trials between two questions
    stop_at: float | None = None  # an answer that bad ends the session; in the scale's own direction
    rise: float | None = None  # so does one worse by that much than the session's first answer


@attrs.frozen
class Consent:
    """Text that participants read before anything else; the store keeps its hash."""

    version: str  # kept with each session
    text: str


@attrs.frozen
class Page:
    """Page that participants read: a text or a picture."""

    title: str
    text: str = ""
    picture: str = ""  # path of a PNG or JPEG file, "" for a text


@attrs.frozen
class Task:
    """Targets to find and to select in a trial: an objective score in addition to the rating."""

    count: int  # targets in a trial
    size_deg: float  # of each, as seen from the scene's viewpoint
    seed: int = 0  # of their places, which are others in each trial of a session
    conditions: tuple[str, ...] = ()  # in whose trials; all of them where empty


@attrs.frozen
class Comparison:
    """Two conditions of a part; a positive difference means that `better` was rated better."""

    part: str
    baseline: str
    better: str


@attrs.frozen
class Family:
    """Comparisons that Holm's correction is made over."""

    name: str
    comparisons: tuple[Comparison, ...]


@attrs.frozen
class Design:
    """A study."""

    name: str
    title: str
    parts: tuple[Part, ...]
    scales: tuple[Scale, ...]  # asked after each trial, in this order
    families: tuple[Family, ...] = ()
    seconds: float = 20.0  # a trial shows its condition for so long, or at most so long
    until_done: bool = False  # whether the participant ends a trial
    shows: str = ONE  # one of SHOWS: what a trial shows before the questions
    repeats: int = 1  # presentations of each condition, or pair
    order: str = WILLIAMS  # one of ORDERS
    seed: int = 0
    blind: str = BOTH  # one of BLIND: who must not see the condition
    task: Task | None = None  # in the practice too
    practice: Condition | None = None  # shown first and not scored
    practice_seconds: float = 60.0
    breaks: Breaks = Breaks()
    sickness: Sickness | None = None
    before: tuple[Scale, ...] = ()  # questionnaires before the session
    after: tuple[Scale, ...] = ()  # questionnaires after the session
    consent: Consent | None = None
    instructions: Page | None = None  # before the practice and the trials
    ready: Page | None = None  # in place of the usual words before the first trial
    thanks: Page | None = None  # at the end of a complete session
    text: str = attrs.field(default="", repr=False)  # the file as it was read; every session keeps it
    path: str = ""
    scene_notes: tuple[str, ...] = ()  # what had to be left out or replaced of scene files

    def part(self, name: str) -> Part:
        """Return the part of that name. Errors: StopIteration."""
        return next(part for part in self.parts if part.name == name)


def every_scale(design: Design) -> tuple[Scale, ...]:
    """Return all scales of a study, each once."""
    sickness = () if design.sickness is None else (design.sickness.scale,)
    return tuple({scale.name: scale for scale in (*design.scales, *sickness, *design.before, *design.after)}.values())
