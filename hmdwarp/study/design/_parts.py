"""Parts, conditions and families of a study file."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path, PurePath

from ...errors import InputError, unknown_name
from ...options import KeyFault, Table, as_keys, quoted
from ...pipeline import SceneKey, Source
from .definitions import (
    DISPLAY,
    KINDS,
    NAMED_FILES,
    ONE,
    ONLY_PART,
    ORDERS,
    PAIR,
    REFERENCE_FIRST,
    SHOWS,
    WILLIAMS,
    Comparison,
    Condition,
    Family,
    Part,
    SettingFault,
    check_settings,
    live_options,
    resolve_paths,
)

NAME = re.compile(r"[^\W_][\w.+-]{0,63}")
NAME_WANTED = "expected a name of letters, digits, and . _ + - after the first, 64 at most"
_NO_SETTINGS = ("name", "reference")  # keys of a [[condition]]
_MOST_CONDITIONS = 100
_MOST_TRIALS = 1000  # of one session
_COMPARE = 'compare = [{ better = "warped", baseline = "late" }]'
_Named = tuple[str, str, Callable[[str], KeyFault]]  # baseline, better, and how to blame where they stand


class Checker:
    """Makes and tries the settings of one condition after the other."""

    def __init__(self, folder: Path, common: Table | None, checked: bool) -> None:
        """Begin without scenes. folder: of the study file; common: its [common]."""
        self._folder, self._common, self._checked = folder, common, checked
        self._sources: dict[SceneKey, Source] = {}

    @property
    def scene_notes(self) -> tuple[str, ...]:
        """What had to be left out or replaced of the scene files, each once."""
        return tuple(dict.fromkeys(note for source in self._sources.values() for note in source.scene.notes))

    def settings(
        self,
        table: Table,
        own: Mapping[str, object],
        who: str,
        *,
        beneath: Mapping[str, object] | None = None,
        only: Sequence[str] = (),
        others: Sequence[str] = (),
    ) -> dict[str, object]:
        """Return a condition's settings: those of [common], then `beneath`, then its own.

        only: the settings to take from [common]; empty for all. others: keys of the table that are
        no settings, for hints.
        Errors: KeyFault at the wrong key, as far as it is known.
        """
        common = self._placed(self._common, _all_of(self._common), "common") if self._common is not None else {}
        mine = self._placed(table, own, who, others)
        # What of recorded frames is shown is the display's own field of view.
        for name in (*DISPLAY, *(("guard",) if "frames" in common else ())):
            if name in mine:
                key = next(key for key in own if key.replace("-", "_") == name)
                raise table.fault(
                    key, "is the same for all conditions, as the display is opened once: put it in [common]"
                )
        settings = (
            {name: value for name, value in common.items() if not only or name in only} | dict(beneath or {}) | mine
        )
        try:
            check_settings(settings, self._sources) if self._checked else live_options(settings)
        except InputError as error:
            raise self._blamed(table, own, who, as_keys(str(error), KINDS), getattr(error, "key", "")) from error
        return settings

    def _placed(
        self, table: Table, settings: Mapping[str, object], who: str, others: Sequence[str] = ()
    ) -> dict[str, object]:
        try:
            return resolve_paths(self._folder, settings, others)
        except SettingFault as error:
            raise KeyFault(f"{who}: {error}", (*table.path, error.key)) from error

    def _blamed(self, table: Table, own: Mapping[str, object], who: str, says: str, named: str) -> KeyFault:
        """Blame the key that the message names or whose value it quotes, else the condition."""
        keys = [(table, key, value) for key, value in own.items()]
        if self._common is not None:
            keys += [(self._common, key, value) for key, value in _all_of(self._common).items() if key not in own]
        words = [word.replace("-", "_") for word in ([named] if named else re.findall(r"[\w-]+", says))]
        blamed = [found for found in keys if found[1].replace("-", "_") in words]
        if blamed:
            inside, key, _ = min(blamed, key=lambda found: words.index(found[1].replace("-", "_")))
            return KeyFault(f"{who}: {says}", (*inside.path, key))
        quoted = re.findall(r"'([^']+)'", says)
        paths = ((*inside.path, key) for inside, key, value in keys if any(text in str(value) for text in quoted))
        return KeyFault(f"{who}: {says}", next(paths, table.path))


def _all_of(table: Table | None) -> dict[str, object]:
    return {} if table is None else {key: table.raw(key) for key in table.keys()}  # noqa: SIM118  (a Table is no dict)


def name_of(table: Table, used: Sequence[str]) -> str:
    """Return the table's name, which no other table has."""
    name = table.text("name")
    if not NAME.fullmatch(name):
        raise table.fault("name", f"is {quoted(name)}: {NAME_WANTED}")
    if name.lower() in [other.lower() for other in used]:
        raise table.fault("name", f"is {name!r} a second time: expected a name that differs in more than case")
    return name


def parts_of(data: Table, checker: Checker) -> tuple[Part, ...]:
    """Read [[part]] with [[part.condition]], or [[condition]] alone for a study of one part."""
    if "part" in data and "condition" in data:
        raise data.fault("condition", "beside [[part]]: expected it within one, as [[part.condition]]")
    if "part" not in data:
        return (Part(ONLY_PART, _conditions(data, data, checker)),)
    tables = data.tables("part")
    if not tables:
        raise data.fault("part", "is empty: expected one [[part]] at least")
    parts: list[Part] = []
    for table in tables:
        name = name_of(table, [part.name for part in parts])
        parts.append(Part(name, _conditions(table, data, checker)))
    return tuple(parts)


def _conditions(within: Table, data: Table, checker: Checker) -> tuple[Condition, ...]:
    tables = within.tables("condition")
    heading = "[[part.condition]]" if within is not data else "[[condition]]"
    if "condition" not in within:
        raise within.missing("condition")
    if not 1 <= len(tables) <= _MOST_CONDITIONS:
        raise within.fault(
            "condition", f"comes {len(tables)} times: expected 1 to {_MOST_CONDITIONS}, each beginning with {heading}"
        )
    made: list[Condition] = []
    for table in tables:
        own = {key: value for key, value in _all_of(table).items() if key not in _NO_SETTINGS}
        factors = {key: value for key, value in own.items() if isinstance(value, list)}
        reference = table.flag("reference", False)
        if reference and (factors or any(condition.reference for condition in made)):
            raise table.fault("reference", "is true a second time in this part: expected one hidden reference, or none")
        for chosen in _combinations(table, factors, _MOST_CONDITIONS - len(made)):
            used = [condition.name for condition in made]
            name = _combined_name(table, chosen, used) if factors else name_of(table, used)
            settings = checker.settings(table, own | chosen, f"condition '{name}'", others=_NO_SETTINGS)
            made.append(Condition(name, settings, reference))
    trial = data.table("trial")
    order, shows = trial.word("order", ORDERS, WILLIAMS), trial.word("shows", SHOWS, ONE)
    pairs = shows == PAIR
    if shows == REFERENCE_FIRST and not any(condition.reference for condition in made):
        raise trial.fault("shows", f'is "{shows}", and no {heading} has reference = true: expected one in each part')
    if len(made) < 2 and pairs:
        raise trial.fault("shows", f"is {PAIR}, of one condition: expected two at least")
    if len(made) < 2 and order == WILLIAMS:
        raise trial.fault(
            "order",
            f"is {WILLIAMS} (the default): one condition has no order; expected two, or order fixed",
        )
    each = len(made) * (len(made) - 1) // 2 if pairs else len(made)
    repeats = trial.whole("repeats", 1, _MOST_TRIALS, 1)
    if each * repeats > _MOST_TRIALS:
        raise trial.fault(
            "repeats" if "repeats" in trial else None,
            f"makes {each} x {repeats} trials: expected {_MOST_TRIALS} at most in a session",
        )
    return tuple(made)


def _combinations(table: Table, factors: Mapping[str, list[object]], most: int) -> Iterator[dict[str, object]]:
    """Return every combination of the settings that have several values; one without any such.

    The last one changes fastest.
    """
    for key, values in factors.items():
        if not values:
            raise table.fault(key, "is an empty list: expected values, which make a condition each")
        for number, value in enumerate(values):
            if not isinstance(value, str | int | float):
                raise table.fault(key, f"has {quoted(value)}: expected texts, numbers, true or false", number)
    if (count := math.prod(map(len, factors.values()))) > most:
        raise table.fault(
            next(iter(factors), None),
            f"makes {count} combinations: expected {_MOST_CONDITIONS} conditions at most in a part",
        )
    return (dict(zip(factors, values, strict=True)) for values in itertools.product(*factors.values()))


def _combined_name(table: Table, chosen: Mapping[str, object], used: Sequence[str]) -> str:
    """Return the table's name, if it has one, with the values, such as late-latency200-forward."""
    words = [_value_name(key, value) for key, value in chosen.items()]
    name = "-".join([*([table.text("name")] if "name" in table else []), *words])
    if not NAME.fullmatch(name):
        raise table.fault(next(iter(chosen)), f"makes a condition {quoted(name)}: {NAME_WANTED}")
    if name.lower() in [other.lower() for other in used]:
        raise table.fault(
            next(iter(chosen)), f"makes a second condition {name!r}: expected values, or a name, that tell them apart"
        )
    return name


def _value_name(key: str, value: object) -> str:
    """Return a value as part of a name: a word by itself, a number behind its setting."""
    if isinstance(value, bool):
        return key if value else f"no-{key}"
    if not isinstance(value, str):
        return f"{key}{value}"
    stem = PurePath(value).stem if value.lower().endswith((".toml", *NAMED_FILES.get(key, ()))) else value
    return re.sub(r"[^\w.+]+", "-", stem).strip("-")


def families_of(data: Table, parts: tuple[Part, ...]) -> tuple[Family, ...]:
    """Read [[family]], each with comparisons of conditions of one part."""
    made: list[Family] = []
    for table in data.tables("family"):
        name = table.line("name")
        if name in [family.name for family in made]:
            raise table.fault("name", f"is {name!r} a second time: expected a name that no other family has")
        made.append(Family(name, _comparisons(table, _part_of(table, parts))))
    return tuple(made)


def _part_of(table: Table, parts: tuple[Part, ...]) -> Part:
    if "part" not in table and len(parts) == 1:
        return parts[0]
    return next(part for part in parts if part.name == table.word("part", [part.name for part in parts]))


def _comparisons(table: Table, part: Part) -> tuple[Comparison, ...]:
    """Read compare, whose entries name better and baseline; or pairs, the baseline first."""
    if "pairs" not in table and "compare" not in table:
        raise table.fault(None, f"has no comparison: expected {_COMPARE}")
    known = [condition.name for condition in part.conditions]
    made: list[Comparison] = []
    for baseline, better, fault in (*_compare(table, known, part), *_pairs(table, known, part)):
        if baseline == better or {baseline, better} in [{other.baseline, other.better} for other in made]:
            why = "a condition beside itself" if baseline == better else "the same pair a second time"
            raise fault(f"has '{better}' over '{baseline}': {why}; expected each comparison once")
        made.append(Comparison(part.name, baseline, better))
    return tuple(made)


def _compare(table: Table, known: list[str], part: Part) -> Iterator[_Named]:
    """Yield baseline, better and how to blame the entry."""
    if "compare" not in table:
        return
    entries = table.tables("compare")
    if not entries:
        raise table.fault("compare", f"is empty: expected {_COMPARE}")
    for entry in entries:
        names = {key: entry.text(key) for key in ("baseline", "better")}
        for key, name in names.items():
            if name not in known:
                raise entry.fault(key, f"is an {unknown_name('condition', name, known)} in part '{part.name}'")
        yield names["baseline"], names["better"], partial(entry.fault, "better")


def _pairs(table: Table, known: list[str], part: Part) -> Iterator[_Named]:
    """Yield as _compare does."""
    if "pairs" not in table:
        return
    pairs = table.raw("pairs")
    if not isinstance(pairs, list) or not pairs:
        raise table.fault("pairs", 'is no list of pairs: expected names of conditions, like [["late", "warped"]]')
    for number, pair in enumerate(pairs):
        if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
            raise table.fault(
                "pairs", f'has {quoted(pair)}: expected pairs of names, like [["late", "warped"]]', number
            )
        for name in pair:
            if name not in known:
                raise table.fault(
                    "pairs", f"has an {unknown_name('condition', name, known)} in part '{part.name}'", number
                )
        baseline, better = pair

        def fault(says: str, number: int = number) -> KeyFault:
            return table.fault("pairs", says, number)

        yield baseline, better, fault
