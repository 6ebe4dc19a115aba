"""Where in the frame before a candidate convention finds each pixel, and what it finds there."""

from __future__ import annotations

import itertools
from functools import cached_property
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..geometry import View
from .motion_frames import DOWN, FORWARD, METRES, NDC, OUT, PIXELS, PROPERTIES, UV, Array, Convention, MotionFrame, Size

_ACROSS, _DOWN = 20, 15  # blocks of a picture
BLOCKS = _ACROSS * _DOWN
SCORED = 5000  # pixels of each frame by which candidates are told apart
_EDGE_PX, _EDGE = 3, 1.15  # pixels around, and ratio of distances: another surface is near
_MISSED = 0.02  # of the brightness, beside what 0.75 pixels make: something else was there
_FAR = 1e-3  # 1/m: what differs by less is equally far
_SURFACE = 0.06  # share of the depth: what differs by less may be one surface that came nearer by itself

CANDIDATES = tuple(Convention(*values) for values in itertools.product(*(values for values, _ in PROPERTIES.values())))


@attrs.frozen(eq=False)
class Pair:
    """A frame with vectors, and the one before, sampled at the centres of the vectors' pixels."""

    now: MotionFrame
    before: MotionFrame
    step: int = 1  # every so many pixels of the vectors, in both directions

    @cached_property
    def uv(self) -> Array:
        """(h, w, 2) places in the picture, 0 to 1, y down."""
        first, (high, wide) = self.step // 2, self.now.motion.shape[:2]
        return grid((wide, high))[first :: self.step, first :: self.step]

    @cached_property
    def block(self) -> NDArray[np.intp]:
        """(h, w) number of the block of the picture."""
        across, down = (self.uv * (_ACROSS, _DOWN)).astype(np.intp).transpose(2, 0, 1)
        return np.asarray(down * _ACROSS + across)

    @cached_property
    def one_surface(self) -> NDArray[np.bool_]:
        """(h, w) whether no other surface is near in the picture."""
        depth, wide = np.nan_to_num(self.inverse), 2 * _EDGE_PX + 1
        nearest, farthest = ndimage.maximum_filter(depth, wide), ndimage.minimum_filter(depth, wide)
        return np.asarray(nearest < farthest * _EDGE + 10 * _FAR)

    @cached_property
    def inverse(self) -> Array:
        """(h, w) 1/m of the frame's own depth there, NaN for none."""
        return nearest_at(self.now.inverse_depth, self.uv)

    @cached_property
    def vectors(self) -> Array:
        """(h, w, 2 or 3)."""
        return self.now.motion[self.step // 2 :: self.step, self.step // 2 :: self.step]

    @cached_property
    def still(self) -> Array:
        """(h, w, 3) places in the eye before of what is here, had it stood still, times 1/m."""
        turn = self.then_view.pose.inverse() @ self.now.view.pose
        along = along_of(self.now.view, self.uv - self.now.jitter / np.array(self.now.size))
        return along @ turn.rotation_matrix.T + turn.position_m * np.nan_to_num(self.inverse)[..., None]

    @cached_property
    def expected(self) -> Array:
        """(h, w) 1/m in the eye before, had it stood still; NaN for no depth."""
        return np.asarray(self.inverse / np.maximum(-self.still[..., 2], 1e-6))

    @cached_property
    def then_view(self) -> View:
        """The view of the frame before."""
        return self.now.view_before(self.before)

    @cached_property
    def bright_now(self) -> Array:
        """(h, w) of the frame itself."""
        return sampled(self.now.brightness, self.uv)

    def places(self, convention: Convention) -> Array:
        """Return (h, w, 2) where each pixel was in the picture before, 0 to 1, y down."""
        now, before = (np.array(frame.jitter) / frame.size for frame in (self.now, self.before))
        off = convention.jitter == OUT
        here = self.uv - now if off else self.uv
        way = self.vectors * (1 if convention.sign == FORWARD else -1)
        way = way * np.array((1, 1 if convention.y == DOWN else -1, 1))[: way.shape[2]]
        with np.errstate(all="ignore"):
            if convention.unit == METRES:
                place = along_of(self.now.view, here) / self.inverse[..., None]
                place[..., :2] -= way[..., :2] * (1, -1)
                depth = place[..., 2] - way[..., 2] if way.shape[2] > 2 else self.still[..., 2] / self.inverse
                then = uv_of(self.then_view, np.stack([place[..., 0], place[..., 1], depth], axis=-1))
            else:
                then = here - way[..., :2] * {NDC: 0.5, UV: 1.0, PIXELS: 1 / np.array(self.now.size)}[convention.unit]
        return then + before if off else then


def grid(size: Size) -> Array:
    """Return (h, w, 2) centres of a picture's pixels, 0 to 1, y down."""
    return np.stack(np.meshgrid(*((np.arange(count) + 0.5) / count for count in size)), axis=-1)


def along_of(view: View, uv: Array) -> Array:
    """Return (.., 3) directions in the eye through places of the picture, z = -1."""
    left, right, down, up = view.fov.tangents
    x, y = left + uv[..., 0] * (right - left), up - uv[..., 1] * (up - down)
    return np.stack([x, y, -np.ones_like(x)], axis=-1)


def uv_of(view: View, points: Array) -> Array:
    """Return (.., 2) places in the picture of points in the eye; NaN behind it."""
    left, right, down, up = view.fov.tangents
    away = np.where(points[..., 2] < 0, -points[..., 2], np.nan)
    x, y = points[..., 0] / away, points[..., 1] / away
    return np.stack([(x - left) / (right - left), (up - y) / (up - down)], axis=-1)


def sampled(picture: Array, uv: Array) -> Array:
    """Return a picture's values at places, bilinear; NaN outside."""
    high, wide = picture.shape
    where = np.stack([uv[..., 1] * high - 0.5, uv[..., 0] * wide - 0.5])
    found = ndimage.map_coordinates(picture, np.nan_to_num(where, nan=-9.0), order=1, mode="nearest")
    return np.where(inside(uv), found, np.nan)


def nearest_at(picture: NDArray[Any], uv: Array) -> NDArray[Any]:
    """Return a picture's values of the nearest pixels, those at the border outside."""
    high, wide = picture.shape[:2]
    column, row = (np.clip(np.nan_to_num(uv[..., k]) * n, 0, n - 1).astype(np.intp) for k, n in enumerate((wide, high)))
    return np.asarray(picture[row, column])


def inside(uv: Array) -> NDArray[np.bool_]:
    """Return which places lie in the picture."""
    with np.errstate(invalid="ignore"):
        return np.asarray(((uv > 0) & (uv < 1)).all(axis=-1))


@attrs.frozen(eq=False)
class Found:
    """What a candidate finds in the frame before: differences of what should be the same."""

    pair: Pair
    uv: Array
    seen: NDArray[np.bool_]  # in the picture before, and nothing nearer was there
    elsewhere: NDArray[np.bool_]  # all that was there was farther: the surface was elsewhere
    bright: Array  # brightness now less before
    deep: Array  # inverse depth before less that expected, as a share of it

    @classmethod
    def of(cls, pair: Pair, convention: Convention) -> Found:
        """Return what a convention finds."""
        uv, expected = pair.places(convention), pair.expected
        nearest, within = nearest_at(pair.before.nearest_around, uv), inside(uv) & np.isfinite(expected)
        return cls(
            pair,
            uv,
            within & (nearest <= expected * (1 + _SURFACE) + _FAR),
            within & (nearest < expected * (1 - _SURFACE) - _FAR),
            pair.bright_now - sampled(pair.before.brightness, uv),
            (nearest_at(pair.before.inverse_depth, uv) - expected) / (expected + 1e-2),
        )

    @cached_property
    def missed(self) -> NDArray[np.bool_]:
        """Where something of another colour was."""
        steep = np.linalg.norm(self.gradient, axis=-1)
        return np.asarray(self.seen & (np.abs(np.nan_to_num(self.bright)) > _MISSED + 0.75 * steep))

    @cached_property
    def gradient(self) -> Array:
        """(h, w, 2) change of the brightness before, per pixel of colour to the right and down."""
        other = self.pair.before.brightness
        steps = np.diag(1 / np.array(self.pair.now.size))
        return np.stack(
            [np.nan_to_num(sampled(other, self.uv + s) - sampled(other, self.uv - s)) / 2 for s in steps], axis=-1
        )
