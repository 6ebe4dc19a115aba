"""Plots and bars of the last refreshes against the refresh budget."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from statistics import fmean

import attrs
import numpy as np
from imgui_bundle import imgui, implot

from ...controls import KEPT, Status
from . import panel_style as style

HEIGHT = 34.0  # of a plot, at a content scale of 1
CALM = 15  # refreshes averaged in a printed number: a quarter of a second, to be readable
BARE = implot.Flags_.canvas_only | implot.Flags_.no_inputs | implot.Flags_.no_frame
AXIS = implot.AxisFlags_.no_decorations


@attrs.frozen
class Plot:
    """One line over the last refreshes."""

    name: str
    values: Sequence[float]
    unit: str = "ms"
    limit: float | None = None  # value of a horizontal line, None for none
    names_limit: bool = False  # whether the number includes the limit
    over: float = math.inf  # above this the number is highlighted as bad
    least: float = 1.0  # lowest top of the axis, so that noise does not fill the plot


def plots_of(status: Status) -> list[Plot]:
    """Return what is plotted, from the top."""
    budget = status.budget_ms or None
    bad = budget or math.inf
    latency = status.values.get("latency")
    holes = [100 * share for share in status.holes]
    return [
        Plot("all passes", status.total_ms, limit=budget, names_limit=True, over=bad, least=1.2 * (budget or 1.0)),
        # Any two refreshes differ a little; half a refresh late means a missed picture.
        Plot("between pictures", status.period_ms, limit=budget, over=1.5 * bad, least=2 * (budget or 1.0)),
        Plot(
            "frame age at display",
            status.age_ms,
            limit=latency if isinstance(latency, int | float) and latency else None,
            least=20.0,
        ),
        Plot("pose age at hand-over", status.pose_age_ms, least=5.0),
        Plot("holes before the fill", holes, unit="%", least=5.0),
    ]


def draw_plots(status: Status, scale: float) -> None:
    """Draw all of them, one under the other."""
    for plot in plots_of(status):
        values = np.fromiter(plot.values, np.float64, len(plot.values))
        # fmax ignores NaN; a tenth more keeps the line off the edge.
        top = ceiling(1.1 * max(float(np.fmax.reduce(values, initial=plot.least)), plot.limit or 0.0))
        now = calm(plot.values)
        imgui.text_disabled(plot.name)
        imgui.same_line()
        imgui.text_colored(imgui.ImVec4(*style.FAINT), f"0 to {top:g}")
        right_aligned(number_text(now, plot), style.BAD if now is not None and now > plot.over else style.TEXT)
        _draw(plot, values, top, scale)


def _draw(plot: Plot, values: np.ndarray, top: float, scale: float) -> None:
    if not implot.begin_plot(f"##{plot.name}", (-1, HEIGHT * scale), BARE):
        return
    implot.setup_axes("", "", AXIS, AXIS)
    implot.setup_axes_limits(0, KEPT - 1, 0, top, implot.Cond_.always)
    if plot.limit is not None:
        flags = int(implot.InfLinesFlags_.horizontal)
        implot.plot_inf_lines("limit", np.array([plot.limit]), implot.Spec(line_color=style.LIMIT, flags=flags))
    known = np.isfinite(values)  # holes are not counted at every refresh; a NaN would become a corner of the drawing
    if known.any():
        at = np.arange(KEPT - len(values), KEPT, dtype=np.float64)[known]  # the newest at the right edge
        implot.plot_shaded("area", at, values[known], 0, implot.Spec(fill_color=style.ACCENT, fill_alpha=0.22))
        implot.plot_line("line", at, values[known], implot.Spec(line_color=style.ACCENT, line_weight=1.4 * scale))
    implot.end_plot()


def calm(values: Iterable[float]) -> float | None:
    """Return the mean of the last few numbers; None for none."""
    last = [value for value in list(values)[-CALM:] if not math.isnan(value)]
    return fmean(last) if last else None


def number_text(value: float | None, plot: Plot) -> str:
    """Return a number and its unit, in about three figures; "-" for none."""
    limit = f" of {plot.limit:.1f}" if plot.names_limit and plot.limit else ""
    return "-" if value is None else f"{value:.{0 if abs(value) >= 100 else 1}f}{limit} {plot.unit}"


def ceiling(most: float) -> float:
    """Return the next round number: it keeps the axis steady while values change."""
    if not (math.isfinite(most) and most > 0):
        return 1.0
    ten = 10.0 ** math.floor(math.log10(most))
    return next(ten * step for step in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12) if ten * step >= most * (1 - 1e-9))


def right_aligned(text: str, colour: style.Rgba) -> None:
    """Draw at the right end of the current line."""
    imgui.same_line()
    room = imgui.get_content_region_avail().x - imgui.calc_text_size(text).x
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(room, 0.0))
    imgui.text_colored(imgui.ImVec4(*colour), text)


class Stages:
    """The stages of the last refresh, end to end in one bar against the budget, with their times.

    A stage keeps its colour.
    """

    def __init__(self) -> None:
        self._order: list[str] = []
        self._calm: dict[str, float] = {}

    def draw(self, status: Status, scale: float) -> None:
        """Draw both eyes' times."""
        self._take(status.stage_ms)
        if not self._calm:
            imgui.text_disabled("not measured yet")
            return
        self._bar(status.budget_ms, scale)
        self._legend()

    def _take(self, stage_ms: dict[str, float]) -> None:
        """Drop stages that are gone; change the others slowly, so that they can be read."""
        self._order += [name for name in stage_ms if name not in self._order]
        self._calm = {name: took + 0.7 * (self._calm.get(name, took) - took) for name, took in stage_ms.items()}

    def _colour(self, name: str) -> style.Rgba:
        return style.STAGES[self._order.index(name) % len(style.STAGES)]

    def _bar(self, budget_ms: float, scale: float) -> None:
        total = sum(self._calm.values())
        width, height = imgui.get_content_region_avail().x, 14.0 * scale
        whole = max(total, budget_ms * 1.04) or 1.0
        at = imgui.get_cursor_screen_pos()
        draw = imgui.get_window_draw_list()
        draw.add_rect_filled((at.x, at.y), (at.x + width, at.y + height), style.u32((1, 1, 1, 0.06)), 3 * scale)
        x = at.x
        for name in self._shown():
            wide = width * self._calm[name] / whole
            draw.add_rect_filled((x, at.y), (x + wide, at.y + height), style.u32(self._colour(name)))
            x += wide
        if budget_ms:
            x = at.x + width * budget_ms / whole
            draw.add_line((x, at.y - 3 * scale), (x, at.y + height + 3 * scale), style.u32(style.WARN), 1.5 * scale)
        imgui.dummy((width, height + 3 * scale))

    def _shown(self) -> list[str]:
        return [name for name in self._order if name in self._calm]

    def _legend(self) -> None:
        if not imgui.begin_table("stages", 2, imgui.TableFlags_.sizing_stretch_same | imgui.TableFlags_.pad_outer_x):
            return
        for name in self._shown():
            imgui.table_next_column()
            at, size = imgui.get_cursor_screen_pos(), imgui.get_font_size()
            square = (at.x, at.y + 0.28 * size), (at.x + 0.55 * size, at.y + 0.83 * size)
            imgui.get_window_draw_list().add_rect_filled(*square, style.u32(self._colour(name)), 0.12 * size)
            imgui.dummy((0.55 * size, size))
            imgui.same_line()
            imgui.text_disabled(name)
            right_aligned(f"{self._calm[name]:.1f}", style.TEXT)
        imgui.end_table()
