"""Scales: one .toml file each, with anchors, direction and source."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import attrs

from ...base import InputError, Table, fields_in, parsed, quoted, read_by, reads, text_of, unknown_name

KINDS = (RATING, _SICKNESS, QUESTIONNAIRE, PREFERENCE) = ("rating", "sickness", "questionnaire", "preference")
# Answers to a preference, and so the numbers of its choices.
FIRST, SECOND, NEITHER = 1.0, 2.0, 3.0
OF = (SUMS, SCORES) = ("sums", "scores")
OWN_ANSWERS = (CHOICE, NUMBER, WORDS) = ("choice", "number", "text")
# Of a questionnaire whose questions all have answers of their own.
_NO_ANSWERS: dict[str, Any] = {"least": 0.0, "most": 0.0, "step": 1.0, "low_is_good": False}


@attrs.frozen
class Item:
    """One question of a scale."""

    key: str  # its name in tables
    text: str = attrs.field(metadata=reads(Table.line))  # the question in words
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
class _Score:
    """A score of a questionnaire: a weighted sum of answers, or of other scores."""

    name: str
    items: tuple[int, ...] = ()  # numbers of the items that are summed, counted from 1
    of: tuple[str, ...] = ()  # names of the scores that are summed instead of items
    weight: float = read_by(Table.number, default=1.0)
    of_what: str = SUMS  # what `of` sums: "sums" before their weights, or weighted "scores"
    title: str = read_by(Table.line, default="", required=True)


class Stepped:
    """Anything with a least and a most answer and a step between two."""

    __slots__ = ()
    least: float
    most: float
    step: float

    @property
    def last(self) -> int:
        """Number of steps from least to most."""
        return round((self.most - self.least) / self.step)

    def at(self, number: int) -> float:
        """Return the value after so many steps, within the ends."""
        return round(self.least + min(max(number, 0), self.last) * self.step, 9)

    def values(self) -> tuple[float, ...]:
        """Return every possible answer, from least to most."""
        return tuple(map(self.at, range(self.last + 1)))

    def value_of(self, number: float) -> float | None:
        """Return its own value for a number, which may be typed; None if it is none of them."""
        steps = (number - self.least) / self.step
        # The first test also refuses NaN.
        if not -_CLOSE <= steps <= self.last + _CLOSE or abs(steps - round(steps)) > _CLOSE:
            return None
        return self.at(round(steps))


_CLOSE = 1e-6  # of a step: typed numbers are decimal, values of a scale are multiples of its step


@attrs.frozen
class Scale(Stepped):
    """Rating, sickness scale, questionnaire or preference; its fields are what its file says."""

    name: str  # the stem of its file
    title: str = attrs.field(metadata=reads(Table.line))
    kind: str = attrs.field(metadata=reads(Table.word, KINDS))
    items: tuple[Item, ...]  # exactly one for a rating or a preference
    least: float  # lowest answer
    most: float  # highest answer
    step: float  # distance between two answers
    low_is_good: bool
    anchors: Mapping[float, str] = attrs.field(factory=dict, hash=False)  # words for some answers
    scores: tuple[_Score, ...] = ()  # of a questionnaire
    units: str = read_by(Table.line, default="")  # for tables; "" for a plain number
    # The paper or standard it comes from.
    source: str = read_by(Table.line, default="", required=True)
    prompt: str = read_by(Table.line, default="")  # about every item; "" where the items are questions themselves
    # Whether a rating is of the difference from the reference, which is shown right before.
    beside_reference: bool = read_by(Table.flag, default=False)

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


def number_text(number: float) -> str:
    """Return the number as people write it, without trailing zeros."""
    return f"{number:.9f}".rstrip("0").rstrip(".")


def range_text(answers: Stepped) -> str:
    """Return which answers there are: "1 to 6 in steps of 0.25"."""
    steps = f" in steps of {number_text(answers.step)}" if answers.step != 1 else ""
    return f"{number_text(answers.least)} to {number_text(answers.most)}{steps}"


def scored(scale: Scale, answers: Mapping[str, float | None]) -> dict[str, float | None]:
    """Compute every score from answers by key, None where one is missing. Errors: InputError."""
    known = {item.key: item for item in scale.items}
    for key, value in answers.items():
        if key not in known:
            raise unknown_name(f"item of scale '{scale.name}'", key, list(known))
        own = scale.of(known[key])
        if value is not None and not own.least <= value <= own.most:
            where = f"scale '{scale.name}', item '{key}'"
            raise InputError(f"{where}: {value:g}: expected an answer from {own.least:g} to {own.most:g}")

    def counts(item: Item) -> float | None:
        answer = answers.get(item.key)
        return scale.least + scale.most - answer if item.is_reversed and answer is not None else answer

    values, sums, scores = [counts(item) for item in scale.items], dict[str, float | None](), dict[str, float | None]()
    for score in scale.scores:
        of = scores if score.of_what == SCORES else sums
        parts = [of[name] for name in score.of] if score.of else [values[n - 1] for n in score.items]
        present = [part for part in parts if part is not None]
        total = sum(present) if len(present) == len(parts) else None
        sums[score.name] = total
        scores[score.name] = None if total is None else total * score.weight
    return scores


def score_ranges(scale: Scale) -> tuple[dict[str, float | None], dict[str, float | None]]:
    """Return the least and the most that every score can be; None where no answers give it."""
    items = [item for item in scale.items if not item.answer]
    low = {item.key: scale.most if item.is_reversed else scale.least for item in items}
    high = {item.key: scale.least if item.is_reversed else scale.most for item in items}
    return scored(scale, low), scored(scale, high)


FOLDER = Path(__file__).parent
_EXAMPLE = "the scale of docs/scales.md"
_MOST_VALUES = 10_000  # of one answer: no panel can tell more apart
_MOST_ITEMS = 500
MOST_CHOICES = 12  # rows of a list that a panel holds


def scale_names() -> list[str]:
    """Return the names of the shipped scales, sorted."""
    return sorted(p.stem for p in FOLDER.glob("*.toml"))


def load_scale(name: str, folder: Path | None = None) -> Scale:
    """Load a shipped scale by name, or a .toml file by path. Errors: InputError."""
    path = Path(name) if name.endswith(".toml") else FOLDER / f"{name}.toml"
    if not name.endswith(".toml") and name not in scale_names():
        raise unknown_name("scale", name, [*scale_names(), "FILE.toml"])
    text = text_of(path, f"a .toml file, or one of {', '.join(scale_names())}", folder)
    return parsed(text, path, lambda data: _scale(data, path.stem), _EXAMPLE)


def _scale(data: Table, name: str) -> Scale:
    found = fields_in(data, Scale)
    items = _items(data, own=found["kind"] in (QUESTIONNAIRE, PREFERENCE))
    one = items[0].answer == CHOICE and len(items[0].choices) in (2, 3)
    if found["kind"] == PREFERENCE and (len(items) != 1 or not one):
        raise data.fault(
            "item",
            f'is no preference: expected one [[item]] with answer = "{CHOICE}" and 2 choices, for the first and for '
            "the second of a pair, or 3, the last of them for neither",
        )
    answers = _NO_ANSWERS
    if "answer" in data or any(not item.answer for item in items):
        answer = data.table("answer")
        least, most = answer.number("least"), answer.number("most")
        answers = {"least": least, "most": most, "step": _step(answer, least, most)}
        answers |= {"low_is_good": answer.flag("low_is_good"), "anchors": _anchors(answer, least, most)}
    scores = data.tables("score")
    if scores and found["kind"] != QUESTIONNAIRE:
        raise data.fault("score", f"is for questionnaires: a {found['kind']} is its own score")
    made: list[_Score] = []
    for table in scores:
        made.append(_score(table, len(items), [score.name for score in made]))
    return Scale(name=name, items=items, **found, **answers, scores=tuple(made))


def _items(data: Table, own: bool) -> tuple[Item, ...]:
    """Read the questions. own: whether they may have answers of their own."""
    tables = data.tables("item")
    if not 1 <= len(tables) <= _MOST_ITEMS:
        wanted = f"expected 1 to {_MOST_ITEMS} questions, each beginning with [[item]]"
        raise data.fault("item", f"comes {len(tables)} times: {wanted}")
    items: list[Item] = []
    for table in tables:
        key = table.text("key")
        if not key.isidentifier():
            wanted = "expected a word of letters, digits and _, as a column of a table can be called"
            raise table.fault("key", f"is {key!r}: {wanted}")
        if key in [item.key for item in items]:
            raise table.fault("key", f"is {key!r} a second time: every item has one of its own")
        if "answer" in table and not own:
            wanted = f"is for kind {QUESTIONNAIRE} or {PREFERENCE}: expected the answers of the scale alone"
            raise table.fault("answer", wanted)
        items.append(Item(key, **fields_in(table, Item), **(_of_item(table, data) if own else {})))
    return tuple(items)


def _of_item(table: Table, data: Table) -> dict[str, Any]:
    """Return what an item says of its answers."""
    if "answer" not in table:
        made: dict[str, Any] = {"is_reversed": table.flag("reversed", False)}
        if "anchors" in table:
            answer = data.table("answer")
            made["anchors"] = _anchors(table, answer.number("least"), answer.number("most"))
        return made
    kind = table.word("answer", OWN_ANSWERS)
    if kind == CHOICE:
        choices = table.texts("choices")
        if not 2 <= len(choices) <= MOST_CHOICES or len(set(choices)) < len(choices):
            found = f"is {quoted(list(choices))}: expected 2 to {MOST_CHOICES} different texts"
            raise table.fault("choices", found)
        return {"answer": kind, "choices": tuple(choices)}
    if kind == NUMBER:
        least, most = table.number("least"), table.number("most")
        step = _step(table, least, most) if "step" in table or not most > least else 1.0
        return {"answer": kind, "least": least, "most": most, "step": step}
    return {"answer": kind}


def _step(answer: Table, least: float, most: float) -> float:
    if not most > least:
        raise answer.fault("most", f"is {most:g}: expected more than answer.least, {least:g}")
    step = answer.number("step")
    if not step > 0:
        raise answer.fault("step", f"is {step:g}: expected a number above 0")
    steps, wanted = (most - least) / step, f"is {step:g}: expected one that"
    if not steps <= _MOST_VALUES:
        raise answer.fault("step", f"{wanted} makes at most {_MOST_VALUES} steps from {least:g} to {most:g}")
    if round(steps) < 1 or not math.isclose(steps, round(steps), abs_tol=1e-6):
        raise answer.fault("step", f"{wanted} divides {least:g} to {most:g} into equal steps")
    return step


def _anchors(answer: Table, least: float, most: float) -> dict[float, str]:
    table = answer.table("anchors")
    anchors: dict[float, str] = {}
    for key in table.keys():  # noqa: SIM118  (a Table is no dict)
        try:
            value = float(key)
        except ValueError:
            value = math.nan
        if not least <= value <= most:
            wanted = f"expected a number from {least:g} to {most:g}, in quotes where it has a point or a sign"
            raise table.fault(key, f"is no answer: {wanted}")
        if value in anchors:
            raise table.fault(key, "says a second time what this answer means")
        anchors[value] = table.line(key)
    for end in (least, most):
        if end not in anchors:
            raise answer.fault("anchors", f"has no word for {end:g}: expected words for both ends at least")
    return dict(sorted(anchors.items()))


def _score(table: Table, items: int, before: list[str]) -> _Score:
    """Read a score. items: how many questions there are. before: scores above it."""
    name = table.text("name")
    if not name.isidentifier() or name in before:
        raise table.fault("name", f"is {name!r}: expected a word of letters, digits and _ that no other score has")
    if ("items" in table) == ("of" in table):
        wanted = "expected either items, numbers of questions from 1 on, or of, names of scores above it"
        raise table.fault(None, f"'{name}': {wanted}")
    about = fields_in(table, _Score)
    if "items" in table:
        numbers = table.numbers("items")
        if not numbers or not set(numbers) <= {*range(1, items + 1)} or len(set(numbers)) < len(numbers):
            found = [int(number) if number == int(number) else number for number in numbers]
            raise table.fault("items", f"is {found}: expected numbers of questions, from 1 to {items}, each once")
        return _Score(name, tuple(map(int, numbers)), **about)
    of = table.texts("of")
    for other in of:
        if other not in before:
            above = ", ".join(before) or "there are none"
            raise table.fault("of", f"names {other!r}: expected scores that stand above this one ({above})")
    return _Score(name, of=of, of_what=table.word("of_what", OF, SUMS), **about)
