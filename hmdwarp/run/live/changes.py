"""What each control does to the options of a run."""

from __future__ import annotations

from collections.abc import Callable

import attrs

from ...client.variants import every_fill, every_warp
from ...display import Command
from ...display.controls import control
from ...errors import InputError
from ...pipeline.options import AUTO
from ...scenes import scenes
from .options import BOTH, FLAT, LiveOptions

LATENCY_STEP_MS, GUARD_STEP = 50.0, 0.25


def choices() -> dict[str, tuple[object, ...]]:
    """What the controls of kind "choice" may be set to."""
    return {
        "warp": tuple(every_warp()),
        "fill": tuple(every_fill()),
        "scene": tuple(scenes.names()),
        "effects": ("auto", "none"),
    }


def values(options: LiveOptions) -> dict[str, object]:
    """What each control that changes the run is set to."""
    return {
        "latency": options.latency_ms,
        "warp": options.warp,
        "fill": options.fill,
        "guard": options.guard,
        "scene": options.scene,
        "effects": options.effects,
        "lens": options.lens,
        "view": options.view,
    }


def changed(options: LiveOptions, command: Command) -> LiveOptions:
    """The options after the command. Errors: InputError for a value that cannot be meant."""
    name, value = command.control, command.value
    if name not in _STEPS:
        raise InputError(f"control '{name}' changes nothing of the run: wanted {', '.join(_STEPS)}")
    value = _STEPS[name](options, -1 if command.back else 1) if value is None else _meant(name, value)
    return attrs.evolve(options, **{"latency_ms" if name == "latency" else name: value})


def _meant(name: str, value: object) -> object:
    """A number within its span, a word for everything else."""
    asked = control(name)
    if asked.kind != "number":
        if not isinstance(value, str):
            raise InputError(f"{name} {value!r}: wanted a word")
        return value
    least, most = asked.span
    if not isinstance(value, int | float) or not least <= value <= most:
        raise InputError(f"{name} {value}: wanted a number from {least:g} to {most:g}")
    return float(value)


def _along(name: str) -> Callable[[LiveOptions, int], object]:
    def step(options: LiveOptions, direction: int) -> object:
        known, now = choices()[name], values(options)[name]
        at = known.index(now) + direction if now in known else 0
        return known[at % len(known)]

    return step


def _latency(options: LiveOptions, direction: int) -> float:
    return _within("latency", options.latency_ms + direction * LATENCY_STEP_MS)


def _guard(options: LiveOptions, direction: int) -> float:
    return _within("guard", options.guard + direction * GUARD_STEP)


def _within(name: str, value: float) -> float:
    least, most = control(name).span
    return min(max(value, least), most)


def _lens(options: LiveOptions, _: int) -> str:
    return "none" if options.lens != "none" else AUTO


def _view(options: LiveOptions, _: int) -> str:
    return FLAT if options.view == BOTH else BOTH


_STEPS: dict[str, Callable[[LiveOptions, int], object]] = {
    **{name: _along(name) for name in ("warp", "fill", "scene", "effects")},
    "latency": _latency,
    "guard": _guard,
    "lens": _lens,
    "view": _view,
}
