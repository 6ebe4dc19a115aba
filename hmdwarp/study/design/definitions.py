"""Definition of a study: parts, conditions, scales, comparisons. All classes are frozen."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...display.desktop import window_view
from ...errors import InputError
from ...headsets import FILE_ENDINGS as HEADSET_FILES
from ...headsets import load_headset
from ...options import DISPLAY as OF_DISPLAY
from ...options import PICTURE as OF_PICTURE
from ...options import Table, keep_inside, options_of, quoted, read_by, reads
from ...pipeline import SceneKey, Source, guarded_size
from ...run import EmulatedScreen, LiveOptions, Run, checked_source, on_screen
from ...scenes import FILE_ENDINGS as SCENE_FILES
from ..scales import Scale

ORDERS = (WILLIAMS, RANDOM, FIXED) = ("williams", "random", "fixed")
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
    shows: str = read_by(Table.word, SHOWS, default=ONE, at="trial.shows")
    # Presentations of each condition, or pair.
    repeats: int = read_by(Table.whole, 1, 1000, default=1, at="trial.repeats")
    order: str = read_by(Table.word, ORDERS, default=WILLIAMS, at="trial.order")
    seed: int = read_by(Table.whole, 0, 2**63 - 1, default=0)
    blind: str = read_by(Table.word, BLIND, default=BOTH)  # who must not see the condition
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
NAMED_FILES = {"headset": HEADSET_FILES, "scene": SCENE_FILES}
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
    values = {"latency": options.latency_ms, "warp": options.warp, "fill": options.fill}
    if options.rendered_size is None:
        values["guard"] = options.guard
    values["predict"] = options.predict
    return {**values, **{key.replace("-", "_"): value for key, value in settings.items()}}


def default_of(name: str) -> object:
    """Return what a setting is that no condition sets."""
    return next(option.default for option in _OPTIONS if option.name == name)


def check_settings(settings: Mapping[str, object], sources: dict[SceneKey, Source]) -> LiveOptions:
    """Return the options after trying everything that needs no display.

    sources: those opened so far; this one is added.
    Errors: InputError and its kin, now and not in the middle of a session.
    """
    options = live_options(settings)
    if not options.source_kind.has_head:  # the sizes of recorded frames are known once they are opened
        headset, band = load_headset(options.headset), options.guard_band
        width, height = guarded_size(band, headset, options.size or headset.eye_size_px)
        if max(width, height) > _MOST_PIXELS:
            found = f"{band} makes frames of {width}x{height} pixels"
            raise InputError(f"{found}: expected at most {_MOST_PIXELS} on each side, as most GPUs have it")
    source = sources[options.scene_key] = checked_source(options, sources.get(options.scene_key))
    screen = EmulatedScreen(source.headset, window_view(options.view, source.headset, options.size).eyes)
    Run.of(on_screen(source.fitted(options), screen), source, screen)
    return options


def resolve_paths(folder: Path, settings: Mapping[str, object], others: Sequence[str] = ()) -> dict[str, object]:
    """Return the settings with absolute paths, and names with _.

    folder: of the study file. others: keys of the same table that are no settings, for hints.
    """
    found: dict[str, object] = {}
    for key, name, value in _named(settings, others):
        found[name] = value
        is_file = isinstance(value, str) and (name in FILES or value.lower().endswith(NAMED_FILES.get(name, ())))
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
