"""What a page says of its display, checked; and what a live run on it would know."""

from __future__ import annotations

import json
import math
from typing import Any

import attrs

from ..errors import InputError
from ..frames import EyeSizes
from ..geometry import Fov, Pose
from ..headsets import Headset, HeadsetEye
from ..link.codec import codecs
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
_NUMBERS, _MOST_RAD = 11, 1.57  # of a view


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


def _views(_: object, __: object, value: object) -> None:
    """Check each eye's place and direction in the head, then four angles. Errors: BadLog."""
    if not (isinstance(value, tuple) and 1 <= len(value) <= 2 and all(isinstance(one, list) for one in value)):
        raise BadLog("views: expected those of one eye or two")
    for view in value:
        if len(view) != _NUMBERS or any(isinstance(n, bool) or not isinstance(n, int | float) for n in view):
            raise BadLog(f"views: expected {_NUMBERS} numbers each")
        *pose, left, right, down, up = view
        # A head's bones and a lens allow much less.
        if not (all(abs(n) <= 1 for n in pose) and abs(math.hypot(*pose[3:]) - 1) <= 1e-6):
            raise BadLog("views: an eye that is beside the head, or an orientation that is no unit quaternion")
        if not (-_MOST_RAD <= left < right <= _MOST_RAD and -_MOST_RAD <= down < up <= _MOST_RAD):
            raise BadLog("views: a field of view that is empty or out of range")


@attrs.frozen
class BrowserDisplay:
    """What a page says of its display. Errors: BadLog for anything out of range."""

    chains: tuple[str, ...] = attrs.field()
    codec: str = attrs.field()  # of the colours
    views: tuple[list[float], ...] = attrs.field(validator=_views)
    browser: str = words(300)
    renderer: str = words(300)
    trace: str = words(80)
    width: int = number(1, 16384)
    height: int = number(1, 16384)
    rendered_width: int = number(1, 16384)
    rendered_height: int = number(1, 16384)
    rate_hz: float = number(1, 1000)
    latency_ms: float = number(0, 60_000)
    guard: float = number(1, 4)

    @chains.validator
    def _check_chains(self, _: object, value: object) -> None:
        if not (isinstance(value, tuple) and value and all(one in [*CHAINS] for one in value)):
            raise BadLog(f"chains: expected some of {', '.join(CHAINS)}")

    @codec.validator
    def _check_codec(self, _: object, value: object) -> None:
        if value not in [*codecs.names()]:
            raise BadLog(f"codec: expected one of {', '.join(codecs.names())}")

    @property
    def eyes(self) -> int:
        """How many views there are."""
        return len(self.views)

    @property
    def size(self) -> tuple[int, int]:
        """Pixels of an eye's picture."""
        return self.width, self.height

    @property
    def headset(self) -> Headset:
        """Its views as a headset's, a window's for both eyes. Errors: BadLog."""
        eyes = tuple(HeadsetEye(Pose(view[:3], view[3:7]), Fov(*view[7:])) for view in self.views)
        about = "the views of a browser's display"
        try:
            return Headset("browser", about, about, self.size, self.rate_hz, (eyes[0], eyes[-1]))
        except InputError as error:
            raise BadLog(str(error)) from error

    @classmethod
    def of(cls, said: object) -> BrowserDisplay:
        """Read what a page said. Errors: BadLog."""
        names = {field.name for field in attrs.fields(cls)}
        if not isinstance(said, dict) or set(said) != names:
            raise BadLog(f"expected the keys {', '.join(sorted(names))}")
        lists = {name: tuple(said[name]) if isinstance(said[name], list) else () for name in ("chains", "views")}
        return cls(**{**said, **lists})


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
    headset, size = display.headset, display.size
    fovs = (headset.fov(0), headset.fov(1))[: display.eyes]
    try:
        options = LiveOptions(
            scene=scene, source=DESKTOP, warp=display.chains[0], fill=FILL, lens="none", latency_ms=display.latency_ms,
            guard=display.guard,
        )  # fmt: skip
    except InputError as error:
        raise BadLog(str(error)) from error
    shared = Facts(
        options, display.trace, scene, [], "browser",
        EyeSizes((display.rendered_width, display.rendered_height), size, fovs), display.rate_hz,
        fovs[0].pixels_per_degree(size), {"gl_renderer": display.renderer, "gl_version": "WebGL 2", "cpu_count": 1},
        "wall",
    )  # fmt: skip
    return LiveFacts(shared, options, "browser", {"browser": display.browser}, "none", ())
