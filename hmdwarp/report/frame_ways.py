"""The time line of frames: each one's way from the server to the eye, part by part, as SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from .style import GRID, INK, PAGE, SERIES, drawing, dress, svg_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# (label, colour, opacity, hatch): the server's work, the network and the client's have a colour
# each.
_PARTS = {
    "render": ("render", SERIES[0], 1.0, ""),
    "encode": ("encode", SERIES[0], 0.5, ""),
    "queue": ("queue", GRID, 1.0, "...."),
    "transfer": ("size / bandwidth", GRID, 1.0, "////"),
    "network": ("round trip", GRID, 1.0, ""),
    "hold": ("wait for the decoder", SERIES[1], 0.5, ""),
    "decode": ("decode", SERIES[1], 1.0, ""),
}
_WAITS, _SEEN = "wait for the refresh", "on the screen"
_HIGH = 0.6  # of a bar, in rows


def timeline_svg(timeline: Sequence[Mapping[str, Any]]) -> str:
    """Draw one line for each frame, the oldest on top; "" without frames.

    timeline: as in summary.json. A thin line is the wait for the display's refresh, a thick one the
    time on the screen. Parts that no frame has are left out.
    """
    if not timeline:
        return ""
    named = [name for name in _PARTS if any(frame["parts"].get(name) for frame in timeline)]
    with drawing([dict(frame) for frame in timeline]):
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10.0, 1.3 + 0.2 * len(timeline)), layout="constrained")
        axes = figure.add_subplot()
        for row, frame in enumerate(timeline):
            _draw(axes, row, frame, named)
        dress(axes, grid="x")
        axes.set_ylim(len(timeline) - 0.4, -0.6)
        axes.set_yticks(range(len(timeline)), [str(frame["frame"]) for frame in timeline])
        axes.set_xlabel("ms since the first of them was drawn")
        axes.set_ylabel("frame")
        axes.margins(x=0.01)
        handles, labels = axes.get_legend_handles_labels()
        handle_of = dict(zip(labels, handles, strict=True))
        shown = [*(_PARTS[name][0] for name in named), _WAITS, _SEEN]
        axes.legend(
            [handle_of[label] for label in shown], shown, loc="lower left", bbox_to_anchor=(0, 1), ncols=9,
            frameon=False, labelcolor=PAGE.ink, borderaxespad=0, handlelength=1.8, columnspacing=1.2,
        )  # fmt: skip
        return svg_text(figure)


def _draw(axes: Axes, row: int, frame: Mapping[str, Any], named: Sequence[str]) -> None:
    at = frame["drawn"]
    for name in named:
        label, colour, opacity, hatch = _PARTS[name]
        length = frame["parts"][name]
        axes.barh(
            row, length, _HIGH, left=at, label=label, color=colour, alpha=opacity, hatch=hatch, edgecolor=INK,
            linewidth=0,
        )  # fmt: skip
        at += length
    axes.plot((at, frame["shown"]), (row, row), color=INK, linewidth=0.8, label=_WAITS)
    axes.plot(
        (frame["shown"], frame["until"]), (row, row), color=INK, linewidth=3, label=_SEEN, marker="|",
        markersize=7,
    )  # fmt: skip
