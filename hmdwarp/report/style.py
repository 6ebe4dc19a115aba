"""How charts look: the colours and markers that tell warps, fills and regions apart.

Warps of one kind share a hue: greys do nothing, ochres know no depth or one plane, blues scatter,
reds gather, greens draw triangles, purples know more than one layer. Colour is never alone: points
have numbers, fills differ in the marker, regions in the hatching.

Charts of a page take their colours and font from the page around them, so that one chart serves
light and dark: Matplotlib writes stand-in colours, and charts.svg_text() replaces them by the
page's CSS variables.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable

import attrs

# name: (on light paper, on dark paper). Each has a contrast of 3 or more to its paper: a test
# computes it.
_WARPS: dict[str, tuple[str, str]] = {
    "none": ("#6b7280", "#9aa3ad"),
    "shift": ("#7d8700", "#c9d35a"),
    "similarity": ("#565d00", "#e2ea8c"),
    "rotation": ("#a87400", "#e3b341"),
    "planar": ("#7a5200", "#f5d78a"),
    "environment": ("#c08a00", "#b98a1e"),
    "forward_raster": ("#4f93d8", "#4b8fd6"),
    "forward": ("#0b63c5", "#6db3ff"),
    "forward_ordered": ("#0a3d80", "#b3d7ff"),
    "splat": ("#00869c", "#45cfe0"),
    "backward": ("#c2410c", "#ff8a4c"),
    "iterative": ("#e0561f", "#ffb38a"),
    "search": ("#7c2d12", "#e86a3c"),
    "mesh": ("#1b7a3d", "#4fc274"),
    "mesh_adaptive": ("#3f9a5d", "#a6e6b8"),
    "multi": ("#b0309b", "#f08fdf"),
    "layered": ("#5b2a9c", "#b79cff"),
}
_OTHERS = (("#8a3b5c", "#e8a0bf"), ("#4d6b00", "#b9d94e"), ("#005f5f", "#5fd0c0"), ("#3d3d8f", "#a3a8f5"))
_REGIONS = (("#11161d", "#ffffff"), ("#4a5563", "#c3ccd6"), ("#8e9aa8", "#8e9aa8"), ("#d5dbe2", "#3c4652"))
# Of charts that compare a few things which are no warps.
_SERIES = (("#0b63c5", "#6db3ff"), ("#b4500b", "#ffab66"), ("#6b5b95", "#c3b1f0"))
HATCHES = ("", "....", "////", "")
_MARKERS = {"none": "o", "interpolate": "s", "pyramid": "^", "memory+pyramid": "D"}
_MORE_MARKERS = ("v", "P", "X", "p", "<", ">", "h", "*")


def warp_of(spec: str) -> str:
    """Return the registered name in a spec with settings: "mesh:cut=slope" is a mesh."""
    return spec.partition(":")[0]


def _key(spec: str) -> str:
    """Return the key of a warp's colour: its name, or one of a few for unknown warps."""
    name = warp_of(spec)
    return name if name in _WARPS else f"other-{zlib.crc32(name.encode()) % len(_OTHERS)}"


_TONES = {**_WARPS, **{f"other-{number}": tone for number, tone in enumerate(_OTHERS)}}
# Stand-in colours, all of one length, and the CSS variables that replace them.
INK, GRID = "#010101", "#020202"
SERIES = ("#030303", "#040404", "#070707")
_STAND_INS = {key: f"#0500{number:02x}" for number, key in enumerate(_TONES)}
_REGION_STAND_INS = tuple(f"#0600{number:02x}" for number in range(len(_REGIONS)))
CSS_VARIABLES = {INK: "--chart-ink", GRID: "--chart-grid"}
CSS_VARIABLES |= {stand_in: f"--series-{number}" for number, stand_in in enumerate(SERIES, 1)}
CSS_VARIABLES |= {stand_in: f"--warp-{key.replace('_', '-')}" for key, stand_in in _STAND_INS.items()}
CSS_VARIABLES |= {stand_in: f"--region-{number}" for number, stand_in in enumerate(_REGION_STAND_INS)}


@attrs.frozen
class Palette:
    """The colours of a chart: stand-ins for a page (light or dark), real ones for a picture."""

    ink: str
    grid: str
    regions: tuple[str, ...]
    is_page: bool

    def warp(self, spec: str) -> str:
        """Return the colour of a warp, whatever its settings are."""
        return _STAND_INS[_key(spec)] if self.is_page else _TONES[_key(spec)][0]


PAPER_INK, PAPER_GRID = "#30373f", "#e2e6ea"
PAGE = Palette(INK, GRID, _REGION_STAND_INS, True)
PAPER = Palette(PAPER_INK, PAPER_GRID, tuple(light for light, _ in _REGIONS), False)


# What a chart of a page has on white paper, by stand-in.
PAPER_COLOURS = {INK: PAPER_INK, GRID: PAPER_GRID, **{of: tones[0] for of, tones in zip(SERIES, _SERIES, strict=True)}}
PAPER_COLOURS |= {stand_in: _TONES[key][0] for key, stand_in in _STAND_INS.items()}
PAPER_COLOURS |= {stand_in: tones[0] for stand_in, tones in zip(_REGION_STAND_INS, _REGIONS, strict=True)}


def css_variables(dark: bool) -> str:
    """Return the CSS declarations of the colours of charts, for light or dark paper."""
    values = {f"--series-{number}": tones[dark] for number, tones in enumerate(_SERIES, 1)}
    values |= {f"--warp-{key.replace('_', '-')}": (tones[1] if dark else tones[0]) for key, tones in _TONES.items()}
    values |= {f"--region-{number}": tones[dark] for number, tones in enumerate(_REGIONS)}
    return " ".join(f"{name}: {value};" for name, value in values.items())


def markers_of(fills: Iterable[str]) -> dict[str, str]:
    """Return a marker for each fill; unknown fills get theirs in the order of their names."""
    fills = set(fills)
    unknown = sorted(fills - set(_MARKERS))
    chosen = {fill: marker for fill, marker in _MARKERS.items() if fill in fills}
    return chosen | {fill: _MORE_MARKERS[number % len(_MORE_MARKERS)] for number, fill in enumerate(unknown)}
