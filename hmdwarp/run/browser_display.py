"""What a page says of its display, checked; and what a live run on it would know."""

from __future__ import annotations

import json
from typing import Any

import attrs

from ..errors import InputError
from ..frames import EyeSizes
from ..geometry import Fov
from ..web import STEPS
from .live_summary import LiveFacts
from .options import DESKTOP, LiveOptions
from .run_summary import Facts


class BadLog(ValueError):
    """What a page says is none of its reports."""


MOST_TEXT = 4096  # characters of the line about a display
# As page/chain.js has them, and as hmdwarp's own warps are named.
CHAINS = {
    "iterative": f"iterative:seed=rotation,steps={STEPS}",
    "mesh:grid=64": "mesh:grid=64",
    "rotation": "rotation",
}
FILL = "pyramid"


def number(least: float, most: float) -> Any:
    def check(_: object, field: attrs.Attribute[Any], value: object) -> None:
        if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
            raise BadLog(f"{field.name} {value!r:.40}: expected a number from {least:g} to {most:g}")

    return attrs.field(validator=check)


def words(most: int) -> Any:
    def check(_: object, field: attrs.Attribute[Any], value: object) -> None:
        if not (isinstance(value, str) and len(value) <= most and value.isprintable()):
            raise BadLog(f"{field.name}: expected at most {most} printable characters")

    return attrs.field(validator=check)


@attrs.frozen
class BrowserDisplay:
    """What a page says of its display. Errors: BadLog for anything out of range."""

    chains: tuple[str, ...] = attrs.field()
    browser: str = words(300)
    renderer: str = words(300)
    trace: str = words(80)
    eyes: int = number(1, 2)
    width: int = number(1, 16384)
    height: int = number(1, 16384)
    rendered_width: int = number(1, 16384)
    rendered_height: int = number(1, 16384)
    left: float = number(-1.57, 1.57)
    right: float = number(-1.57, 1.57)
    down: float = number(-1.57, 1.57)
    up: float = number(-1.57, 1.57)
    rate_hz: float = number(1, 1000)
    latency_ms: float = number(0, 60_000)
    guard: float = number(1, 4)

    @chains.validator
    def _check_chains(self, _: object, value: object) -> None:
        if not (isinstance(value, tuple) and value and all(one in [*CHAINS] for one in value)):
            raise BadLog(f"chains: expected some of {', '.join(CHAINS)}")

    def __attrs_post_init__(self) -> None:
        if not (self.left < self.right and self.down < self.up):
            raise BadLog("a field of view that is empty")

    @classmethod
    def of(cls, said: object) -> BrowserDisplay:
        """Read what a page said. Errors: BadLog."""
        names = {field.name for field in attrs.fields(cls)}
        if not isinstance(said, dict) or set(said) != names:
            raise BadLog(f"expected the keys {', '.join(sorted(names))}")
        return cls(**{**said, "chains": tuple(said["chains"]) if isinstance(said["chains"], list) else ()})


def said_in(text: str, most: int) -> Any:
    """Return what a line of JSON says. Errors: BadLog."""
    if len(text) > most:
        raise BadLog(f"{len(text)} characters: expected at most {most}")
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadLog(f"no JSON ({type(error).__name__})") from error


def facts_of(display: BrowserDisplay, scene: str) -> LiveFacts:
    """Return what a live run here would know of the display. Errors: BadLog."""
    fov, size = Fov(display.left, display.right, display.down, display.up), (display.width, display.height)
    try:
        options = LiveOptions(
            scene=scene, source=DESKTOP, warp=display.chains[0], fill=FILL, lens="none", latency_ms=display.latency_ms,
            guard=display.guard,
        )  # fmt: skip
    except InputError as error:
        raise BadLog(str(error)) from error
    shared = Facts(
        options, display.trace, scene, [], "browser",
        EyeSizes((display.rendered_width, display.rendered_height), size, (fov,) * display.eyes), display.rate_hz,
        fov.pixels_per_degree(size), {"gl_renderer": display.renderer, "gl_version": "WebGL 2", "cpu_count": 1}, "wall",
    )  # fmt: skip
    return LiveFacts(shared, options, "browser", {"browser": display.browser}, "none", ())
