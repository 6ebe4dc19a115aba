"""The settings of a condition: options of `hmdwarp live`, under their long names."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...display.desktop import window_view
from ...errors import InputError
from ...headsets import Headset, load_headset
from ...options import DISPLAY as OF_DISPLAY
from ...options import PICTURE as OF_PICTURE
from ...options import keep_inside, options_of, quoted
from ...pipeline import SceneKey, Source, guarded_size
from ...run import EmulatedScreen, LiveOptions, RunSetup, checked_source, on_screen

# Kinds of values in the file, which takes a number wherever the command line takes a numeric text.
_TEXT, _NUMBER, _WHOLE, _FLAG = "a text", "a number", "a whole number", "true or false"
_TEXT_OR_NUMBER = "a number or a text"
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
_NOT_SETTINGS = {option.name: option.study for option in _OPTIONS if not option.in_study}
_NOT_SETTINGS["quiet"] = "it is an option of 'hmdwarp study run'"


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


def check_settings(settings: Mapping[str, object], sources: dict[SceneKey, Source]) -> LiveOptions:
    """Return the options after trying everything that needs no display.

    sources: those opened so far; this one is added.
    Errors: InputError and its kin, now and not in the middle of a session.
    """
    options = live_options(settings)
    if not options.source_kind.has_head:  # the sizes of recorded frames are known once they are opened
        _check_guard(options, load_headset(options.headset))
    source = sources[options.scene_key] = checked_source(options, sources.get(options.scene_key))
    eyes = window_view(options.view, source.headset, options.size).eyes
    screen = EmulatedScreen(source.headset, eyes)
    RunSetup.of(on_screen(source.fitted(options), screen), source, screen)
    return options


def _check_guard(options: LiveOptions, headset: Headset) -> None:
    width, height = guarded_size(options.guard_band, headset, options.size or headset.eye_size_px)
    if max(width, height) > _MOST_PIXELS:
        found = f"{options.guard_band} makes frames of {width}x{height} pixels"
        raise InputError(f"{found}: expected at most {_MOST_PIXELS} on each side, as most GPUs have it")


def resolve_paths(folder: Path, settings: Mapping[str, object], others: Sequence[str] = ()) -> dict[str, object]:
    """Return the settings with absolute paths, and names with _.

    folder: of the study file. others: keys of the same table that are no settings, for hints.
    """
    return {name: _resolved(folder, key, name, value) for key, name, value in _named(settings, others)}


def _resolved(folder: Path, key: str, name: str, value: object) -> object:
    is_file = name in FILES or (
        isinstance(value, str) and ((name == "headset" and value.endswith(".toml")) or _is_scene_file(name, value))
    )
    if not is_file or not isinstance(value, str):
        return value
    path = folder.absolute() / value
    try:
        return str(keep_inside(path, folder, f"the file of {name}"))
    except InputError as error:
        raise SettingFault(key, f"{key} is {quoted(value)}: {error}") from error


def _is_scene_file(name: str, value: str) -> bool:
    return name == "scene" and value.lower().endswith((".glb", ".gltf", ".obj", ".ply"))


def _named(settings: Mapping[str, object], others: Sequence[str] = ()) -> list[tuple[str, str, object]]:
    """Return (key of the file, name with _, value) of each. Errors: SettingFault."""
    out: list[tuple[str, str, object]] = []
    for key, value in settings.items():
        name = key.replace("-", "_")
        if name in _NOT_SETTINGS:
            raise SettingFault(key, f"{key} is no setting of a condition: {_NOT_SETTINGS[name]}")
        if name not in KINDS:
            known = [*others, *KINDS]
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]}? " if near else ""
            raise SettingFault(key, f"unknown setting {key[:80]!r}: {hint}known are {', '.join(known)}")
        if name in [other for _, other, _ in out]:
            raise SettingFault(key, f"{key} comes twice, with - and with _: leave one of them out")
        out.append((key, name, value))
    return out


def _value(key: str, name: str, value: object) -> object:
    """Convert a value to what the command line passes. Errors: SettingFault."""
    kind = KINDS[name]
    if isinstance(value, bool) or kind == _FLAG:
        if isinstance(value, bool) and kind == _FLAG:
            return value
    elif isinstance(value, str):
        if kind in (_TEXT, _TEXT_OR_NUMBER):
            return Path(value) if name in FILES else value
    elif isinstance(value, int) and kind == _WHOLE:
        return value
    elif (
        isinstance(value, int | float)
        and kind in (_NUMBER, _TEXT_OR_NUMBER)
        and abs(value) < 2**63
        and math.isfinite(value)
    ):
        return repr(value) if kind == _TEXT_OR_NUMBER else float(value)
    raise SettingFault(key, f"{key} is {quoted(value)}: expected {kind}")
