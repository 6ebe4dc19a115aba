"""Reference pictures: what an eye should see.

The scene drawn for the view itself, in bands where the display lights up row by row.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.inputs import PassInputs
from ..geometry import Fov, View
from ..gpu.textures import download
from ..sources.server import Renderer

# Over half a band the picture turns by a quarter of a pixel, up to the limit on bands; each band is
# drawn separately.
PIXELS_PER_BAND = 0.5
MOST_BANDS = 64
NEAR_M = 1.0  # nearest surface considered; nearer ones move by more as the head moves


@attrs.frozen(eq=False)
class Truth:
    """Colour (h, w, 4) in linear light and inverse depth (h, w) in 1/m, top row first.

    None where not requested.
    """

    colour: NDArray[np.float16]
    inverse_depth: NDArray[np.float32] | None


def draw_truth(server: Renderer, inputs: PassInputs, size: tuple[int, int], *, depth: bool = True) -> Truth:
    """Return the scene as the eye should see it at this refresh, (w, h) pixels before the lens."""
    if inputs.shown_last is None:
        return _drawn(server, inputs.shown, inputs.shown_ns, size, depth)
    bands = bands_of(inputs.shown, inputs.shown_last, size)
    drawn = [_drawn(server, view, inputs.shown_ns, (size[0], rows), depth) for view, rows in bands]
    inverse = np.concatenate([band.inverse_depth for band in drawn]) if depth else None
    return Truth(np.concatenate([band.colour for band in drawn]), inverse)


def _drawn(server: Renderer, view: View, time_ns: int, size: tuple[int, int], depth: bool) -> Truth:
    image = server.draw(view, size, time_ns=time_ns)
    try:
        # Where a camera knows no depth, what it saw counts as infinitely far.
        inverse = np.maximum(download(image.inverse_depth), 0) if depth else None
        return Truth(download(image.colour), inverse)
    finally:
        server.pool(size).release(image.colour)


def bands_of(first: View, last: View, size: tuple[int, int]) -> Iterator[tuple[View, int]]:
    """Return (view, rows) of each band of a (w, h) picture, from the top.

    The view covers the band's part of the field of view, at the time when its middle lights up.

    Pixel centres are those of the whole picture.
    """
    left, right, down, up = first.fov.tangents
    high = size[1]
    ends = np.linspace(0, high, band_count(first, last, size) + 1).round().astype(int)
    for top, bottom in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        low, above = (up - (up - down) * row / high for row in (bottom, top))
        pose = first.pose.towards(last.pose, (top + bottom) / (2 * high))
        yield attrs.evolve(first, pose=pose, fov=Fov.from_tangents((left, right, low, above))), bottom - top


def band_count(first: View, last: View, size: tuple[int, int]) -> int:
    """Return the number of bands that the head's motion requires.

    A power of 2, so that few sizes are drawn; MOST_BANDS and the rows at most.
    """
    turn = first.pose.angle_to(last.pose)
    step = float(np.linalg.norm(last.pose.position_m - first.pose.position_m))
    pixels = math.degrees(turn + step / NEAR_M) * first.fov.pixels_per_degree(size)
    wanted: int = 2 ** math.ceil(math.log2(max(pixels / PIXELS_PER_BAND, 1)))
    return min(wanted, MOST_BANDS, size[1])
