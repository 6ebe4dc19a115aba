"""User commands during a live run: how each control changes the options, and refusals."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import attrs

from ..client.variants import every_fill, every_warp
from ..display import Command, Lost, control
from ..errors import InputError, MachineError
from ..options import AUTO
from ..scenes import SceneOptions, scenes
from .host import PipelineHost
from .options import BOTH, FLAT, LiveOptions

LATENCY_STEP_MS, GUARD_STEP = 50.0, 0.25
READING_S = 4.0  # how long a refusal stays over the picture: time to read two lines


def choices() -> dict[str, tuple[object, ...]]:
    """Return the allowed values of the controls of kind "choice"."""
    return {
        "warp": tuple(every_warp()),
        "fill": tuple(every_fill()),
        "scene": tuple(scenes.names()),
        "effects": ("auto", "none"),
    }


def values(options: LiveOptions, shown: tuple[int, int] | None = None) -> dict[str, object]:
    """Return the current value of each control; of two guard factors the larger one.

    shown: (w, h) of the shown picture, to tell what a rendered size is in factors.
    """
    guard = options.guard_band if shown is None else options.guard_band.factors(shown)
    return {
        "latency": options.latency_ms,
        "warp": options.warp,
        "fill": options.fill,
        "guard": max(guard.x, guard.y),
        "scene": options.scene,
        "effects": options.effects,
        "lens": options.lens,
        "view": options.view,
    }


def changed(options: LiveOptions, command: Command) -> LiveOptions:
    """Return the options after the command. Errors: InputError for a value out of range."""
    name, value = command.control, command.value
    if name not in _STEPS:
        raise InputError(f"control '{name}' changes nothing of the run: expected {', '.join(_STEPS)}")
    options.source_kind.refuse_change(name)
    value = _STEPS[name](options, -1 if command.back else 1) if value is None else _checked(name, value)
    change: dict[str, Any] = {"latency_ms" if name == "latency" else name: value}
    if name == "scene":
        change["scene_options"] = SceneOptions()  # those of a file, which this scene is not
    if name == "guard":
        change["rendered_size"] = None
    return attrs.evolve(options, **change)


def _checked(name: str, value: object) -> object:
    """Return a number within its range, or a word unchanged. Errors: InputError."""
    meant = control(name)
    if meant.kind != "number":
        if not isinstance(value, str):
            raise InputError(f"{name} {value!r}: expected a word")
        return value
    least, most = meant.span
    if not isinstance(value, int | float) or not least <= value <= most:
        raise InputError(f"{name} {value}: expected a number from {least:g} to {most:g}")
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
    guard = options.guard_band  # a rendered size begins at 1
    return _within("guard", max(guard.x, guard.y) + direction * GUARD_STEP)


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


@attrs.define(eq=False)
class CommandHandler:
    """Apply user commands to the running pipeline."""

    host: PipelineHost
    # Called with each refusal.
    say: Callable[[str], None]
    _refused: str = ""
    _until: float = 0.0

    def handle(self, commands: Sequence[Command]) -> bool:
        """Apply the commands; return whether the options changed.

        Stepping onto a value that is refused continues to the next one.
        """
        before = self.host.options
        for command in commands:
            self._handle(command)
        return self.host.options is not before

    def _handle(self, command: Command) -> None:
        options = self.host.options
        steps = len(choices().get(command.control, ())) if command.value is None else 0
        for _ in range(max(steps, 1)):
            try:
                options = changed(options, command)
                self.host.change(options)
                return
            except Lost:
                raise
            except (InputError, MachineError) as error:  # the run continues unchanged
                self._refuse(str(error))

    def _refuse(self, why: str) -> None:
        if why != self._refused:  # the same of every value that was tried
            self.say(why)
        self._refused, self._until = why, time.monotonic() + READING_S

    @property
    def refusal(self) -> str:
        """The last refusal while it is displayed, else ""."""
        if self._refused and time.monotonic() > self._until:
            self._refused = ""
        return self._refused
