"""How the bench's charts tell warps, fills and regions apart: the same colour, dash and marker in every chart.

Warps of one kind share a hue: greys do nothing, ochres know no depth or one plane, blues scatter, reds gather, greens draw triangles,
purples know more than one layer. Colour is never alone: points and lines carry their names, lines of one hue differ in their dashes, fills
in the marker, regions in the hatching.
"""

from __future__ import annotations

import hashlib
import re
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import attrs

from . import charts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# name: (on light paper, on dark paper, dash). Every colour has a contrast of 3 or more to its paper; a test computes it.
_WARPS: dict[str, tuple[str, str, int]] = {
    "none": ("#6b7280", "#9aa3ad", 0),
    "rotation": ("#a87400", "#e3b341", 0),
    "planar": ("#7a5200", "#f5d78a", 1),
    "environment": ("#c08a00", "#b98a1e", 2),
    "forward_raster": ("#4f93d8", "#4b8fd6", 3),
    "forward": ("#0b63c5", "#6db3ff", 0),
    "forward_ordered": ("#0a3d80", "#b3d7ff", 1),
    "splat": ("#00869c", "#45cfe0", 2),
    "backward": ("#c2410c", "#ff8a4c", 0),
    "iterative": ("#e0561f", "#ffb38a", 1),
    "search": ("#7c2d12", "#e86a3c", 2),
    "mesh": ("#1b7a3d", "#4fc274", 0),
    "mesh_adaptive": ("#3f9a5d", "#a6e6b8", 1),
    "multi": ("#b0309b", "#f08fdf", 0),
    "layered": ("#5b2a9c", "#b79cff", 1),
}
_OTHERS = (("#8a3b5c", "#e8a0bf", 3), ("#4d6b00", "#b9d94e", 3), ("#005f5f", "#5fd0c0", 3), ("#3d3d8f", "#a3a8f5", 3))
_REGIONS = (("#2b3440", "#eef1f4"), ("#7d8a99", "#94a1b0"), ("#c3ccd6", "#4a5563"))
HATCHES = ("", "////", "")
DASHES: tuple[Any, ...] = ("solid", (0, (5, 2)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)))
_MARKERS = {"none": "o", "interpolate": "s"}
_MORE_MARKERS = ("^", "D", "v", "P", "X", "p", "<", ">", "h", "*")


def warp_of(spec: str) -> str:
    """The registered name in a spec with settings: "mesh:cut=slope" is a mesh."""
    return spec.partition(":")[0]


def _key(spec: str) -> str:
    """What a warp's colour is called: its own name, or one of a few for warps that came later than this table."""
    name = warp_of(spec)
    return name if name in _WARPS else f"other-{zlib.crc32(name.encode()) % len(_OTHERS)}"


_TONES = {**_WARPS, **{f"other-{number}": tone for number, tone in enumerate(_OTHERS)}}
# Colours that Matplotlib writes and svg_text() replaces by the page's variables.
_STAND_INS = {key: f"#0500{number:02x}" for number, key in enumerate(_TONES)}
_REGION_STAND_INS = tuple(f"#0600{number:02x}" for number in range(len(_REGIONS)))
_VARIABLES = {stand_in: f"--warp-{key.replace('_', '-')}" for key, stand_in in _STAND_INS.items()}
_VARIABLES |= {stand_in: f"--region-{number}" for number, stand_in in enumerate(_REGION_STAND_INS)}


@attrs.frozen
class Palette:
    """The colours of a chart: stand-ins for a page that has a light and a dark form, or real ones for a picture."""

    ink: str
    grid: str
    regions: tuple[str, ...]
    is_page: bool

    def warp(self, spec: str) -> str:
        """The colour of a warp, whatever its settings are."""
        return _STAND_INS[_key(spec)] if self.is_page else _TONES[_key(spec)][0]


PAGE = Palette(charts.INK, charts.GRID, _REGION_STAND_INS, True)
PAPER = Palette("#30373f", "#e2e6ea", tuple(light for light, _ in _REGIONS), False)


def css_variables(dark: bool) -> str:
    """The declarations that give the page's charts their colours, for light or for dark paper."""
    values = [(f"--warp-{key.replace('_', '-')}", tones[dark]) for key, tones in _TONES.items()]
    values += [(f"--region-{number}", tones[dark]) for number, tones in enumerate(_REGIONS)]
    return " ".join(f"{name}: {value};" for name, value in values)


def dashes_of(specs: Iterable[str]) -> dict[str, Any]:
    """A dash for the line of each spec; the settings of one warp, which share its colour, differ."""
    chosen: dict[str, Any] = {}
    seen: dict[str, int] = {}
    for spec in specs:
        if spec not in chosen:
            name = warp_of(spec)
            chosen[spec] = DASHES[(_TONES[_key(spec)][2] + seen.get(name, 0)) % len(DASHES)]
            seen[name] = seen.get(name, 0) + 1
    return chosen


def markers_of(fills: Iterable[str]) -> dict[str, str]:
    """A marker for each fill; those that this table does not know get theirs by the order of their names."""
    fills = set(fills)
    unknown = sorted(fills - set(_MARKERS))
    chosen = {fill: _MARKERS[fill] for fill in sorted(fills & set(_MARKERS))}
    return chosen | {fill: _MORE_MARKERS[number % len(_MORE_MARKERS)] for number, fill in enumerate(unknown)}


@contextmanager
def drawing(content: object, font_size: float = 9) -> Iterator[None]:
    """Matplotlib's settings for a chart of `content`, so that the same content gives the same text, and two charts share no ids."""
    import warnings

    from matplotlib import rc_context

    salt = hashlib.sha256(repr(content).encode(errors="replace")).hexdigest()
    settings = {
        "svg.fonttype": "none", "svg.hashsalt": salt, "font.size": font_size, "font.sans-serif": ["DejaVu Sans"],
        "hatch.linewidth": 0.7, "text.parse_math": False, "axes.unicode_minus": True,
    }  # fmt: skip
    with rc_context(settings), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")  # a file name may hold any letter
        yield


def dress(axes: Axes, palette: Palette, *, grid: str = "both") -> None:
    """No box, a pale grid behind, everything else in ink; grid: the axis whose lines are drawn."""
    axes.patch.set_visible(False)
    axes.grid(True, axis=grid, color=palette.grid, linewidth=0.6)
    axes.set_axisbelow(True)
    for side, spine in axes.spines.items():
        spine.set_visible(side == "bottom")
        spine.set_color(palette.ink)
    axes.tick_params(colors=palette.ink, which="both", length=0)
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_color(palette.ink)


def svg_text(figure: Any) -> str:
    """A figure drawn in PAGE's colours as an <svg> element to stand in the page."""
    figure.patch.set_visible(False)
    text = charts.svg_text(figure)
    return re.sub(r"#0[56]00[0-9a-f]{2}\b", lambda found: f"var({_VARIABLES[found[0]]})", text)
