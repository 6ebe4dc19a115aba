"""How charts look: the colours and shapes that tell warps, lines and regions apart.

The colours are those of Okabe and Ito (2008, Color Universal Design), as dark as white paper needs
or as pale as dark paper needs. Of one who sees no green (Machado, Oliveira and Fernandes 2009) all
eight are at least 15 apart (CIEDE2000); a test computes it. Colour is never alone: warps differ in
the shape too, lines in the dashes, regions in the hatching.

Charts of a page take their colours and font from the page around them, so that one chart serves
light and dark: Matplotlib writes stand-in colours, and charts.svg_text() replaces them by the
page's CSS variables.
"""

from __future__ import annotations

import attrs

# (on light paper, on dark paper): blue, orange, black, purple, green, vermilion, yellow, sky blue.
_SERIES = (
    ("#0072b2", "#0072b2"), ("#835900", "#efc8a1"), ("#000000", "#cbcbcb"), ("#cc79a7", "#cc79a7"),
    ("#00996f", "#009e73"), ("#572200", "#d55e00"), ("#979026", "#f0e442"), ("#133344", "#56b4e9"),
)  # fmt: skip
# As many as have no factor in common with the colours: 56 pairs before one comes again.
_SHAPES = ("o", "s", "^", "D", "v", "P", "X")
_REGIONS = (("#11161d", "#ffffff"), ("#4a5563", "#c3ccd6"), ("#8e9aa8", "#8e9aa8"), ("#d5dbe2", "#3c4652"))
HATCHES = ("", "....", "////", "")

# Stand-in colours, all of one length, and the CSS variables that replace them.
INK, GRID = "#010101", "#020202"
SERIES = tuple(f"#0500{number:02x}" for number in range(len(_SERIES)))
REGION_COLOURS = tuple(f"#0600{number:02x}" for number in range(len(_REGIONS)))
_TONES = dict(zip((*SERIES, *REGION_COLOURS), (*_SERIES, *_REGIONS), strict=True))
CSS_VARIABLES = {INK: "--chart-ink", GRID: "--chart-grid"}
CSS_VARIABLES |= {stand_in: f"--series-{number}" for number, stand_in in enumerate(SERIES, 1)}
CSS_VARIABLES |= {stand_in: f"--region-{number}" for number, stand_in in enumerate(REGION_COLOURS)}
# What a chart of a page has on white paper, by stand-in.
PAPER_COLOURS = {INK: "#30373f", GRID: "#e2e6ea", **{stand_in: light for stand_in, (light, _) in _TONES.items()}}


@attrs.frozen
class Look:
    """The colour, as a stand-in, and the marker of one of several things in a chart."""

    color: str
    marker: str

    @classmethod
    def of(cls, number: int) -> Look:
        """Return that of a number from 0; neighbours differ in both."""
        return cls(SERIES[number % len(SERIES)], _SHAPES[number % len(_SHAPES)])


def css_variables(dark: bool) -> str:
    """Return the CSS declarations of the colours of charts, for light or dark paper."""
    return " ".join(f"{CSS_VARIABLES[stand_in]}: {tones[dark]};" for stand_in, tones in _TONES.items())
