"""What a scale is: a rating, a sickness score, or a questionnaire of several items."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import attrs

KINDS = (RATING, SICKNESS, QUESTIONNAIRE) = ("rating", "sickness", "questionnaire")
OF = (SUMS, SCORES) = ("sums", "scores")


@attrs.frozen
class Item:
    """One question. key: as tables call it. text: as it is asked."""

    key: str
    text: str


@attrs.frozen
class Score:
    """What a questionnaire comes to: the sum of these items' answers times weight, items counted from 1. of: names of other scores that
    are added up instead: what they are the sums of (of_what "sums"), or themselves with their weights ("scores"). title: for people.
    """

    name: str
    items: tuple[int, ...] = ()
    of: tuple[str, ...] = ()
    weight: float = 1.0
    of_what: str = SUMS
    title: str = ""


@attrs.frozen
class Scale:
    """name: of its file. items: one for a rating. least, most, step: of an answer. low_is_good: its direction. anchors: words for some of
    its values. scores: what a questionnaire comes to. kind: "rating", "sickness" or "questionnaire". units: for
    tables, "" for a mere number. source: the paper. prompt: what is asked about each item, "" where the items are questions themselves.
    """

    name: str
    title: str
    kind: str
    items: tuple[Item, ...]
    least: float
    most: float
    step: float
    low_is_good: bool
    anchors: Mapping[float, str] = attrs.field(factory=dict, hash=False)
    scores: tuple[Score, ...] = ()
    units: str = ""
    source: str = ""
    prompt: str = ""

    def values(self) -> tuple[float, ...]:
        """Every answer there is, from least to most."""
        count = round((self.most - self.least) / self.step) + 1
        return tuple(round(self.least + k * self.step, 9) for k in range(count))

    def badness(self, answer: float) -> float:
        """How bad an answer is, in steps of the scale's own unit: high is bad, 0 is the best."""
        return answer - self.least if self.low_is_good else self.most - answer

    def with_scores(self, scores: tuple[Score, ...]) -> Self:
        """The same with these."""
        return attrs.evolve(self, scores=scores)
