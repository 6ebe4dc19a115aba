"""Reads study files (.toml), naming the line of an error; writes a new one to begin with."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path, PurePath

import attrs
from PIL.Image import Image

from ...errors import InputError, unknown_name
from ...options import PICTURE_FILE, KeyFault, Table, as_keys, fields_in, opened, parsed, quoted, text_of
from ...pipeline import SceneKey, Source
from ...report import refuse_existing, write_text
from ..scales import PREFERENCE, QUESTIONNAIRE, RATING, Scale, load_scale
from .definitions import (
    DISPLAY,
    KINDS,
    NAMED_FILES,
    ONE,
    ONLY_PART,
    ORDERS,
    PAIR,
    PICTURE,
    REFERENCE_FIRST,
    SHOWS,
    WILLIAMS,
    Breaks,
    Comparison,
    Condition,
    Consent,
    Design,
    Family,
    Page,
    Part,
    SettingFault,
    Sickness,
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


PRACTICE = "practice"
UNTIL_DONE, LONGEST_S = "until done", 600.0
_MOST_ASKED = 3  # questions of a questionnaire after each trial
_PRACTICE_DEFAULTS = {"latency": 0, "warp": "none", "fill": "none"}


def scale_at(table: Table, key: str, name: str, folder: Path, *within: int) -> Scale:
    """Load a shipped scale, or a .toml file next to the study's. Errors: KeyFault."""
    try:
        return load_scale(str(folder / name), folder) if name.endswith(".toml") else load_scale(name)
    except InputError as error:
        raise table.fault(key, f"has '{name}': {error}", *within) from error


def scales_of(table: Table, key: str, folder: Path, *, questionnaires: bool = False) -> tuple[Scale, ...]:
    """Load the scales of a list.

    questionnaires: whether they belong before or after the session; else they follow each trial,
    where a questionnaire is short.
    """
    names = table.texts(key) if not questionnaires else table.texts(key, ())
    made: list[Scale] = []
    for number, name in enumerate(names):
        scale = scale_at(table, key, name, folder, number)
        if not questionnaires and scale.kind == QUESTIONNAIRE and (scale.scores or len(scale.items) > _MOST_ASKED):
            raise table.fault(
                key,
                f"has '{name}', a questionnaire of {len(scale.items)} items{' with scores' if scale.scores else ''}: "
                f"expected a scale that takes a moment, {_MOST_ASKED} questions at most and no scores",
                number,
            )
        if questionnaires and scale.kind == PREFERENCE:
            raise table.fault(
                key, f"has '{name}', a {PREFERENCE}, which is about a pair: it belongs in [trial]", number
            )
        if scale.name in [scale.name for scale in made]:
            raise table.fault(key, f"has '{scale.name}' twice: expected each scale once", number)
        made.append(scale)
    if not made and not questionnaires:
        raise table.fault(key, "is empty: expected one scale at least; see 'hmdwarp list scales'")
    if not questionnaires:
        _check_kinds(table, key, made)
    return tuple(made)


def _check_kinds(trial: Table, key: str, made: list[Scale]) -> None:
    """Check that the scales after a trial fit what it shows."""
    names = ", ".join(scale.name for scale in made)
    preferences = [scale for scale in made if scale.kind == PREFERENCE]
    shows = trial.word("shows", SHOWS, ONE)
    if shows == PAIR:
        if len(preferences) != 1 or any(scale.kind not in (PREFERENCE, QUESTIONNAIRE) for scale in made):
            raise trial.fault(
                key,
                f"is {names}, after a pair: expected one scale of kind {PREFERENCE}, such as preference, and perhaps "
                "a short questionnaire",
            )
        return
    if preferences:
        raise trial.fault(key, f"has '{preferences[0].name}', a {PREFERENCE}: it needs shows = \"{PAIR}\"")
    if all(scale.kind != RATING for scale in made):
        # Tables of ratings and the analysis hold only that kind.
        raise trial.fault(
            key,
            f"has no rating ({names}): expected one scale of kind rating at least; the others belong in [sickness]",
        )
    for scale in made:
        if scale.kind == RATING and scale.beside_reference != (shows == REFERENCE_FIRST):
            raise trial.fault(
                key,
                f"has '{scale.name}', which asks for the difference from a reference shown right before: it needs "
                f'shows = "{REFERENCE_FIRST}"'
                if scale.beside_reference
                else f"has '{scale.name}', which asks nothing about the reference: expected dcr, or a scale with "
                f'beside_reference = true, with shows = "{REFERENCE_FIRST}"',
            )


def length_of(trial: Table) -> tuple[float, bool]:
    """Return how long a trial is at most, and whether the participant ends it."""
    seconds = trial.raw("seconds") if "seconds" in trial else None
    if isinstance(seconds, str):
        if seconds != UNTIL_DONE:
            raise trial.fault("seconds", f'is {quoted(seconds)}: expected a finite number, or "{UNTIL_DONE}"')
        return trial.within("longest", 0, 3600, LONGEST_S, above=True), True
    if "longest" in trial:
        raise trial.fault("longest", f'belongs to seconds = "{UNTIL_DONE}": leave it out beside a number')
    return trial.within("seconds", 0, 3600, 20.0, above=True), False


def practice_of(data: Table, checker: Checker) -> Condition | None:
    """Return the practice condition, None without [practice].

    No latency and no warp by default; its look is that of [common].
    """
    if PRACTICE not in data:
        return None
    table = data.table(PRACTICE)
    others = ("seconds",)
    own = {key: table.raw(key) for key in table.keys() if key not in others}  # noqa: SIM118  (a Table is no dict)
    settings = checker.settings(table, own, "practice", beneath=_PRACTICE_DEFAULTS, only=PICTURE, others=others)
    return Condition(PRACTICE, settings)


def breaks_of(data: Table) -> Breaks:
    """Return the breaks; none without [breaks]."""
    if "breaks" not in data:
        return Breaks()
    return Breaks(**fields_in(data.table("breaks"), Breaks))


def sickness_of(data: Table, folder: Path) -> Sickness | None:
    """Return the sickness rule, None without [sickness].

    stop_at must be worse than the best answer, or every session would end at once.
    """
    if "sickness" not in data:
        return None
    table = data.table("sickness")
    scale = scale_at(table, "scale", table.text("scale"), folder)
    if scale.kind == QUESTIONNAIRE:
        raise table.fault(
            "scale",
            f"has '{scale.name}', a questionnaire of {len(scale.items)} items: expected a scale that takes a moment",
        )
    if scale.kind in (RATING, PREFERENCE):
        raise table.fault(
            "scale",
            f"has '{scale.name}', a {scale.kind}, and would stand among those of the trials: expected fms, misc or "
            "the like",
        )
    stop_at = table.within("stop_at", scale.least, scale.most, None)
    if stop_at is not None and scale.badness(stop_at) <= 0:
        raise table.fault(
            "stop_at",
            f"is {stop_at:g}, the best answer of '{scale.name}': expected a worse one, or every session stops at once",
        )
    rise = table.within("rise", 0, scale.most - scale.least, None, above=True)
    return Sickness(scale, **fields_in(table, Sickness), stop_at=stop_at, rise=rise)


def questionnaires_of(data: Table, folder: Path) -> tuple[tuple[Scale, ...], tuple[Scale, ...]]:
    """Return the questionnaires before and after the session."""
    if "questionnaires" not in data:
        return (), ()
    table = data.table("questionnaires")
    before, after = (scales_of(table, key, folder, questionnaires=True) for key in ("before", "after"))
    return before, after


def consent_of(data: Table, folder: Path) -> Consent | None:
    """Return the consent, None without [consent]; its text is there or in a file next to it."""
    if "consent" not in data:
        return None
    table = data.table("consent")
    version = fields_in(table, Consent)
    if ("text" in table) == ("file" in table):
        raise table.fault(None, "needs either text, or file: a text beside the study file")
    return Consent(**version, text=table.text("text") if "text" in table else _text_of(table, folder))


def page_of(data: Table, key: str, title: str, folder: Path, checked: bool) -> Page | None:
    """Return a page to read, None without its table: its text, or a file with a text or picture.

    checked: False leaves files alone, which may be gone when an old session is exported.
    """
    if key not in data:
        return None
    table = data.table(key)
    title = table.line("title", title)
    if ("text" in table) == ("file" in table):
        raise table.fault(None, "needs either text, or file: a text or a picture beside the study file")
    if "text" in table:
        return Page(title, table.text("text"))
    path = folder / table.text("file")
    if path.suffix.lower() in ENDINGS:
        if checked:
            try:
                open_picture(path, folder)
            except InputError as error:
                raise table.fault("file", f"is {quoted(str(path))}: {error}") from error
        return Page(title, picture=str(path))
    return Page(title, _text_of(table, folder) if checked else "")


def _text_of(table: Table, folder: Path) -> str:
    path = folder / table.text("file")
    try:
        text = text_of(path, "a text that participants read", folder)
    except InputError as error:
        raise table.fault("file", f"is {quoted(str(path))}: {error}") from error
    if not text.strip():
        raise table.fault("file", f"is {quoted(str(path))}, which is empty: expected a text that participants read")
    return text


ENDINGS = (".png", ".jpg", ".jpeg")
PNG_OR_JPEG = attrs.evolve(PICTURE_FILE, what="a PNG or JPEG file")


def open_picture(path: Path | str, folder: Path | None = None) -> Image:
    """Load a picture, RGBA. folder: as `opened` takes it. Errors: InputError."""
    from PIL import Image

    try:
        with opened(path, PNG_OR_JPEG, folder) as plain, Image.open(plain) as file:
            return file.convert("RGBA")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise InputError(f"no picture ({error}): expected a PNG or JPEG file") from error


SCHEMA = 1
SHIPPED = Path(__file__).resolve().parent.parent / "ready"
_EXAMPLE = "thesis.toml ('hmdwarp study plan thesis' prints its path)"


def study_names() -> list[str]:
    """Return the names of the shipped studies, sorted; NAME_more.toml only belongs to a study."""
    return sorted(p.stem for p in SHIPPED.glob("*.toml") if "_" not in p.stem)


def load_design(name_or_path: str, *, checked: bool = True) -> Design:
    """Load a shipped study by name, or a .toml file by path.

    checked: try every condition's settings as far as possible without a display, which takes a
    second for a large scene.
    Errors: InputError that names file and line, what was found and what was expected.
    """
    path = _path_of(name_or_path)
    text = text_of(path, f"a .toml file, or one of {', '.join(study_names())}")
    try:
        return design_from_text(text, str(path), checked=checked)
    except InputError as error:
        if checked:
            raise
        raise InputError(f"{error}; sessions that hmdwarp 0.2 ran with this plan are exported by that one") from error


def _path_of(name: str) -> Path:
    if name.endswith(".toml"):
        return Path(name)
    if name in study_names():
        return SHIPPED / f"{name}.toml"
    if Path(name).is_file():
        raise InputError(f"study file {name}: expected one whose name ends in .toml")
    raise unknown_name("study", name, [*study_names(), "FILE.toml"])


def design_from_text(text: str, path: str, *, checked: bool = True) -> Design:
    """Return the plan of a text.

    path: of its file, for messages and for files it names. checked: False does not try the
    settings, because the scenes of an old session may be gone. Errors: as load_design.
    """
    return parsed(text, path, lambda data: _design(data, text, path, checked), _EXAMPLE)


def _design(data: Table, text: str, path: str, checked: bool) -> Design:
    if (schema := data.whole("schema", 0, 2**31)) != SCHEMA:
        raise data.fault("schema", f"is {schema}: expected {SCHEMA}, which this version of hmdwarp reads")
    folder, trial = Path(path).parent, data.table("trial")
    checker = Checker(folder, data.table("common") if "common" in data else None, checked)
    scales = scales_of(trial, "scales", folder)
    sickness = sickness_of(data, folder)
    before, after = questionnaires_of(data, folder)
    if sickness is not None and sickness.scale.name in [scale.name for scale in scales]:
        raise trial.fault(
            "scales", f"has '{sickness.scale.name}', which is also that of [sickness]: leave it out of one of them"
        )
    parts = parts_of(data, checker)
    seconds, until_done = length_of(trial)
    return Design(
        name=_name(data),
        **fields_in(data, Design),
        parts=parts,
        scales=scales,
        families=families_of(data, parts),
        seconds=seconds,
        until_done=until_done,
        practice=practice_of(data, checker),
        breaks=breaks_of(data),
        sickness=sickness,
        before=before,
        after=after,
        consent=consent_of(data, folder),
        instructions=page_of(data, "instructions", "Instructions", folder, checked),
        ready=page_of(data, "ready", "Ready?", folder, checked),
        thanks=page_of(data, "thanks", "Thank you", folder, checked),
        text=text,
        path=path,
        scene_notes=checker.scene_notes,
    )


def _name(data: Table) -> str:
    name = data.text("name")
    if not NAME.fullmatch(name):
        raise data.fault("name", f"is {quoted(name)}: {NAME_WANTED}")
    return name


TEMPLATE = Path(__file__).parent / "plan_template.toml"


def write_new_plan(name: str, folder: Path, *, force: bool = False) -> Path:
    """Write NAME.toml, a commented plan that can be run as it is, and return its path.

    Errors: InputError for a name that no study can have, a file that is there, unless forced,
    and a folder that cannot be written.
    """
    if not NAME.fullmatch(name) or name.endswith(".toml"):
        raise InputError(f"study name {quoted(name)}: {NAME_WANTED}, without .toml")
    path = folder / f"{name}.toml"
    refuse_existing(path, force=force)
    write_text(path, TEMPLATE.read_text(encoding="utf-8").format(name=name))
    return path
