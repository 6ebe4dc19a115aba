"""Definition of a study (parts, conditions, scales, comparisons), its file (.toml), and a new one.

All classes are frozen. Errors of a file name its line.
"""

from __future__ import annotations

import difflib
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

import attrs
from PIL.Image import Image

from ...base import DISPLAY as OF_DISPLAY
from ...base import PICTURE as OF_PICTURE
from ...base import (
    PICTURE_FILE,
    InputError,
    KeyFault,
    Table,
    as_keys,
    fields_in,
    keep_inside,
    opened,
    options_of,
    parsed,
    quoted,
    read_by,
    reads,
    text_of,
    unknown_name,
)
from ...display.desktop import WindowView
from ...headsets import FILE_ENDINGS as HEADSET_FILES
from ...headsets import load_headset
from ...pipeline import SceneKey, Source, guarded_size
from ...report import refuse_existing, write_text
from ...run import EmulatedScreen, LiveOptions, Run, checked_source, on_screen
from ...scenes import FILE_ENDINGS as SCENE_FILES
from ..scales import PREFERENCE, QUESTIONNAIRE, RATING, Scale, load_scale

_ORDERS = (WILLIAMS, RANDOM, FIXED) = ("williams", "random", "fixed")
_SHOWS = (ONE, PAIR, REFERENCE_FIRST) = ("one", "pair", "reference first")
_BLIND = (BOTH, PARTICIPANT, UNBLINDED) = ("both", "participant", "nobody")
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

    every: int = read_by(Table.whole, 0, 10_000, default=0, required=True)  # trials between two; 0 for none
    seconds: float = read_by(Table.within, 0, 3600, default=0.0)  # at least


@attrs.frozen
class Sickness:
    """When to ask for sickness, and which answer ends the session."""

    scale: Scale  # asked after the practice too
    every: int = read_by(Table.whole, 1, 10_000, default=1)  # trials between two questions
    stop_at: float | None = None  # an answer that bad ends the session; in the scale's own direction
    rise: float | None = None  # so does one worse by that much than the session's first answer


@attrs.frozen
class Consent:
    """Text that participants read before anything else; the store keeps its hash."""

    version: str = attrs.field(metadata=reads(Table.text))  # kept with each session
    text: str


@attrs.frozen
class Page:
    """Page that participants read: a text or a picture."""

    title: str
    text: str = ""
    picture: str = ""  # path of a PNG or JPEG file, "" for a text


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
    title: str = attrs.field(metadata=reads(Table.line))
    parts: tuple[Part, ...]
    scales: tuple[Scale, ...]  # asked after each trial, in this order
    families: tuple[Family, ...] = ()
    seconds: float = 20.0  # a trial shows its condition for so long, or at most so long
    until_done: bool = False  # whether the participant ends a trial
    # What a trial shows before the questions.
    shows: str = read_by(Table.word, _SHOWS, default=ONE, at="trial.shows")
    # Presentations of each condition, or pair.
    repeats: int = read_by(Table.whole, 1, 1000, default=1, at="trial.repeats")
    order: str = read_by(Table.word, _ORDERS, default=WILLIAMS, at="trial.order")
    seed: int = read_by(Table.whole, 0, 2**63 - 1, default=0)
    blind: str = read_by(Table.word, _BLIND, default=BOTH)  # who must not see the condition
    practice: Condition | None = None  # shown first and not scored
    practice_seconds: float = read_by(Table.within, 0, 3600, default=60.0, at="practice.seconds", above=True)
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


# Kinds of values in the file, which takes a number wherever the command line takes a numeric text.
_TEXT, _NUMBER, _WHOLE, _FLAG = "a text", "a number", "a whole number", "true or false"
_TEXT_OR_NUMBER = "a number or a text"
_NUMBERS = (_NUMBER, _TEXT_OR_NUMBER)
_KIND_OF = {float: _NUMBER, int: _WHOLE, bool: _FLAG}
_OPTIONS = options_of(LiveOptions)
_SETTINGS = [option for option in _OPTIONS if option.in_study]
KINDS = {option.name: _TEXT_OR_NUMBER if option.numeric else _KIND_OF.get(option.kind, _TEXT) for option in _SETTINGS}
# The display is opened once for a session: equal for all conditions.
DISPLAY = tuple(option.name for option in _SETTINGS if option.study == OF_DISPLAY)
# Of the picture, not of link or warp: the practice takes them over from [common].
PICTURE = (*(option.name for option in _SETTINGS if option.study == OF_PICTURE), *DISPLAY)
_MOST_PIXELS = 16384
FILES = tuple(option.name for option in _SETTINGS if option.kind is Path)
# Settings whose value may be a file, by its ending.
_NAMED_FILES = {"headset": HEADSET_FILES, "scene": SCENE_FILES}
_NOT_SETTINGS = {option.name: option.study for option in _OPTIONS if not option.in_study}
_NOT_SETTINGS |= dict.fromkeys(("quiet", "json"), "it is an option of a command, not of a study")


class SettingFault(InputError):
    """A wrong setting; key: its name, as in the file."""

    def __init__(self, key: str, text: str) -> None:
        super().__init__(text)
        self.key = key


def live_options(settings: Mapping[str, object], **more: Any) -> LiveOptions:
    """Return the options of a live run with these settings, without the panel.

    settings: see KINDS; names with - or _, values as in TOML. more: fields of LiveOptions, such as
    source, trace, record.
    Errors: SettingFault for an unknown name or a value of another kind; InputError for an invalid
    value.
    """
    values = {name: _value(key, name, value) for key, name, value in _named(settings)}
    return LiveOptions.of(values, panel=False, **more)


def resolved(settings: Mapping[str, object]) -> dict[str, object]:
    """Return settings with those that have a default by the warp. Errors: as live_options."""
    options = live_options(settings)
    values = {"latency": options.latency_ms, "warp": options.warp, "fill": options.fill, "guard": options.guard}
    values["predict"] = options.predict
    return {**values, **{key.replace("-", "_"): value for key, value in settings.items()}}


def default_of(name: str) -> object:
    """Return what a setting is that no condition sets."""
    return next(option.default for option in _OPTIONS if option.name == name)


def check_settings(settings: Mapping[str, object], sources: dict[SceneKey, Source]) -> LiveOptions:
    """Return the options after trying all that needs no display. sources: those opened so far."""
    options = live_options(settings)
    if not options.source_kind.has_head:  # the sizes of recorded frames are known once they are opened
        headset, band = load_headset(options.headset), options.guard_band
        width, height = guarded_size(band, headset, options.size or headset.eye_size_px)
        if max(width, height) > _MOST_PIXELS:
            found = f"{band} makes frames of {width}x{height} pixels"
            raise InputError(f"{found}: expected at most {_MOST_PIXELS} on each side, as most GPUs have it")
    source = sources[options.scene_key] = checked_source(options, sources.get(options.scene_key))
    screen = EmulatedScreen(source.headset, WindowView(options.view, source.headset, options.size).eyes)
    Run.of(on_screen(source.fitted(options), screen), source, screen)
    return options


def resolve_paths(folder: Path, settings: Mapping[str, object], others: Sequence[str] = ()) -> dict[str, object]:
    """Return settings with names with _ and whole paths. others: keys of the table, for hints."""
    found: dict[str, object] = {}
    for key, name, value in _named(settings, others):
        found[name] = value
        is_file = isinstance(value, str) and (name in FILES or value.lower().endswith(_NAMED_FILES.get(name, ())))
        if is_file:
            try:
                found[name] = str(keep_inside(folder.absolute() / str(value), folder, f"the file of {name}"))
            except InputError as error:
                raise SettingFault(key, f"{key} is {quoted(value)}: {error}") from error
    return found


def _named(settings: Mapping[str, object], others: Sequence[str] = ()) -> list[tuple[str, str, object]]:
    """Return (key of the file, name with _, value) of each. Errors: SettingFault."""
    out: dict[str, tuple[str, str, object]] = {}
    for key, value in settings.items():
        name = key.replace("-", "_")
        if name in _NOT_SETTINGS:
            raise SettingFault(key, f"{key} is no setting of a condition: {_NOT_SETTINGS[name]}")
        if name not in KINDS:
            known = [*others, *KINDS]
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]}? " if near else ""
            raise SettingFault(key, f"unknown setting {key[:80]!r}: {hint}known are {', '.join(known)}")
        if name in out:
            raise SettingFault(key, f"{key} comes twice, with - and with _: leave one of them out")
        out[name] = (key, name, value)
    return list(out.values())


def _value(key: str, name: str, value: object) -> object:
    """Convert a value to what the command line passes. Errors: SettingFault."""
    kind = KINDS[name]
    if isinstance(value, bool):
        if kind == _FLAG:
            return value
    elif isinstance(value, str) and kind in (_TEXT, _TEXT_OR_NUMBER):
        return Path(value) if name in FILES else value
    elif isinstance(value, int) and kind == _WHOLE:
        return value
    elif isinstance(value, int | float) and abs(value) < 2**63 and math.isfinite(value) and kind in _NUMBERS:
        return repr(value) if kind == _TEXT_OR_NUMBER else float(value)
    raise SettingFault(key, f"{key} is {quoted(value)}: expected {kind}")


# --- the file

NAME = re.compile(r"[^\W_][\w.+-]{0,63}")
NAME_WANTED = "expected a name of letters, digits, and . _ + - after the first, 64 at most"
_NO_SETTINGS = ("name", "reference")  # keys of a [[condition]]
_MOST_CONDITIONS = 100
_MOST_TRIALS = 1000  # of one session
_COMPARE = 'compare = [{ better = "warped", baseline = "late" }]'
# Baseline, better, and how to blame where one of them, or "" for both, stands.
_Named = tuple[str, str, Callable[[str, str], KeyFault]]


class _Checker:
    """Makes and tries the settings of one condition after the other."""

    def __init__(self, folder: Path, common: Table, checked: bool) -> None:
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
        common = self._placed(self._common, _all_of(self._common), "common")
        mine = self._placed(table, own, who, others)
        # What of recorded frames is shown is the display's own field of view.
        for name in (*DISPLAY, *(("guard",) if "frames" in common else ())):
            if name in mine:
                key, why = next(key for key in own if key.replace("-", "_") == name), "as the display is opened once"
                raise table.fault(key, f"is the same for all conditions, {why}: put it in [common]")
        shared = {name: value for name, value in common.items() if not only or name in only}
        settings = shared | dict(beneath or {}) | mine
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
        keys += [(self._common, key, value) for key, value in _all_of(self._common).items() if key not in own]
        words = [word.replace("-", "_") for word in ([named] if named else re.findall(r"[\w-]+", says))]
        blamed = [found for found in keys if found[1].replace("-", "_") in words]
        if blamed:
            inside, key, _ = min(blamed, key=lambda found: words.index(found[1].replace("-", "_")))
            return KeyFault(f"{who}: {says}", (*inside.path, key))
        texts = re.findall(r"'([^']+)'", says)
        paths = ((*inside.path, key) for inside, key, value in keys if any(text in str(value) for text in texts))
        return KeyFault(f"{who}: {says}", next(paths, table.path))


def _all_of(table: Table) -> dict[str, object]:
    return {key: table.raw(key) for key in table.keys()}  # noqa: SIM118  (a Table is no dict)


def name_of(table: Table, used: Sequence[str]) -> str:
    """Return the table's name, which no other table has."""
    name = table.text("name")
    if not NAME.fullmatch(name):
        raise table.fault("name", f"is {quoted(name)}: {NAME_WANTED}")
    if name.lower() in [other.lower() for other in used]:
        raise table.fault("name", f"is {name!r} a second time: expected a name that differs in more than case")
    return name


def parts_of(data: Table, checker: _Checker) -> tuple[Part, ...]:
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
        parts.append(Part(name_of(table, [part.name for part in parts]), _conditions(table, data, checker)))
    return tuple(parts)


def _conditions(within: Table, data: Table, checker: _Checker) -> tuple[Condition, ...]:
    tables = within.tables("condition")
    heading = "[[part.condition]]" if within is not data else "[[condition]]"
    if "condition" not in within:
        raise within.missing("condition")
    if not 1 <= len(tables) <= _MOST_CONDITIONS:
        wanted = f"expected 1 to {_MOST_CONDITIONS}, each beginning with {heading}"
        raise within.fault("condition", f"comes {len(tables)} times: {wanted}")
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
    _check_trials(data.table("trial"), made, heading)
    return tuple(made)


def _check_trials(trial: Table, made: Sequence[Condition], heading: str) -> None:
    """Check that a part's conditions fit trials and session. heading: of a condition."""
    order, shows = trial.word("order", _ORDERS, WILLIAMS), trial.word("shows", _SHOWS, ONE)
    pairs = shows == PAIR
    if shows == REFERENCE_FIRST and not any(condition.reference for condition in made):
        raise trial.fault("shows", f'is "{shows}", and no {heading} has reference = true: expected one in each part')
    if len(made) < 2 and pairs:
        raise trial.fault("shows", f"is {PAIR}, of one condition: expected two at least")
    if len(made) < 2 and order == WILLIAMS:
        wanted = "one condition has no order; expected two, or order fixed"
        raise trial.fault("order", f"is {WILLIAMS} (the default): {wanted}")
    each = len(made) * (len(made) - 1) // 2 if pairs else len(made)
    repeats = trial.whole("repeats", 1, _MOST_TRIALS, 1)
    if each * repeats > _MOST_TRIALS:
        found = f"makes {each} x {repeats} trials: expected {_MOST_TRIALS} at most in a session"
        raise trial.fault("repeats" if "repeats" in trial else None, found)


def _combinations(table: Table, factors: Mapping[str, list[object]], most: int) -> Iterator[dict[str, object]]:
    """Return every combination of settings that have several values; the last changes fastest."""
    for key, values in factors.items():
        if not values:
            raise table.fault(key, "is an empty list: expected values, which make a condition each")
        for number, value in enumerate(values):
            if not isinstance(value, str | int | float):
                raise table.fault(key, f"has {quoted(value)}: expected texts, numbers, true or false", number)
    if (count := math.prod(map(len, factors.values()))) > most:
        wanted = f"expected {_MOST_CONDITIONS} conditions at most in a part"
        raise table.fault(next(iter(factors), None), f"makes {count} combinations: {wanted}")
    return (dict(zip(factors, values, strict=True)) for values in itertools.product(*factors.values()))


def _combined_name(table: Table, chosen: Mapping[str, object], used: Sequence[str]) -> str:
    """Return the table's name with the values, such as late-latency200-forward."""
    words = [table.text("name")] if "name" in table else []
    for key, value in chosen.items():
        if isinstance(value, bool):
            words.append(key if value else f"no-{key}")
        elif isinstance(value, str):
            is_file = value.lower().endswith((".toml", *_NAMED_FILES.get(key, ())))
            words.append(re.sub(r"[^\w.+]+", "-", PurePath(value).stem if is_file else value).strip("-"))
        else:
            words.append(f"{key}{value}")
    name, first = "-".join(words), next(iter(chosen))
    if not NAME.fullmatch(name):
        raise table.fault(first, f"makes a condition {quoted(name)}: {NAME_WANTED}")
    if name.lower() in [other.lower() for other in used]:
        wanted = "expected values, or a name, that tell them apart"
        raise table.fault(first, f"makes a second condition {name!r}: {wanted}")
    return name


def _families_of(data: Table, parts: tuple[Part, ...]) -> tuple[Family, ...]:
    """Read [[family]], each with comparisons of conditions of one part."""
    made: list[Family] = []
    for table in data.tables("family"):
        name = table.line("name")
        if name in [family.name for family in made]:
            raise table.fault("name", f"is {name!r} a second time: expected a name that no other family has")
        names = [part.name for part in parts]
        of = names[0] if "part" not in table and len(parts) == 1 else table.word("part", names)
        made.append(Family(name, _comparisons(table, parts[names.index(of)])))
    return tuple(made)


def _comparisons(table: Table, part: Part) -> tuple[Comparison, ...]:
    """Read compare, whose entries name better and baseline; or pairs, the baseline first."""
    if "pairs" not in table and "compare" not in table:
        raise table.fault(None, f"has no comparison: expected {_COMPARE}")
    known = [condition.name for condition in part.conditions]
    made: list[Comparison] = []
    for baseline, better, fault in (*_compare(table), *_pairs(table)):
        for key, name in (("baseline", baseline), ("better", better)):
            if name not in known:
                raise fault(key, f"an {unknown_name('condition', name, known)} in part '{part.name}'")
        if baseline == better or {baseline, better} in [{other.baseline, other.better} for other in made]:
            why = "a condition beside itself" if baseline == better else "the same pair a second time"
            raise fault("", f"'{better}' over '{baseline}': {why}; expected each comparison once")
        made.append(Comparison(part.name, baseline, better))
    return tuple(made)


def _compare(table: Table) -> Iterator[_Named]:
    entries = table.tables("compare")
    if "compare" in table and not entries:
        raise table.fault("compare", f"is empty: expected {_COMPARE}")
    for entry in entries:

        def fault(key: str, says: str, entry: Table = entry) -> KeyFault:
            return entry.fault(key or "better", f"{'is' if key else 'has'} {says}")

        yield entry.text("baseline"), entry.text("better"), fault


def _pairs(table: Table) -> Iterator[_Named]:
    example = 'like [["late", "warped"]]'
    pairs = table.raw("pairs") if "pairs" in table else None
    if "pairs" in table and (not isinstance(pairs, list) or not pairs):
        raise table.fault("pairs", f"is no list of pairs: expected names of conditions, {example}")
    for number, pair in enumerate(pairs or ()):
        if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
            raise table.fault("pairs", f"has {quoted(pair)}: expected pairs of names, {example}", number)

        def fault(_: str, says: str, number: int = number) -> KeyFault:
            return table.fault("pairs", f"has {says}", number)

        yield pair[0], pair[1], fault


_PRACTICE = "practice"
UNTIL_DONE, LONGEST_S = "until done", 600.0
_MOST_ASKED = 3  # questions of a questionnaire after each trial
_PRACTICE_DEFAULTS = {"latency": 0, "warp": "none", "fill": "none"}


def _scale_at(table: Table, key: str, name: str, folder: Path, *within: int) -> Scale:
    """Load a shipped scale, or a .toml file next to the study's. Errors: KeyFault."""
    try:
        return load_scale(str(folder / name), folder) if name.endswith(".toml") else load_scale(name)
    except InputError as error:
        raise table.fault(key, f"has '{name}': {error}", *within) from error


def _scales_of(table: Table, key: str, folder: Path, *, questionnaires: bool = False) -> tuple[Scale, ...]:
    """Load the scales of a list: questionnaires before or after, or what follows each trial."""
    names = table.texts(key, ()) if questionnaires else table.texts(key)
    made: list[Scale] = []
    for number, name in enumerate(names):
        scale = _scale_at(table, key, name, folder, number)
        if not questionnaires and scale.kind == QUESTIONNAIRE and (scale.scores or len(scale.items) > _MOST_ASKED):
            found = f"has '{name}', a questionnaire of {len(scale.items)} items{' with scores' if scale.scores else ''}"
            wanted = f"expected a scale that takes a moment, {_MOST_ASKED} questions at most and no scores"
            raise table.fault(key, f"{found}: {wanted}", number)
        if questionnaires and scale.kind == PREFERENCE:
            found = f"has '{name}', a {PREFERENCE}, which is about a pair: it belongs in [trial]"
            raise table.fault(key, found, number)
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
    shows = trial.word("shows", _SHOWS, ONE)
    if shows == PAIR:
        if len(preferences) != 1 or any(scale.kind not in (PREFERENCE, QUESTIONNAIRE) for scale in made):
            wanted = f"expected one scale of kind {PREFERENCE}, such as preference, and perhaps a short questionnaire"
            raise trial.fault(key, f"is {names}, after a pair: {wanted}")
        return
    if preferences:
        raise trial.fault(key, f"has '{preferences[0].name}', a {PREFERENCE}: it needs shows = \"{PAIR}\"")
    if all(scale.kind != RATING for scale in made):  # tables of ratings and the analysis hold only that kind
        wanted = "expected one scale of kind rating at least; the others belong in [sickness]"
        raise trial.fault(key, f"has no rating ({names}): {wanted}")
    for scale in made:
        if scale.kind == RATING and scale.beside_reference != (shows == REFERENCE_FIRST):
            found, first = f"has '{scale.name}', which asks", f'shows = "{REFERENCE_FIRST}"'
            beside = f"for the difference from a reference shown right before: it needs {first}"
            other = "nothing about the reference: expected dcr, or a scale with beside_reference = true, with"
            raise trial.fault(key, f"{found} {beside if scale.beside_reference else f'{other} {first}'}")


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


def _practice_of(data: Table, checker: _Checker) -> Condition | None:
    """Return the practice, None without its table; it looks like [common], without a warp."""
    if _PRACTICE not in data:
        return None
    table, others = data.table(_PRACTICE), ("seconds",)
    own = {key: value for key, value in _all_of(table).items() if key not in others}
    settings = checker.settings(table, own, _PRACTICE, beneath=_PRACTICE_DEFAULTS, only=PICTURE, others=others)
    return Condition(_PRACTICE, settings)


def _sickness_of(data: Table, folder: Path) -> Sickness | None:
    """Return the sickness rule, None without [sickness]."""
    if "sickness" not in data:
        return None
    table = data.table("sickness")
    scale = _scale_at(table, "scale", table.text("scale"), folder)
    if scale.kind == QUESTIONNAIRE:
        found = f"has '{scale.name}', a questionnaire of {len(scale.items)} items"
        raise table.fault("scale", f"{found}: expected a scale that takes a moment")
    if scale.kind in (RATING, PREFERENCE):
        found = f"has '{scale.name}', a {scale.kind}, and would stand among those of the trials"
        raise table.fault("scale", f"{found}: expected fms, misc or the like")
    stop_at = table.within("stop_at", scale.least, scale.most, None)
    if stop_at is not None and scale.badness(stop_at) <= 0:
        found = f"is {stop_at:g}, the best answer of '{scale.name}'"
        raise table.fault("stop_at", f"{found}: expected a worse one, or every session stops at once")
    rise = table.within("rise", 0, scale.most - scale.least, None, above=True)
    return Sickness(scale, **fields_in(table, Sickness), stop_at=stop_at, rise=rise)


def _consent_of(data: Table, folder: Path) -> Consent | None:
    """Return the consent, None without [consent]; its text is there or in a file next to it."""
    if "consent" not in data:
        return None
    table = data.table("consent")
    version = fields_in(table, Consent)
    if ("text" in table) == ("file" in table):
        raise table.fault(None, "needs either text, or file: a text beside the study file")
    return Consent(**version, text=table.text("text") if "text" in table else _text_of(table, folder))


def page_of(data: Table, key: str, title: str, folder: Path, checked: bool) -> Page | None:
    """Return a page to read, None without its table. checked: False leaves its file alone."""
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
_PNG_OR_JPEG = attrs.evolve(PICTURE_FILE, what="a PNG or JPEG file")


def open_picture(path: Path | str, folder: Path | None = None) -> Image:
    """Load a picture, RGBA. folder: as `opened` takes it. Errors: InputError."""
    from PIL import Image

    try:
        with opened(path, _PNG_OR_JPEG, folder) as plain, Image.open(plain) as file:
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
    path = Path(name_or_path)
    if not name_or_path.endswith(".toml"):
        if name_or_path not in study_names():
            if path.is_file():
                raise InputError(f"study file {path}: expected one whose name ends in .toml")
            raise unknown_name("study", name_or_path, [*study_names(), "FILE.toml"])
        path = SHIPPED / f"{name_or_path}.toml"
    text = text_of(path, f"a .toml file, or one of {', '.join(study_names())}")
    try:
        return design_from_text(text, str(path), checked=checked)
    except InputError as error:
        if checked:
            raise
        raise InputError(f"{error}; sessions that hmdwarp 0.2 ran with this plan are exported by that one") from error


def design_from_text(text: str, path: str, *, checked: bool = True) -> Design:
    """Return the plan of a text.

    path: of its file, for messages and for files it names. checked: False does not try the
    settings, because the scenes of an old session may be gone. Errors: as load_design.
    """
    folder = Path(path).parent

    def made(data: Table) -> Design:
        if (schema := data.whole("schema", 0, 2**31)) != SCHEMA:
            raise data.fault("schema", f"is {schema}: expected {SCHEMA}, which this version of hmdwarp reads")
        trial = data.table("trial")
        checker = _Checker(folder, data.table("common") if "common" in data else Table({}), checked)
        scales, sickness = _scales_of(trial, "scales", folder), _sickness_of(data, folder)
        asked = data.table("questionnaires") if "questionnaires" in data else Table({})
        before, after = (_scales_of(asked, key, folder, questionnaires=True) for key in ("before", "after"))
        if sickness is not None and sickness.scale.name in [scale.name for scale in scales]:
            found = f"has '{sickness.scale.name}', which is also that of [sickness]: leave it out of one of them"
            raise trial.fault("scales", found)
        parts = parts_of(data, checker)
        seconds, until_done = length_of(trial)
        return Design(
            name=name_of(data, ()),
            **fields_in(data, Design),
            parts=parts,
            scales=scales,
            families=_families_of(data, parts),
            seconds=seconds,
            until_done=until_done,
            practice=_practice_of(data, checker),
            breaks=Breaks(**fields_in(data.table("breaks"), Breaks)) if "breaks" in data else Breaks(),
            sickness=sickness,
            before=before,
            after=after,
            consent=_consent_of(data, folder),
            instructions=page_of(data, "instructions", "Instructions", folder, checked),
            ready=page_of(data, "ready", "Ready?", folder, checked),
            thanks=page_of(data, "thanks", "Thank you", folder, checked),
            text=text,
            path=path,
            scene_notes=checker.scene_notes,
        )

    return parsed(text, path, made, _EXAMPLE)


_TEMPLATE = Path(__file__).parent / "plan_template.toml"


def write_new_plan(name: str, folder: Path, *, force: bool = False) -> Path:
    """Write NAME.toml, a commented plan that can be run as it is, and return its path.

    Errors: InputError for a wrong name, an existing file, unless forced, and a folder not writable.
    """
    if not NAME.fullmatch(name) or name.endswith(".toml"):
        raise InputError(f"study name {quoted(name)}: {NAME_WANTED}, without .toml")
    path = folder / f"{name}.toml"
    refuse_existing(path, force=force)
    write_text(path, _TEMPLATE.read_text(encoding="utf-8").format(name=name))
    return path
