"""Charts as SVG: what all of them share, lines over time, numbered points, frames in transit.

How they look: the colours and shapes that tell warps and lines apart.

The colours are those of Okabe and Ito (2008, Color Universal Design), as dark as white paper needs
or as pale as dark paper needs. Of one who sees no green (Machado, Oliveira and Fernandes 2009) all
eight are at least 15 apart (CIEDE2000); a test computes it. Colour is never alone: warps differ in
the shape too, lines in the dashes.

Charts of a page take their colours and font from the page around them, so that one chart serves
light and dark: Matplotlib writes stand-in colours, and charts.svg_text() replaces them by the
page's CSS variables.
"""

from __future__ import annotations

import hashlib
import io
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Literal

import attrs
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

# (on light paper, on dark paper): blue, orange, black, purple, green, vermilion, yellow, sky blue.
_SERIES = (
    ("#0072b2", "#0072b2"), ("#835900", "#efc8a1"), ("#000000", "#cbcbcb"), ("#cc79a7", "#cc79a7"),
    ("#00996f", "#009e73"), ("#572200", "#d55e00"), ("#979026", "#f0e442"), ("#133344", "#56b4e9"),
)  # fmt: skip
# As many as have no factor in common with the colours: 56 pairs before one comes again.
_SHAPES = ("o", "s", "^", "D", "v", "P", "X")

# Names of colours: the CSS variables of a page, for which Matplotlib writes stand-ins.
INK, GRID, *SERIES = "--chart-ink", "--chart-grid", *(f"--series-{number}" for number in range(1, len(_SERIES) + 1))
_TONES = dict(zip(SERIES, _SERIES, strict=True))
_STAND_INS = {INK: "#010101", GRID: "#020202"} | {name: f"#0500{number:02x}" for number, name in enumerate(SERIES)}
_ON_PAPER = {INK: "#30373f", GRID: "#e2e6ea"} | {name: light for name, (light, _) in _TONES.items()}
_is_on_paper = ContextVar("is_on_paper", default=False)


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
    return " ".join(f"{name}: {tones[dark]};" for name, tones in _TONES.items())


Style = dict[str, Any]  # keyword arguments of Matplotlib's functions


@contextmanager
def drawing(content: object, font_size: float = 9) -> Iterator[None]:
    """Set Matplotlib up: the same content gives the same text; charts share no ids."""
    from matplotlib import rc_context
    from matplotlib.colors import get_named_colors_mapping

    salt = hashlib.sha256(repr(content).encode(errors="replace")).hexdigest()
    settings: Any = {
        "svg.fonttype": "none", "svg.hashsalt": salt, "font.size": font_size, "font.sans-serif": ["DejaVu Sans"],
        "hatch.linewidth": 0.7, "text.parse_math": False, "axes.unicode_minus": True,
    }  # fmt: skip
    for name, colour in (_ON_PAPER if _is_on_paper.get() else _STAND_INS).items():
        get_named_colors_mapping()[name] = colour  # one by one: that clears its cache
    with rc_context(settings), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")  # a file name may hold any letter
        yield


def _dress(axes: Axes, *, grid: Literal["both", "x", "y"] = "both") -> None:
    """Draw no box, a pale grid, everything else in ink; grid: the axis whose lines are drawn."""
    axes.patch.set_visible(False)
    axes.grid(True, axis=grid, color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    for side, spine in axes.spines.items():
        spine.set_visible(side == "bottom")
        spine.set_color(INK)
    axes.tick_params(colors=INK, which="both", length=0)
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_color(INK)


def _not_measured(axes: Axes) -> None:
    """Say in the middle of empty axes that there is nothing to draw."""
    axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", va="center", color=INK)


class Drawn(str):
    """A chart as an <svg> element, and the figure that it was drawn as."""

    figure: Any
    # Draws it again as wide as a column of a paper, in inches; None for a page.
    at_width: Callable[[float | None], Drawn]


def svg_text(figure: Any) -> Drawn:
    """Return a figure as an <svg> element of a page, which sets width and colours."""
    figure.patch.set_visible(False)
    buffer, layout = io.StringIO(), figure.get_layout_engine()
    if layout is not None:  # savefig would draw all twice, once for it
        figure.set_dpi(72)  # as an SVG has it
        layout.execute(figure)
        figure.set_layout_engine(None)
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    figure.set_layout_engine(layout)
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    for name, stand_in in _STAND_INS.items():
        text = text.replace(stand_in, f"var({name})")
    # Matplotlib's <style> would reach the whole page, and its group ids are the same in every
    # chart.
    text = re.sub(r"<style.*?</style>", "", text, flags=re.DOTALL)
    text = re.sub(r'<g id="[^"]*"', "<g", text)
    head, rest = text.split(">", 1)
    parts = [part for part in head.split('" ') if not part.startswith(("width=", "height="))]
    drawn = Drawn('" '.join(parts) + ">" + rest)
    drawn.figure = figure
    return drawn


@contextmanager
def canvas(
    content: object,
    size_in: tuple[float, float],
    *,
    x: str = "",
    y: str = "",
    grid: Literal["both", "x", "y"] = "both",
    box: tuple[float, float, float, float] | None = None,
    font_size: float = 9,
) -> Iterator[Axes]:
    """Yield the axes of a chart of `content` in stand-in colours, to be returned by svg_text.

    x, y: labels of the axes. box: their fixed place, as axes_in takes it, else as much as there is.
    """
    with drawing(content, font_size):
        figure = empty_figure(*size_in, layout=None if box else "constrained")
        axes = axes_in(figure, box) if box else figure.add_subplot()
        _dress(axes, grid=grid)
        axes.set(xlabel=x, ylabel=y)
        yield axes


def empty_figure(width_in: float, height_in: float, layout: Literal["constrained"] | None = None) -> Figure:
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), layout=layout)
    FigureCanvasSVG(figure)
    return figure


def paper_bytes(drawn: Drawn, kind: str, width_in: float | None = None) -> bytes:
    """Return a chart for white paper as a file without a date: "svg", "pdf" or "png"."""
    dates = {"svg": {"Date": None, "Creator": None}, "pdf": {"CreationDate": None, "Creator": None}}
    about: Any = {"dpi": 200 if kind == "png" else 72, "metadata": dates.get(kind, {"Software": None})}
    data, token = io.BytesIO(), _is_on_paper.set(True)
    try:
        figure = drawn.at_width(width_in).figure
        with drawing(str(drawn)):
            figure.patch.set(visible=True, facecolor="white")
            figure.savefig(data, format=kind, **about)
    finally:
        _is_on_paper.reset(token)
    return data.getvalue()


def png_of(figure: Any, dpi: int) -> bytes:
    """Return a figure as a PNG file; the same content gives the same bytes."""
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=dpi, metadata={"Software": None})
    return data.getvalue()


def axes_in(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Add axes at a fixed place (left, bottom, right, top in inches)."""
    width, height = figure.get_size_inches()
    left, bottom, right, top = box
    return figure.add_axes((left / width, bottom / height, (right - left) / width, (top - bottom) / height))


def legend(where: Axes | FigureBase, handles: Sequence[Any], **style: Any) -> None:
    """Draw a legend without a frame. handles: as mark makes them."""
    where.legend(handles=handles, frameon=False, labelcolor=INK, **style)


def mark(label: str = "", **style: Any) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **{"color": INK, **style})


def name_rows(axes: Axes, names: Sequence[str], above: float = 0.6) -> None:
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.4, -above)


_DASHES = ("solid", (0, (4, 2)), (0, (1, 1.5)))  # lines differ in more than colour
_MOST_POINTS = 400  # about one per device pixel; a run of hours makes a page no larger than one of minutes
_FEW_POINTS = 12  # fewer are drawn as dots too: a line alone could be missed


@attrs.frozen(eq=False)
class Series:
    """One line of a chart."""

    label: str
    # 1-D and of one length, in order of time; NaN leaves a gap.
    time_s: NDArray[np.float64]
    value: NDArray[np.float64]

    @classmethod
    def of(cls, label: str, rows: Iterable[Mapping[str, Any]], column: str, scale: float = 1.0) -> Series:
        """Take a column of frames.csv's rows against time; rows without a value are left out."""
        pairs = [(row["time_s"], row[column] * scale) for row in rows if row.get(column) is not None]
        points = np.array(sorted(pairs), dtype=np.float64).reshape(-1, 2)
        return cls(label, points[:, 0], points[:, 1])


def binned(series: Series, bins: int = _MOST_POINTS) -> tuple[Series, Series, Series]:
    """Return mean, least and largest value of each instant (of two eyes), pooled into `bins`."""
    there = np.isfinite(series.value)
    time_s, value = series.time_s[there], series.value[there]
    instants, index = np.unique(time_s, return_inverse=True)
    if len(instants) > bins:
        edges = np.linspace(instants[0], instants[-1], bins + 1)
        index = np.clip(np.searchsorted(edges, time_s, side="right") - 1, 0, bins - 1)
        _, index = np.unique(index, return_inverse=True)
    count = index.max() + 1 if len(index) else 0
    amount = np.bincount(index, minlength=count)
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, index, value)
    np.maximum.at(high, index, value)
    time_s = np.bincount(index, time_s, minlength=count) / amount
    mean = np.bincount(index, value, minlength=count) / amount
    return Series(series.label, time_s, mean), Series("", time_s, low), Series("", time_s, high)


def time_series(series: Sequence[Series], unit: str, *, from_zero: bool = True, points: bool = False) -> str:
    """Draw at most three lines over time as one <svg> element.

    A pale band spans the values of the two eyes, or of the pooled frames. Empty series are left
    out; a chart of nothing says so. The same data give the same text.
    unit: of the vertical axis, "" for a plain number. points: draw each instant, unless pooled.
    """
    content = [(line.label, line.value.tobytes()) for line in series]
    with canvas(content, (5.0, 2.2), x="time in s", y=unit) as axes:
        drawn = 0
        for number, (mean, low, high) in enumerate(map(binned, series)):
            if not len(mean.value):
                continue
            drawn, look = drawn + 1, Look.of(number)
            marker = look.marker if len(mean.value) <= (_MOST_POINTS - 1 if points else _FEW_POINTS) else ""
            if (high.value > low.value).any():
                axes.fill_between(mean.time_s, low.value, high.value, color=look.color, alpha=0.2, linewidth=0)
            style: Style = {"linestyle": _DASHES[number], "linewidth": 1.0 if points else 1.3, "marker": marker}
            axes.plot(mean.time_s, mean.value, color=look.color, label=mean.label, markersize=3, **style)
        axes.margins(x=0.01)
        if from_zero:
            axes.set_ylim(bottom=0)
            axes.set_ylim(top=max(axes.get_ylim()[1], 1e-9))
        if not drawn:
            _not_measured(axes)
        elif len(series) > 1:
            handles, _ = axes.get_legend_handles_labels()
            above: Style = {"loc": "lower left", "bbox_to_anchor": (0, 1), "ncols": 2}
            legend(axes, handles, **above, borderaxespad=0, handlelength=2.5)
        return svg_text(axes.get_figure())


_NOTHING = 1e-3  # a microsecond, a kbit/s, an error that rounds to 0.000


def scale_axis(axis: Any, values: np.ndarray, *, logarithmic: bool) -> np.ndarray:
    """Set limits with a margin around the values, and plain numbers at the ticks.

    Returns where the values are drawn. A logarithmic axis has no zero: what is below _NOTHING is
    drawn a step before the least of the others, at a tick that says 0.
    """
    from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullLocator

    limits = axis.axes.set_xlim if axis.axis_name == "x" else axis.axes.set_ylim
    if not logarithmic:
        low, high = values.min(), values.max()
        margin = max(0.08 * (high - low), 0.5)
        limits(low - margin, high + margin)
        axis.set_major_locator(MaxNLocator(6))
        return values
    some = values[values >= _NOTHING]
    least, most = (some.min(), some.max()) if len(some) else (_NOTHING, _NOTHING)
    drawn = np.where(values < _NOTHING, least / 2, values)
    low, high = np.log10([drawn.min(), most])
    # At least a factor of four, so that two ticks are in it.
    margin = max(0.06 * (high - low), (np.log10(4) - (high - low)) / 2)
    scale = axis.axes.set_xscale if axis.axis_name == "x" else axis.axes.set_yscale
    scale("log")
    limits(10 ** (low - margin), 10 ** (high + margin))
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high - low > 1 else (1, 1.5, 2, 3, 5, 7)))
    axis.set_minor_locator(NullLocator())
    has_zero = len(some) < len(values)
    if has_zero:
        axis.set_major_locator(FixedLocator([least / 2, *(tick for tick in axis.get_majorticklocs() if tick >= least)]))
    axis.set_major_formatter(lambda value, _: "0" if has_zero and value < least else f"{value:g}")
    return drawn


_SIDES = np.array([(1, 0.8), (-1, 0.8), (1, -0.8), (-1, -0.8), (0, 1.2), (0, -1.2), (1.4, 0), (-1.4, 0)])
_SIDES_PT = np.concatenate([9 * _SIDES, 15 * _SIDES])
# From a number's middle to those of other points and of other numbers, across and up.
_FROM_POINT_PT, _FROM_NUMBER_PT = (8.0, 7.0), (13.0, 9.0)


def draw_numbers(axes: Axes, numbers: Mapping[int, int], points: np.ndarray, is_best: np.ndarray) -> None:
    """Write numbers beside points, bold where the point is best; the legend has their names.

    numbers: by the index of the point. Each stands on the first side with room, or where most is.
    """
    at = axes.transData.transform(points) * 72 / axes.figure.dpi
    placed: list[np.ndarray] = []
    for index, number in numbers.items():
        places = (at[index] + _SIDES_PT)[:, None]
        others = np.delete(at, index, axis=0)
        apart = [
            np.abs(places - others) / _FROM_POINT_PT,
            np.abs(places - np.reshape(placed, (-1, 2))) / _FROM_NUMBER_PT,
        ]
        side = int(np.concatenate(apart, axis=1).max(axis=2).min(axis=1, initial=1).argmax())
        placed.append(at[index] + _SIDES_PT[side])
        axes.annotate(
            str(number), points[index], _SIDES_PT[side], textcoords="offset points", ha="center", va="center",
            weight="bold" if is_best[index] else "normal", color=INK, zorder=6, annotation_clip=False,
        )  # fmt: skip


@attrs.frozen
class Spot:
    """A method in a chart of error against cost."""

    cost: float
    # The mean, and the ends of its interval.
    error: Sequence[float]
    look: Look
    # On the front: no other beats it in both.
    is_best: bool
    # Its place in the legend, None for those that the legend leaves out.
    number: int | None


def _draw_spots(axes: Axes, spots: Sequence[Spot], *, higher: bool = False) -> None:
    """Draw methods, those of a look joined, the front filled. higher: whether higher is better."""
    if not spots:
        axes.set_xticks([])
        axes.set_yticks([])
        _not_measured(axes)
        return
    cost = scale_axis(axes.xaxis, np.array([spot.cost for spot in spots]), logarithmic=True)
    errors = np.array([spot.error for spot in spots], np.float64).ravel()
    error, low, high = scale_axis(axes.yaxis, errors, logarithmic=not higher).reshape(-1, 3).T
    is_best = np.array([spot.is_best for spot in spots])
    front = np.flatnonzero(is_best)[np.argsort(cost[is_best], kind="stable")]
    if len(front):
        x = [cost[front[0]], *cost[front], axes.get_xlim()[1]]
        y = [axes.get_ylim()[0 if higher else 1], *error[front], error[front[-1]]]
        axes.plot(x, y, drawstyle="steps-post", color=INK, linewidth=1.1, alpha=0.55, zorder=2)
    axes.vlines(cost, low, high, colors=[spot.look.color for spot in spots], linewidth=1, alpha=0.45, zorder=2)
    style: Style = {"markersize": 6.5, "markeredgewidth": 1.5, "linestyle": "none", "clip_on": False}
    for spot, x, y in zip(spots, cost, error, strict=True):
        face = spot.look.color if spot.is_best else "none"
        axes.plot(x, y, **style, **attrs.asdict(spot.look), markerfacecolor=face, zorder=3 + spot.is_best)
    for look in dict.fromkeys(spot.look for spot in spots):
        own = sorted((x, y) for spot, x, y in zip(spots, cost, error, strict=True) if spot.look == look)
        axes.plot(*zip(*own, strict=True), color=look.color, linewidth=0.7, alpha=0.6, zorder=1)
    numbers = {index: spot.number for index, spot in enumerate(spots) if spot.number is not None}
    draw_numbers(axes, numbers, np.stack([cost, error], axis=1), is_best)


_BESIDE_IN = (7.7, 4.2)  # right end of the axes and least height, with the names at the right
_ABOVE: Style = {"xycoords": "axes fraction", "textcoords": "offset points"}
_KEY: Style = {
    "borderaxespad": 0.1, "handletextpad": 0.3, "columnspacing": 1.2, "borderpad": 0.2, "handlelength": 1.5,
}  # fmt: skip


def spots_chart(
    content: object, spots: Sequence[Spot], names: Mapping[int, str], *, x: str, y: str, higher: bool = False,
    width_in: float | None = None, font_size: float = 9,
) -> Drawn:  # fmt: skip
    """Draw methods' error against a cost as an <svg> element, with the names of their numbers.

    names: by number. higher: whether a higher value of y is better. width_in: names stand below;
    None has them at the right.
    """
    numbered = {f"{spot.number} {names[spot.number]}": spot.look for spot in spots if spot.number is not None}
    line, letter = 0.021 * font_size, 0.0088 * font_size
    longest, place = max(map(len, numbered), default=0), Style(loc="upper left", ncols=1)
    if width_in is None:
        right, least = _BESIDE_IN
        size = (right + 0.4 + letter * longest, max(least, line * len(numbered) + 0.2))
        box, place["bbox_to_anchor"] = (0.62, 0.5, right, size[1] - 0.36), ((right + 0.1) / size[0], 1)
    else:
        place["ncols"] = max(1, int(width_in / (0.3 + letter * longest)))
        foot = line * -(-len(numbered) // place["ncols"]) + 0.1
        size, place["bbox_to_anchor"] = (width_in, foot + 2.8), (0, foot / (foot + 2.8))
        box = (0.5, foot + 0.4, width_in - 0.08, foot + 2.5)
    with canvas((content, width_in), size, x=x, y=y, box=box, font_size=font_size) as axes:
        _draw_spots(axes, spots, higher=higher)
        if spots:
            axes.annotate("better ↖" if higher else "better ↙", (1, 1), (0, 4), **_ABOVE, ha="right", color=INK)
        key = mark("Pareto front (filled, bold)", linewidth=1.1, alpha=0.55)
        legend(axes, [key], loc="lower left", bbox_to_anchor=(0, 1), **_KEY)
        of_names: Style = {"linestyle": "none", "markersize": 5}
        handles = [mark(label, **attrs.asdict(look), **of_names) for label, look in numbered.items()]
        legend(axes.figure, handles, **place, **_KEY)
        drawn = svg_text(axes.figure)
    drawn.at_width = lambda wide: spots_chart(
        content, spots, names, x=x, y=y, higher=higher, width_in=wide, font_size=9 if wide is None else 7
    )
    return drawn


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
    size_in = (10.0, 1.3 + 0.2 * len(timeline))
    labels: Style = {"x": "ms since the first of them was drawn", "y": "frame"}
    with canvas([dict(frame) for frame in timeline], size_in, **labels, grid="x") as axes:
        for row, frame in enumerate(timeline):
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
        name_rows(axes, [str(frame["frame"]) for frame in timeline])
        axes.margins(x=0.01)
        handle_of = {handle.get_label(): handle for handle in axes.get_legend_handles_labels()[0]}
        handles = [handle_of[label] for label in (*(_PARTS[name][0] for name in named), _WAITS, _SEEN)]
        above: Style = {"loc": "lower left", "bbox_to_anchor": (0, 1), "ncols": 9}
        legend(axes, handles, **above, borderaxespad=0, handlelength=1.8, columnspacing=1.2)
        return svg_text(axes.get_figure())
