"""Scales with their items and scores: a rating, a sickness score or a questionnaire."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, Self

import attrs

from ...errors import InputError, unknown_name

KINDS = (RATING, SICKNESS, QUESTIONNAIRE, PREFERENCE) = ("rating", "sickness", "questionnaire", "preference")
# Answers to a preference, and so the numbers of its choices.
FIRST, SECOND, NEITHER = 1.0, 2.0, 3.0
OF = (SUMS, SCORES) = ("sums", "scores")
OWN_ANSWERS = (CHOICE, NUMBER, WORDS) = ("choice", "number", "text")


@attrs.frozen
class Item:
    """One question of a scale."""

    key: str  # its name in tables
    text: str  # the question in words
    # One of OWN_ANSWERS, for a question of a questionnaire that has answers of its own; "" for
    # those of its scale.
    answer: str = ""
    choices: tuple[str, ...] = ()  # the answer is the number of one, from 1 on
    least: float = 0.0  # of a number
    most: float = 0.0
    step: float = 1.0
    anchors: Mapping[float, str] = attrs.field(factory=dict, hash=False)  # in place of the scale's
    is_reversed: bool = False  # whether scores count it from the other end

    @property
    def described(self) -> str:
        """The question, with what differs from the other questions of its scale."""
        own = [f"{value:g} = {words}" for value, words in self.anchors.items()]
        own += ["reversed"] if self.is_reversed else []
        return f"{self.text} ({'; '.join(own)})" if own else self.text


@attrs.frozen
class Score:
    """A score of a questionnaire: a weighted sum of answers, or of other scores."""

    name: str
    items: tuple[int, ...] = ()  # numbers of the items that are summed, counted from 1
    of: tuple[str, ...] = ()  # names of the scores that are summed instead of items
    weight: float = 1.0
    of_what: str = SUMS  # what `of` sums: "sums" before their weights, or weighted "scores"
    title: str = ""


@attrs.frozen
class Scale:
    """Rating, sickness scale, questionnaire or preference; its fields are what its file says."""

    name: str  # the stem of its file
    title: str
    kind: str  # one of KINDS
    items: tuple[Item, ...]  # exactly one for a rating or a preference
    least: float  # lowest answer
    most: float  # highest answer
    step: float  # distance between two answers
    low_is_good: bool
    anchors: Mapping[float, str] = attrs.field(factory=dict, hash=False)  # words for some answers
    scores: tuple[Score, ...] = ()  # of a questionnaire
    units: str = ""  # for tables; "" for a plain number
    source: str = ""  # the paper or standard it comes from
    prompt: str = ""  # the question about every item; "" where the items are questions themselves
    # Whether a rating is of the difference from the reference, which is shown right before.
    beside_reference: bool = False

    def values(self) -> tuple[float, ...]:
        """Return every possible answer, from least to most."""
        count = round((self.most - self.least) / self.step) + 1
        return tuple(round(self.least + k * self.step, 9) for k in range(count))

    def badness(self, answer: float) -> float:
        """Return how bad an answer is, in units of the scale: 0 is the best answer, high is bad."""
        return answer - self.least if self.low_is_good else self.most - answer

    @property
    def direction(self) -> str:
        """Which answers are good, in words; "" where each question has answers of its own."""
        return "" if not self.has_answers else f"{'low' if self.low_is_good else 'high'} is good"

    @property
    def allows_ties(self) -> bool:
        """Whether a preference may be for neither."""
        return self.kind == PREFERENCE and len(self.items[0].choices) >= NEITHER

    @property
    def has_answers(self) -> bool:
        """Whether any question has the answers of the scale and not its own."""
        return any(not item.answer for item in self.items)

    def of(self, item: Item) -> Self:
        """Return the scale of one item's answers; itself where the item has none of its own."""
        if item.answer == CHOICE:
            words = {float(number): text for number, text in enumerate(item.choices, 1)}
            return attrs.evolve(self, least=1.0, most=float(len(words)), step=1.0, anchors=words)
        if item.answer == NUMBER:
            return attrs.evolve(self, least=item.least, most=item.most, step=item.step, anchors={})
        return attrs.evolve(self, anchors=item.anchors) if item.anchors else self

    def words_for(self, item: Item, value: float | None, text: str) -> str | None:
        """Return an answer of the item's own in words: the choice, or what was typed; else None."""
        if item.answer == CHOICE and value is not None:
            return item.choices[round(value) - 1]
        return text or None


class AnswerRange(Protocol):
    """Anything with a least and a most answer and a step between two."""

    @property
    def least(self) -> float: ...

    @property
    def most(self) -> float: ...

    @property
    def step(self) -> float: ...


def number_text(number: float) -> str:
    """Return the number as people write it, without trailing zeros."""
    return f"{number:.9f}".rstrip("0").rstrip(".")


def range_text(answers: AnswerRange) -> str:
    """Return which answers there are: "1 to 6 in steps of 0.25"."""
    steps = f" in steps of {number_text(answers.step)}" if answers.step != 1 else ""
    return f"{number_text(answers.least)} to {number_text(answers.most)}{steps}"


def scored(scale: Scale, answers: Mapping[str, float | None]) -> dict[str, float | None]:
    """Compute every score of the scale from answers by item key; None where an answer is missing.

    Errors: InputError for an unknown item, or an answer outside the scale.
    """
    known = {item.key: item for item in scale.items}
    for key, value in answers.items():
        if key not in known:
            raise unknown_name(f"item of scale '{scale.name}'", key, list(known))
        own = scale.of(known[key])
        if value is not None and not own.least <= value <= own.most:
            where = f"scale '{scale.name}', item '{key}'"
            raise InputError(f"{where}: {value:g}: expected an answer from {own.least:g} to {own.most:g}")
    values = [_counted(scale, item, answers.get(key)) for key, item in known.items()]
    sums: dict[str, float | None] = {}
    scores: dict[str, float | None] = {}
    for score in scale.scores:
        of = scores if score.of_what == SCORES else sums
        parts = [of[name] for name in score.of] if score.of else [values[n - 1] for n in score.items]
        present = [part for part in parts if part is not None]
        total = sum(present) if len(present) == len(parts) else None
        sums[score.name] = total
        scores[score.name] = None if total is None else total * score.weight
    return scores


def _counted(scale: Scale, item: Item, answer: float | None) -> float | None:
    """Return what an answer counts in scores."""
    return scale.least + scale.most - answer if item.is_reversed and answer is not None else answer


def score_ranges(scale: Scale) -> tuple[dict[str, float | None], dict[str, float | None]]:
    """Return the least and the most that every score can be; None where no answers give it."""
    items = [item for item in scale.items if not item.answer]
    low = {item.key: scale.most if item.is_reversed else scale.least for item in items}
    high = {item.key: scale.least if item.is_reversed else scale.most for item in items}
    return scored(scale, low), scored(scale, high)
