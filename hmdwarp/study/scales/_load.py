"""Load scales from their .toml files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import attrs

from ...errors import unknown_name
from ...options import Table, parsed, quoted, text_of
from ._scale_model import CHOICE, KINDS, NUMBER, OF, OWN_ANSWERS, PREFERENCE, QUESTIONNAIRE, SUMS, Item, Scale, Score

FOLDER = Path(__file__).parent
_EXAMPLE = "the scale of docs/scales.md"
_MOST_VALUES = 10_000  # of one answer: no panel can tell more apart
_MOST_ITEMS = 500
MOST_CHOICES = 12  # rows of a list that a panel holds


def scale_names() -> list[str]:
    """Return the names of the shipped scales, sorted."""
    return sorted(p.stem for p in FOLDER.glob("*.toml"))


def load_scale(name: str, folder: Path | None = None) -> Scale:
    """Load a shipped scale by name, or any .toml file by path.

    folder: as text_of takes it. Errors: InputError naming the file, the line and the value.
    """
    path = Path(name) if name.endswith(".toml") else FOLDER / f"{name}.toml"
    if not name.endswith(".toml") and name not in scale_names():
        raise unknown_name("scale", name, [*scale_names(), "FILE.toml"])
    text = text_of(path, f"a .toml file, or one of {', '.join(scale_names())}", folder)
    return parsed(text, path, lambda data: _scale(data, path.stem), _EXAMPLE)


def _scale(data: Table, name: str) -> Scale:
    kind = data.word("kind", KINDS)
    items = _items(data, own=kind in (QUESTIONNAIRE, PREFERENCE))
    if kind == PREFERENCE:
        _check_preference(data, items)
    made = Scale(
        name=name,
        title=data.line("title"),
        kind=kind,
        items=items,
        **(_no_answers() if "answer" not in data and all(item.answer for item in items) else _answers(data)),
        units=data.line("units", ""),
        source=data.line("source"),
        prompt=data.line("prompt", ""),
        beside_reference=data.flag("beside_reference", False),
    )
    return attrs.evolve(made, scores=_scores(data, made))


def _check_preference(data: Table, items: tuple[Item, ...]) -> None:
    """Check that there is one question, answered by the first, the second, and perhaps neither."""
    if len(items) != 1 or items[0].answer != CHOICE or len(items[0].choices) not in (2, 3):
        raise data.fault(
            "item",
            f'is no preference: expected one [[item]] with answer = "{CHOICE}" and 2 choices, for the first and for '
            "the second of a pair, or 3, the last of them for neither",
        )


def _answers(data: Table) -> dict[str, Any]:
    answer = data.table("answer")
    least, most = answer.number("least"), answer.number("most")
    return {
        "least": least,
        "most": most,
        "step": _step(answer, least, most),
        "low_is_good": answer.flag("low_is_good"),
        "anchors": _anchors(answer, least, most),
    }


def _no_answers() -> dict[str, Any]:
    """Return what a questionnaire has whose questions all have answers of their own."""
    return {"least": 0.0, "most": 0.0, "step": 1.0, "low_is_good": False}


def _items(data: Table, own: bool) -> tuple[Item, ...]:
    """Read the questions. own: whether they may have answers of their own."""
    tables = data.tables("item")
    if not 1 <= len(tables) <= _MOST_ITEMS:
        raise data.fault(
            "item", f"comes {len(tables)} times: expected 1 to {_MOST_ITEMS} questions, each beginning with [[item]]"
        )
    items: list[Item] = []
    for table in tables:
        key = table.text("key")
        if not key.isidentifier():
            raise table.fault(
                "key", f"is {key!r}: expected a word of letters, digits and _, as a column of a table can be called"
            )
        if key in [item.key for item in items]:
            raise table.fault("key", f"is {key!r} a second time: every item has one of its own")
        if "answer" in table and not own:
            raise table.fault(
                "answer", f"is for kind {QUESTIONNAIRE} or {PREFERENCE}: expected the answers of the scale alone"
            )
        items.append(Item(key, table.line("text"), **(_of_item(table, data) if own else {})))
    return tuple(items)


def _of_item(table: Table, data: Table) -> dict[str, Any]:
    """Return what an item says of its answers."""
    if "answer" in table:
        return _own_answers(table)
    made: dict[str, Any] = {"is_reversed": table.flag("reversed", False)}
    if "anchors" in table:
        answer = data.table("answer")
        made["anchors"] = _anchors(table, answer.number("least"), answer.number("most"))
    return made


def _own_answers(table: Table) -> dict[str, Any]:
    kind = table.word("answer", OWN_ANSWERS)
    if kind == CHOICE:
        choices = table.texts("choices")
        if not 2 <= len(choices) <= MOST_CHOICES or len(set(choices)) < len(choices):
            raise table.fault("choices", f"is {quoted(list(choices))}: expected 2 to {MOST_CHOICES} different texts")
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
    steps = (most - least) / step
    if not steps <= _MOST_VALUES:
        raise answer.fault(
            "step", f"is {step:g}: expected one that makes at most {_MOST_VALUES} steps from {least:g} to {most:g}"
        )
    if round(steps) < 1 or not math.isclose(steps, round(steps), abs_tol=1e-6):
        raise answer.fault("step", f"is {step:g}: expected one that divides {least:g} to {most:g} into equal steps")
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
            raise table.fault(
                key,
                f"is no answer: expected a number from {least:g} to {most:g}, in quotes where it has a point or a sign",
            )
        if value in anchors:
            raise table.fault(key, "says a second time what this answer means")
        anchors[value] = table.line(key)
    for end in (least, most):
        if end not in anchors:
            raise answer.fault("anchors", f"has no word for {end:g}: expected words for both ends at least")
    return dict(sorted(anchors.items()))


def _scores(data: Table, scale: Scale) -> tuple[Score, ...]:
    tables = data.tables("score")
    if tables and scale.kind != QUESTIONNAIRE:
        raise data.fault("score", f"is for questionnaires: a {scale.kind} is its own score")
    made: list[Score] = []
    for table in tables:
        name = table.text("name")
        if not name.isidentifier() or name in [score.name for score in made]:
            raise table.fault("name", f"is {name!r}: expected a word of letters, digits and _ that no other score has")
        made.append(_score(table, name, len(scale.items), [score.name for score in made]))
    return tuple(made)


def _score(table: Table, name: str, items: int, before: list[str]) -> Score:
    if ("items" in table) == ("of" in table):
        raise table.fault(
            None, f"'{name}': expected either items, numbers of questions from 1 on, or of, names of scores above it"
        )
    weight = table.number("weight", 1.0)
    if "items" in table:
        return Score(name, _item_numbers(table, items), weight=weight, title=table.line("title"))
    of = table.texts("of")
    for other in of:
        if other not in before:
            raise table.fault(
                "of",
                f"names {other!r}: expected scores that stand above this one ({', '.join(before) or 'there are none'})",
            )
    return Score(name, of=of, of_what=table.word("of_what", OF, SUMS), weight=weight, title=table.line("title"))


def _item_numbers(table: Table, items: int) -> tuple[int, ...]:
    numbers = table.numbers("items")
    known = set(range(1, items + 1))
    if not numbers or not set(numbers) <= known or len(set(numbers)) < len(numbers):
        raise table.fault(
            "items", f"is {list(map(_tidy, numbers))}: expected numbers of questions, from 1 to {items}, each once"
        )
    return tuple(map(int, numbers))


def _tidy(value: float) -> float | int:
    return int(value) if value == int(value) else value
