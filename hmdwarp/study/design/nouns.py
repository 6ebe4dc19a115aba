"""The nouns of a plan. All are frozen; study/design/read.py makes them from a file and says what is wrong in it."""

from __future__ import annotations

from collections.abc import Mapping

import attrs

from ..scales import Scale

ORDERS = (WILLIAMS, RANDOM, FIXED) = ("williams", "random", "fixed")
BLIND = (BOTH, PARTICIPANT, NOBODY) = ("both", "participant", "nobody")


@attrs.frozen
class Condition:
    """name: as tables and comparisons call it. settings: options of `hmdwarp live`, as the file has them, its [common] ones included.
    reference: whether it is the hidden reference: shown and rated like the others, known to the analysis alone.
    """

    name: str
    settings: Mapping[str, object] = attrs.field(factory=dict, hash=False)
    reference: bool = False


@attrs.frozen
class Part:
    """What one session shows: the thesis had two "runs", each with people of its own."""

    name: str
    conditions: tuple[Condition, ...]

    def condition(self, name: str) -> Condition:
        """The one of that name. Errors: KeyError."""
        return next(one for one in self.conditions if one.name == name)


@attrs.frozen
class Breaks:
    """every: trials between two breaks, 0 for none. seconds: how long at least."""

    every: int = 0
    seconds: float = 0.0


@attrs.frozen
class Sickness:
    """scale: asked after every `every`-th trial and after the practice. stop_at: an answer that bad ends the session; in the scale's own
    direction. rise: so does one worse by that much than the first answer of the session; None for no such rule.
    """

    scale: Scale
    every: int = 1
    stop_at: float | None = None
    rise: float | None = None


@attrs.frozen
class Consent:
    """version: of the text, kept with each session. text: what is read before anything else; its hash is kept as well."""

    version: str
    text: str


@attrs.frozen
class Comparison:
    """Of two conditions of a part. The difference is a minus b, turned so that positive means b was rated better."""

    part: str
    a: str
    b: str


@attrs.frozen
class Family:
    """Comparisons that Holm's correction is made over."""

    name: str
    comparisons: tuple[Comparison, ...]


@attrs.frozen
class Design:
    """A study.

    text: the file as it was read, which every session keeps. seconds: each trial shows its condition for so long. repeats: how often each
    condition comes. order: how their orders are made. scales: asked after each trial, in this order. practice: shown first and not
    scored, None for none. blind: who must not see which condition is on. before, after: questionnaires around the session.
    """

    name: str
    title: str
    parts: tuple[Part, ...]
    scales: tuple[Scale, ...]
    families: tuple[Family, ...] = ()
    seconds: float = 20.0
    repeats: int = 1
    order: str = WILLIAMS
    seed: int = 0
    blind: str = BOTH
    practice: Condition | None = None
    practice_seconds: float = 60.0
    breaks: Breaks = Breaks()
    sickness: Sickness | None = None
    before: tuple[Scale, ...] = ()
    after: tuple[Scale, ...] = ()
    consent: Consent | None = None
    text: str = attrs.field(default="", repr=False)
    path: str = ""

    def part(self, name: str) -> Part:
        """The part of that name. Errors: KeyError."""
        return next(one for one in self.parts if one.name == name)
