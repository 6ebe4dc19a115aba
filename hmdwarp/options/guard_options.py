"""The guard band's two options: factors of the field of view, or the pixels that are drawn."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from typing import Any, Protocol

import attrs

from ..errors import InputError
from ..geometry import GuardBand
from .declared import option
from .limits import Number

AUTO = "auto"
# Of a run and a bench; with prediction auto gains hardly more at 200 ms, and draws more.
DEFAULT_GUARD = 1.5
Size = tuple[int, int]
Guard = float | tuple[float, float]
_FACTORS = "one factor of at least 1 (1.5) or one for each axis (1.25x1.125)"
_HELP = (
    "Ask the server for this many times the pixels on each axis, and so of the field of view in tangents: 1.5 makes "
    "2.25 times the pixels; 1.25x1.125 has a factor for each axis."
)
_BOTH = "--guard and --rendered-size both say how much the server draws: leave one of them out"


class HasGuard(Protocol):
    """Options with a guard band."""

    @property
    def guard(self) -> Guard | str:
        """The factors, or "auto"."""

    @property
    def rendered_size(self) -> Size | None:
        """The pixels that are drawn, or None."""


def parse_size(text: str, flag: str = "--size") -> Size:
    """Return (640, 400) for '640x400'. Errors: InputError."""
    match = re.fullmatch(r"(\d{1,6})\s*[xX]\s*(\d{1,6})", text.strip())
    if not match or 0 in map(int, match.groups()):
        raise InputError(f"{flag} '{text}': expected WIDTHxHEIGHT in pixels of one eye, like 640x800")
    return int(match.group(1)), int(match.group(2))


def parse_guard(text: str) -> Guard | str:
    """Return 'auto', a factor, or one for each axis. Errors: InputError."""
    if text.strip() == AUTO:
        return AUTO
    try:
        x, *y = map(float, re.split("[xX]", text))
    except ValueError as error:
        raise InputError(f"--guard '{text}': expected {_FACTORS}, or {AUTO}; pixels are --rendered-size") from error
    if len(y) > 1:
        raise InputError(f"--guard '{text}': expected {_FACTORS}, or {AUTO}")
    return (x, y[0]) if y and y[0] != x else x


def _check_guard(instance: object, field: attrs.Attribute[Any], value: Guard | str) -> None:
    if value != AUTO:
        Number(least=1.0)(instance, field, value)


def _check_rendered(instance: Any, _: attrs.Attribute[Any], value: Size | None) -> None:
    # The guard band of recorded frames is what the display leaves of their own pixels.
    is_recorded = getattr(instance, "frames", None) is not None
    if value is not None and instance.guard not in (1.0, DEFAULT_GUARD) and not is_recorded:
        raise InputError(_BOTH)


def guard_field(default: Any, more: str = "", /, **about: Any) -> Any:
    """Return the field of `--guard`. It stands before that of `--rendered-size`.

    default: a factor, or an attrs.Factory; then `more` says what it makes. more: what only some
    commands take, added to the help that all share.
    """
    # No default on the command line, to tell a guard that was set from one that was not.
    about = {"kind": str, "default": None, "numeric": True, "parse": parse_guard, "limits": _FACTORS, **about}
    said = f" [default: {default:g}]" if isinstance(default, float) else ""
    return option(default, f"{_HELP}{more}{said}", valid=_check_guard, **about)


def rendered_size_field(heading: str = "") -> Any:
    """Return the field of `--rendered-size`. heading: as of Option."""
    return option(
        None,
        "Pixels of one eye that the server draws, in place of a guard: 1600x900 for a display of 1280x800 is guard "
        "1.25x1.125, and 1.41 times the pixels.",
        metavar="WxH",
        heading=heading,
        parse=partial(parse_size, flag="--rendered-size"),
        valid=_check_rendered,
    )


def check_one_guard(said: Mapping[str, Any]) -> None:
    """Raise InputError if both options were set."""
    if said.get("guard") is not None and said.get("rendered_size") is not None:
        raise InputError(_BOTH)


def guard_band(options: HasGuard) -> GuardBand:
    """Return the guard band of the options. Errors: InputError while it is "auto"."""
    if isinstance(options.guard, str):
        raise InputError("--guard auto looks at a whole trace first: give a number, or replay a recording")
    return GuardBand.of(options.guard) if options.rendered_size is None else GuardBand(size=options.rendered_size)
