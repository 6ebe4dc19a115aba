"""The limit for a warp of a late picture: one that knows the depth that the eye should see."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..client.compensator import EyeResult
from ..client.inputs import PassInputs
from ..client.plan import Plan
from ..geometry import WarpMap
from ..gpu import flip_rows
from ..gpu.textures import Canvas, download, upload
from ..metrics import LEAST_STEP, RELATIVE_STEP, pixel_centres
from ..sources.server import Renderer


class Oracle:
    """The truth's own depth in place of a warp's guess.

    Each pixel is taken from the place in the late frame where its true surface lay, if that frame
    saw it: coverage is 1 there. The others, which no late picture holds, are those of the truth. A
    surface that moves by itself counts as unseen where it left its place. plan: what it is compared
    beside, for what frames must carry.
    """

    def __init__(self, server: Renderer, plan: Plan, shown_size: tuple[int, int]) -> None:
        self._server, self.plan, self._size = server, plan, shown_size
        self._warped, self._shown = ([Canvas(server.gpu.gl, shown_size) for _ in range(2)] for _ in range(2))
        self._made: dict[int, tuple[PassInputs, EyeResult]] = {}

    def run(self, inputs: PassInputs) -> EyeResult:
        """Make one eye's picture, once for each refresh; it takes no time of any client."""
        before = self._made.get(inputs.eye)
        if before is not None and before[0].shown is inputs.shown and before[0].shown_ns == inputs.shown_ns:
            return before[1]
        truth = self._server.draw(inputs.shown, self._size, time_ns=inputs.shown_ns)
        try:
            picture, true_depth = download(truth.colour)[..., :3], np.maximum(download(truth.inverse_depth), 0)
        finally:
            self._server.pool(self._size).release(truth.colour)
        rendered = inputs.rendered
        late, late_depth = download(rendered.colour)[..., :3], download(rendered.inverse_depth)
        mapping = WarpMap.between(truth.view, self._size, rendered.view, rendered.size)
        colour, seen = from_late(mapping, true_depth, late, late_depth)
        self._server.gpu.timer.collect()  # of drawing the truth
        warped, shown = self._warped[inputs.eye], self._shown[inputs.eye]
        upload(warped.texture, np.dstack([colour * seen[..., None], seen]))
        upload(shown.texture, np.dstack([np.where(seen[..., None], colour, picture), np.ones(seen.shape)]))
        result = EyeResult(inputs.middle, warped, shown, shown)
        self._made[inputs.eye] = inputs, result
        return result

    def renew(self) -> None:
        """Nothing to do: it remembers nothing."""

    def close(self) -> None:
        """Free the pictures."""
        for canvas in (*self._warped, *self._shown):
            canvas.release()


def from_late(
    mapping: WarpMap, true_depth: NDArray[np.floating], late: NDArray[np.floating], late_depth: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the colour (h, w, 3) of each pixel in a late picture, and where that saw its surface.

    mapping: from the shown to the late pixels. true_depth: (h, w), 1/m; late, late_depth: (H, W, 3)
    linear light and (H, W). All rows from the top. A surface was seen where the late frame has its
    inverse depth, within what is no jump of depth. Between pixels that is exact on planes.
    """
    height, width = true_depth.shape
    high, wide = late_depth.shape
    centres = pixel_centres(slice(0, height), width)
    with np.errstate(invalid="ignore"):
        place, expected, w = mapping.apply(centres, flip_rows(true_depth).astype(np.float64))
        place, expected = flip_rows(place), flip_rows(expected)
        x, y = place[..., 0] - 0.5, high - place[..., 1] - 0.5
        inside = (flip_rows(w) > 0) & (x >= 0) & (x <= wide - 1) & (y >= 0) & (y <= high - 1)
    x, y, expected = (np.where(inside, x, 0.0), np.where(inside, y, 0.0), np.where(inside, expected, 0.0))
    column, row = np.minimum(x.astype(int), wide - 2), np.minimum(y.astype(int), high - 2)
    right, below = x - column, y - row
    corners = [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)]
    shares = [(1 - below) * (1 - right), (1 - below) * right, below * (1 - right), below * right]
    both = np.dstack([late, late_depth]).astype(np.float64)
    found = np.sum([share[..., None] * both[corner] for share, corner in zip(shares, corners, strict=True)], axis=0)
    same = np.abs(found[..., 3] - expected) <= RELATIVE_STEP * expected + LEAST_STEP
    return found[..., :3], inside & same
