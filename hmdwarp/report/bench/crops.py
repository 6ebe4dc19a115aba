"""Crops of what methods show, beside their error maps: the worst instant and a typical one."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...metrics import PRIMARY, Kept
from ..charts import INK, SERIES, Drawn, axes_in, drawing, empty_figure, svg_text
from ..files import ERROR_TOP, magma

_PAGE_IN, _LEAST_IN = 9.6, 7.0
_TITLE_IN, _THUMB, _THUMB_PX = 0.42, 1.6, 320  # the whole truth is as wide as so many crops
_LEAST_PX = 24


@attrs.frozen(eq=False)
class Crops:
    """The crops of one instant."""

    # "worst" or "typical".
    which: str
    # Of the methods, and the FLIP of their whole pictures.
    names: Sequence[str]
    flips: Sequence[float]
    # The whole truth, small; and the crop's left, top and side as shares of its width.
    truth: NDArray[Any]
    place: Sequence[float]
    # (n + 1, side, side, 3), the truth first; FLIP 0..1 as bytes, (n, side, side).
    shown: NDArray[Any]
    errors: NDArray[Any]

    @classmethod
    def of(cls, which: str, kept: Mapping[str, Kept]) -> Crops:
        """Cut out the square in which the methods' FLIP is highest on average. kept: by method."""
        from PIL import Image

        jobs = [each.job for each in kept.values()]
        maps = np.stack([np.asarray(one.result.error_map) for one in kept.values()])
        truth, (high, wide) = jobs[0].now.truth, maps.shape[1:]
        side = min(high, wide, max(_LEAST_PX, high // 5))
        sums = np.pad(maps.mean(axis=0).cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
        boxes = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
        top, left = map(int, np.unravel_index(boxes.argmax(), boxes.shape))
        here = np.s_[top : top + side, left : left + side]
        small = Image.fromarray(truth)
        small.thumbnail((_THUMB_PX, _THUMB_PX), Image.Resampling.LANCZOS)
        flips = [one.result.values[PRIMARY] or 0.0 for one in kept.values()]
        shown, errors = np.stack([truth[here], *(job.now.shown[here] for job in jobs)]), maps[(slice(None), *here)]
        return cls(which, [*kept], flips, np.asarray(small), (left / wide, top / wide, side / wide), shown, errors)


def packed(crops: Sequence[Crops]) -> bytes:
    """Return crops as the content of a file."""
    data = io.BytesIO()
    arrays = {f"{at} {name}": value for at, one in enumerate(crops) for name, value in attrs.asdict(one).items()}
    np.savez_compressed(data, **arrays)
    return data.getvalue()


def unpacked(data: bytes) -> list[Crops]:
    """Return the crops of such a file."""
    found = np.load(io.BytesIO(data))
    names = [field.name for field in attrs.fields(Crops)]
    counts = range(len(found.files) // len(names))
    return [Crops(str(found[f"{at} which"]), *(found[f"{at} {name}"] for name in names[1:])) for at in counts]


def crops_chart(crops: Sequence[Crops], width_in: float | None = None) -> Drawn:
    """Draw crops as an <svg> element: truth and methods, FLIP maps below. width_in: of a column."""
    wide = _PAGE_IN if width_in is None else max(width_in, _LEAST_IN)
    cell = wide / (len(crops[0].shown) + _THUMB)
    line = 2 * cell + 2 * _TITLE_IN
    with drawing([one.shown.tobytes() for one in crops] + [width_in], 9 if width_in is None else 7):
        figure = empty_figure(wide, line * len(crops))

        def show(x: float, y: float, picture: NDArray[Any], title: str, size: float = 1.0) -> Any:
            high = size * cell * picture.shape[0] / picture.shape[1]
            axes = axes_in(figure, (x * cell, y - high, (x + size) * cell - 0.05, y - 0.05))
            axes.imshow(picture, interpolation="none")
            axes.set_axis_off()
            axes.set_title("\n".join(textwrap.wrap(title, 22)), color=INK, fontsize="small", pad=3)
            return axes

        for number, one in enumerate(crops):
            top = figure.get_size_inches()[1] - number * line - _TITLE_IN
            left, above, side = (share * one.truth.shape[1] for share in one.place)
            axes = show(0, top, one.truth, f"{one.which} instant", _THUMB - 0.1)
            axes.plot(
                [left, left + side, left + side, left, left], [above, above, above + side, above + side, above],
                color=SERIES[1], linewidth=1.5,
            )  # fmt: skip
            for at, (picture, name) in enumerate(zip(one.shown, ("ground truth", *one.names), strict=True)):
                show(_THUMB + at, top, picture, str(name))
            for at, (levels, flip) in enumerate(zip(one.errors, one.flips, strict=True), 1):
                show(_THUMB + at, top - cell - _TITLE_IN / 2, magma(levels / 255 / ERROR_TOP), f"FLIP {flip:.3f}")
        drawn = svg_text(figure)
    drawn.at_width = lambda column: crops_chart(crops, column)
    return drawn
