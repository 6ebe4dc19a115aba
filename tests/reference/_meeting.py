"""Where shown rays meet the surface that a picture with depth holds.

For the twins of the warps that gather from several pictures.

Points on a ray are found by projecting world points, guesses by sorting where drawn pixels land.
Where a decision hangs on less than rounding may change, the pixel is undecided.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from hmdwarp.geometry import View, WarpMap
from reference._rays import FLOAT32_UNIT, Array, pixel_error_bound, project, world_directions
from reference.picture import ReferencePicture, RenderedPicture, sample_covered

Mask = NDArray[np.bool_]
MOST_STEP = 0.5  # pixels
DEPTH_TOLERANCE, DEPTH_FLOOR = 0.03, 0.02
SAME, FARTHEST = (
    2.0**-16,
    2.0**-20,
)  # depths that differ by less, relative or in 1/m, are one: guesses often lead to the same point


@attrs.frozen(eq=False)
class Rays:
    """The rays of the shown pixels as lines in a rendered picture.

    The pixel of a point at rendered inverse depth r is start + r * along.

    ahead: whether the ray goes to where the rendered eye looks. error: pixels, of a place on the
    line.
    """

    shown: View
    shown_size: tuple[int, int]
    view: View
    size: tuple[int, int]
    start: Array
    along: Array
    ahead: Mask

    @classmethod
    def between(cls, shown: View, shown_size: tuple[int, int], view: View, size: tuple[int, int]) -> Rays:
        none = np.zeros(shown_size[::-1])
        rays, moved = world_directions(shown, shown_size), shown.pose.position_m - view.pose.position_m
        start, _, w = project(rays, moved, none, view, size)
        # A second point, so far away that it moves by a thousandth of the tangent: the line is
        # through both.
        far = none + 1e-3 / (np.linalg.norm(moved) + 1e-6) * np.maximum(w, 1e-6)
        point, depth, _ = project(rays, moved, far, view, size)
        return cls(shown, shown_size, view, size, start, (point - start) / depth[..., None], w > 0)

    def rendered_depth(self, shown_depth: Array) -> Array:
        """The inverse depth in the rendered view of points at an inverse depth in the shown one."""
        moved = self.shown.pose.position_m - self.view.pose.position_m
        return project(world_directions(self.shown, self.shown_size), moved, shown_depth, self.view, self.size)[1]

    def shown_depth(self, place: Array, depth: Array) -> tuple[Array, Mask]:
        """The way back.

        Points of the rendered view, brought into the world, seen from the shown eye; NaN behind it.
        And whether they lie so close to its plane that rounding may put them on either side.
        """
        left, right, down, up = self.view.fov.tangents
        x = left + place[..., 0] / self.size[0] * (right - left)
        y = down + place[..., 1] / self.size[1] * (up - down)
        rays = np.stack([x, y, -np.ones_like(x)], axis=-1) @ self.view.pose.rotation.as_matrix().T
        moved = self.view.pose.position_m - self.shown.pose.position_m
        _, seen, w = project(rays, moved, depth, self.shown, self.shown_size)
        return seen, np.abs(w) <= 64 * FLOAT32_UNIT * (1 + depth * np.linalg.norm(moved))

    def error(self, shown_depth: Array) -> Array:
        """(h, w): pixels by which the shader's place of a point may be off. It adds two more
        products and a quotient to the bound's."""
        bound = pixel_error_bound(
            WarpMap.between(self.shown, self.shown_size, self.view, self.size), self.shown_size, np.abs(shown_depth)
        )
        return 4 * bound + 8 * FLOAT32_UNIT * max(self.size)


@attrs.frozen(eq=False)
class Meetings:
    """depth: in the shown view, -1 where a ray meets nothing.

    look: where its colour is looked for. connected (h, w, 2). rendered_depth: of the point in the
    picture's own view. place_error: pixels.
    """

    depth: Array
    rendered_depth: Array
    place: Array
    look: Array
    connected: NDArray[np.bool_]
    place_error: Array
    undecided: Mask

    @property
    def met(self) -> Mask:
        return self.depth >= 0


def is_depth(inverse_depth: Array) -> Mask:
    return (inverse_depth >= 0) & (inverse_depth < 1e30)


def guesses(picture: RenderedPicture, shown: View, shown_size: tuple[int, int]) -> tuple[list[Array], Mask]:
    """Of what lands in each shown pixel and those around it the nearest, the nearest in the pixel
    itself, and the farthest: shown inverse depths, -1 for nothing. And where rounding may decide.
    """
    size = picture.inverse_depth.shape[1::-1]
    drawn = (picture.inverse_depth >= 0) & (picture.inverse_depth <= np.finfo(np.float32).max)
    own = np.where(drawn, picture.inverse_depth, 0)
    moved = picture.view.pose.position_m - shown.pose.position_m
    pixels, depth, w = project(world_directions(picture.view, size), moved, own, shown, shown_size)
    error = pixel_error_bound(WarpMap.between(picture.view, size, shown, shown_size), size, own)
    lands = drawn & (w > 0) & ((pixels >= 0) & (pixels < np.array(shown_size))).all(axis=-1)
    order = np.argsort(depth[lands], kind="stable")
    x, y = np.floor(pixels[lands][order]).astype(int).T
    landed = np.full(shown_size[::-1], -1.0)
    landed[y, x] = depth[lands][order]  # of several the last stays, which is the nearest
    nearest = ndimage.maximum_filter(landed, size=3, mode="nearest")
    farthest = ndimage.minimum_filter(np.where(landed < 0, np.inf, landed), size=3, mode="nearest")
    unsure = _may_land(pixels[drawn & (w > 0)], error[drawn & (w > 0)], shown_size)
    return [nearest, landed, np.where(np.isinf(farthest), -1, farthest)], ndimage.maximum_filter(unsure, size=3)


def _may_land(pixels: Array, error: Array, shown_size: tuple[int, int]) -> Mask:
    """Pixels beside a border on which something lands within its error."""
    marked = np.zeros(shown_size[::-1], bool)
    error = np.minimum(error, 0.5)[:, None]
    close = (np.abs(pixels - np.round(pixels)) <= error).any(axis=1) & (np.abs(pixels) < 1e6).all(axis=1)
    for dx in (-1, 1):
        for dy in (-1, 1):
            x, y = np.floor(pixels[close] + error[close] * (dx, dy)).astype(int).T
            inside = (x >= 0) & (y >= 0) & (x < shown_size[0]) & (y < shown_size[1])
            marked[y[inside], x[inside]] = True
    return marked


def meet(picture: RenderedPicture, rays: Rays, guess: Array) -> Meetings:
    """One step from a guess (shown inverse depth) to the plane of the texel that the ray is over at
    that depth."""
    guess_known = guess >= 0
    r = rays.rendered_depth(np.where(guess_known, guess, 0))
    with np.errstate(invalid="ignore", over="ignore"):
        p = rays.start + r[..., None] * rays.along
    error = rays.error(np.where(guess_known, guess, 0))
    usable = guess_known & rays.ahead & np.isfinite(p).all(axis=-1) & np.isfinite(r)
    p, r = np.where(usable[..., None], p, 0.5), np.where(usable, r, 0)
    at = np.clip(p, 0, rays.size)
    # Texels left and right of, below and above the nearest corner of four; the own one is on p's
    # side of it.
    corner = np.floor(at + 0.5).astype(int)
    upper = p >= corner
    own_texel, beside_texel = corner + np.where(upper, 0, -1), corner + np.where(upper, -1, 0)
    own = _held(picture, own_texel)
    beside = np.stack(
        [
            _held(picture, np.stack([beside_texel[..., 0], own_texel[..., 1]], axis=-1)),
            _held(picture, np.stack([own_texel[..., 0], beside_texel[..., 1]], axis=-1)),
        ],
        axis=-1,
    )
    connected, close_call = _connected(own[..., None], beside)
    centre, towards = own_texel + 0.5, np.where(upper, -1, 1)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        slope = np.where(connected, (beside - own[..., None]) * towards, 0)
        step = own + (slope * (p - centre)).sum(axis=-1) - r
        steepness = (slope * rays.along).sum(axis=-1)
        r_met = np.maximum(r + step / np.maximum(1 - steepness, 0.25), 0)
        moved = np.abs(r_met - r) * np.linalg.norm(rays.along, axis=-1)
        place = rays.start + r_met[..., None] * rays.along
        reach = np.linalg.norm(rays.along, axis=-1)
        depth_error = 4 * (np.abs(slope).sum(axis=-1) * error + 8 * FLOAT32_UNIT * (np.abs(own) + np.abs(r)))
        place_error = np.nan_to_num(error + reach * depth_error, nan=np.inf)
        inside = ((place >= 0) & (place < np.array(rays.size))).all(axis=-1)
        shown_depth, on_the_plane = rays.shown_depth(
            np.where(np.isfinite(place), place, 0), np.where(np.isfinite(r_met), r_met, 0)
        )
        met = usable & is_depth(own) & (moved <= MOST_STEP) & inside & np.isfinite(shown_depth)
        # Borders between texels decide which is met; their middles, to which side it slants, which
        # matters if the step leads away.
        from_border, from_middle = (np.abs(q - np.round(q)).min(axis=-1) for q in (p, p - 0.5))
        unsure = usable & (
            (from_border <= error)
            | ((from_middle <= error) & (moved > 2 * place_error))
            | close_call.any(axis=-1)
            | on_the_plane
            | (np.abs(moved - MOST_STEP) <= 2 * place_error)
            | (_from_border(place, rays.size) <= place_error)
        )
    look = np.where(connected, place, centre)
    return Meetings(
        np.where(met, shown_depth, -1), np.where(met, r_met, -1), place, look, connected, place_error, unsure
    )


def _held(picture: RenderedPicture, texel: NDArray[np.int64]) -> Array:
    high, wide = picture.inverse_depth.shape
    return picture.inverse_depth[np.clip(texel[..., 1], 0, high - 1), np.clip(texel[..., 0], 0, wide - 1)]


def _connected(own: Array, beside: Array) -> tuple[Mask, Mask]:
    """Whether two texels are of one surface; whether that is a close call."""
    limit = DEPTH_TOLERANCE * (np.minimum(own, beside) + DEPTH_FLOOR)
    apart = np.abs(own - beside)
    known = is_depth(own) & is_depth(beside)
    close = known & (np.abs(apart - limit) <= 8 * FLOAT32_UNIT * (np.abs(own) + np.abs(beside)))
    return known & (apart <= limit), close


def _from_border(place: Array, size: tuple[int, int]) -> Array:
    distance = np.minimum(np.abs(place), np.abs(place - np.array(size))).min(axis=-1)
    return np.nan_to_num(distance, nan=np.inf)


def is_nearer(depth: Array, other: Array) -> tuple[Mask, Mask]:
    """Whether `depth` is nearer than `other` (-1: nothing) by more than rounding, and whether that
    is a close call."""
    beyond = depth * (1 - SAME) - other - FARTHEST
    close = np.abs(beyond) <= SAME / 4 * np.maximum(depth, other) + FARTHEST / 4
    return np.where(other < 0, depth >= 0, beyond > 0), close & (depth >= 0) & (other >= 0)


def first_of(candidates: list[Meetings]) -> Meetings:
    """For each ray the first that meets something. Undecided where any before it is, or itself."""
    best = candidates[0]
    for other in candidates[1:]:
        undecided = best.undecided | (~best.met & other.undecided)
        pairs = zip(_values(best), _values(other), strict=True)
        best = Meetings(*(np.where(best.met[(..., *[None] * (a.ndim - 2))], a, b) for a, b in pairs), undecided)
    return best


def _values(meetings: Meetings) -> list[Array]:
    return [getattr(meetings, field.name) for field in attrs.fields(Meetings) if field.name != "undecided"]


@attrs.frozen(eq=False)
class Found:
    """What the shown rays meet in one picture, from which nearest guess, and the colours there."""

    rays: Rays
    nearest_guess: Array
    meetings: Meetings
    looked: ReferencePicture


def met_by(picture: RenderedPicture, shown: View, shown_size: tuple[int, int], sampler_pixels: float) -> Found:
    rays = Rays.between(shown, shown_size, picture.view, picture.inverse_depth.shape[1::-1])
    tried, unsure = guesses(picture, shown, shown_size)
    found = first_of([meet(picture, rays, guess) for guess in tried])
    found = attrs.evolve(found, undecided=found.undecided | unsure)
    looked = sample_covered(
        picture.colour, np.where(found.met[..., None], found.look, np.nan), found.place_error, sampler_pixels
    )
    return Found(rays, tried[0], found, attrs.evolve(looked, undecided=looked.undecided & found.met))
