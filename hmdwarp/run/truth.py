"""Reference pictures, what an eye should see, and what a run showed in their place.

The scene drawn for the view itself, in bands where the display lights up row by row; pictures read
back from the GPU (the passes must not be fused with the lens); whole pictures of frames that carry
parts of them as layers.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.compensator import EyeResult
from ..client.inputs import PassInputs
from ..client.plan import Plan
from ..colour import picture_from_linear
from ..frames import EyeImage, Frame
from ..frames.layers import layers
from ..geometry import Fov, View
from ..gpu.textures import download
from ..pipeline.channel import Reads
from ..pipeline.loop import Loop, Refresh
from ..sources.server import Renderer

# Over half a band the picture turns by a quarter of a pixel, up to the limit on bands; each band is
# drawn separately.
PIXELS_PER_BAND = 0.5
MOST_BANDS = 64
NEAR_M = 1.0  # nearest surface considered; nearer ones move by more as the head moves


@attrs.frozen(eq=False)
class Truth:
    """What one eye should see: colour (h, w, 4) in linear light, inverse depth (h, w) in 1/m.

    Top row first. Depth is None where not requested.
    """

    colour: NDArray[np.float16]
    inverse_depth: NDArray[np.float32] | None

    @functools.cached_property
    def picture(self) -> NDArray[np.uint8]:
        """The colour as sRGB, (h, w, 3)."""
        return picture_from_linear(self.colour)


def draw_truth(server: Renderer, inputs: PassInputs, size: tuple[int, int], *, depth: bool = True) -> Truth:
    """Return the scene as the eye should see it at this refresh, (w, h) pixels before the lens.

    Errors: NoTruth.
    """
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
        return Truth(_black_where_hidden(download(image.colour), view), inverse)
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


def shown_picture(result: EyeResult) -> NDArray[np.uint8]:
    """Return the picture before the lens: (h, w, 3) sRGB, top row first."""
    assert result.shown is not None
    return _black_where_hidden(picture_from_linear(download(result.shown.texture)), result.view)


def _black_where_hidden(picture: NDArray[Any], view: View) -> NDArray[Any]:
    if view.hidden is None:
        return picture
    return np.where(view.seen((picture.shape[1], picture.shape[0]))[..., None], picture, picture.dtype.type(0))


def coverage(result: EyeResult) -> NDArray[np.floating]:
    """Return the coverage (h, w) after the warp, before the fill."""
    assert result.warped is not None
    return download(result.warped.texture)[..., 3]


class WholePictures:
    """The inputs of plans that run along with others on the same frames.

    Frames for a plan with effects lack what its layers show by themselves (mirrors, glass, the
    HUD), and frames that no plan reads a picture of have none. A plan without such layers gets the
    picture as if frames were drawn for it alone: it is drawn again, once for each frame and eye,
    and held until the next frame.
    """

    def __init__(self, server: Renderer) -> None:
        self._server = server
        self._frame: Frame | None = None
        self._drawn: dict[int, EyeImage] = {}

    def inputs(self, loop: Loop, refresh: Refresh, plan: Plan) -> tuple[PassInputs, ...]:
        """Return the inputs of the plan for the refresh just shown."""
        every, eye = loop.inputs(refresh, plan.needs), refresh.frame.eyes[0]
        apart = [name for name in eye.carried if layers.get(name).apart]
        is_apart = apart and not any(name in plan.needs for name in apart)
        if not is_apart and eye.left_out.isdisjoint(Reads.of([plan]).names):
            return every
        if refresh.frame is not self._frame:
            self.close()
            self._frame = refresh.frame
        return tuple(attrs.evolve(eye_inputs, rendered=self._whole(eye_inputs)) for eye_inputs in every)

    def _whole(self, inputs: PassInputs) -> EyeImage:
        image = inputs.rendered
        if inputs.eye not in self._drawn:
            self._drawn[inputs.eye] = self._server.draw(image.view, image.size, time_ns=image.drawn_ns)
            self._server.gpu.timer.collect()
        drawn = self._drawn[inputs.eye]
        return attrs.evolve(image, colour=drawn.colour, inverse_depth=drawn.inverse_depth, left_out=frozenset())

    def close(self) -> None:
        """Return the pictures to the server."""
        for image in self._drawn.values():
            self._server.pool(image.size).release(image.colour)
        self._drawn, self._frame = {}, None


_GOLDEN = (5**0.5 - 1) / 2


def is_measured(number: int, every: int) -> bool:
    """Return whether refresh `number` is the measured one of its n = `every`.

    Its place among them is spread by the golden ratio, which is in step with no period: of misses,
    of a server's frames, of a head that nods. The first refresh is measured, and each run measures
    the same ones.
    """
    block, place = divmod(number, every)
    return place == int(every * (block * _GOLDEN % 1))
