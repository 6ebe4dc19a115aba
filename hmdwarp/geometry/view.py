"""Fields of view and views: one eye at one instant."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from typing import Any, Protocol

import attrs
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike, NDArray

from ..base import NO_NUMBERS, InputError, in_brief
from .pose import Pose, floats, frozen, real

Size = tuple[int, int]
Array = NDArray[np.float64]


@attrs.frozen
class GuardBand:
    """Two factors of the field of view in tangents, or the pixels of the picture that is drawn.

    Pixels per tangent stay those of the shown picture: factors of 1.25 and 1.125 make 1600x900 of
    1280x800. Errors: InputError for a factor below 1.
    """

    x: float = 1.0
    y: float = 1.0
    size: Size | None = None  # (w, h) of the rendered picture; decides instead of the factors.

    def __attrs_post_init__(self) -> None:
        if not all(factor >= 1 and math.isfinite(factor) for factor in (self.x, self.y)):
            raise InputError(f"{self} is no enlargement: expected factors of 1 or more")

    @classmethod
    def of(cls, value: float | tuple[float, float] | GuardBand) -> GuardBand:
        """Return the guard band of one factor or of two."""
        if isinstance(value, GuardBand):
            return value
        return cls(*value) if isinstance(value, tuple) else cls(value, value)

    @property
    def text(self) -> str:
        """Return the factors: '1.5', or '1.25x1.125' where they differ."""
        return f"{self.x:g}" if self.x == self.y else f"{self.x:g}x{self.y:g}"

    @property
    def entry(self) -> float | str:
        """Return what summary.json has: a number, or the text of two."""
        return self.x if self.x == self.y else self.text

    def __str__(self) -> str:
        return f"guard {self.text}" if self.size is None else f"rendered size {self.size[0]}x{self.size[1]}"

    def factors(self, shown: Size) -> GuardBand:
        """Return the guard band in factors, for a shown picture of that size. Errors: as check."""
        self.check(shown)
        return self if self.size is None else GuardBand(self.size[0] / shown[0], self.size[1] / shown[1])

    def check(self, shown: Size) -> None:
        """Raise InputError if a rendered size does not hold the shown picture."""
        if self.size is not None and (self.size[0] < shown[0] or self.size[1] < shown[1]):
            wanted = "expected at least that on each side, or a smaller --size"
            raise InputError(f"{self} is smaller than the shown picture's {shown[0]}x{shown[1]}: {wanted}")


Guard = float | tuple[float, float] | GuardBand
_MAX_ANGLE = math.radians(89.5)  # tan = 114.6: beyond this a plane at z = -1 is no longer a picture


@attrs.frozen
class Fov:
    """A field of view: four half angles, as in XrFovf; may be asymmetric.

    Parameters
    ----------
    left, right, down, up : float
        Radians; left and down are negative for a view that looks ahead.

    Raises
    ------
    InputError
        Unless left < right, down < up and each within +-89.5 degrees.
    """

    left: float = attrs.field(converter=real)
    right: float = attrs.field(converter=real)
    down: float = attrs.field(converter=real)
    up: float = attrs.field(converter=real)

    def __attrs_post_init__(self) -> None:
        angles = (self.left, self.right, self.down, self.up)
        if not all(abs(a) <= _MAX_ANGLE for a in angles) or self.left >= self.right or self.down >= self.up:
            found = "left, right, down, up = " + ", ".join(f"{a:.6g}" for a in angles)
            raise InputError(f"no field of view: {found} rad; needs left < right, down < up, within +-1.562")

    @classmethod
    def symmetric(cls, horizontal_rad: float, vertical_rad: float) -> Fov:
        """Return the field of view of two full angles in radians."""
        x, y = real(horizontal_rad) / 2, real(vertical_rad) / 2
        return cls(-x, x, -y, y)

    @classmethod
    def from_tangents(cls, tangents: ArrayLike) -> Fov:
        """Return the field of view of the tangents left, right, down, up. Errors: InputError."""
        return cls(*np.arctan(frozen(tangents, 4)))

    @classmethod
    def from_intrinsics(
        cls, fx: float, fy: float, cx: float, cy: float, width: int, height: int, *, centre: float = 0.0
    ) -> Fov:
        """Return the field of view of a camera without lens distortion.

        fx, fy: focal lengths in pixels; cx, cy: principal point, x to the right and y down. centre:
        the coordinate of the first pixel's middle: 0 as OpenCV, ROS and TUM have it; 0.5 where
        (0, 0) is the picture's corner, as for COLMAP, nerfstudio and OpenGL.
        Errors: InputError for focal lengths or sizes that are not above 0, and for a field of view
        that ends beyond +-89.5 degrees.
        Source: Hartley and Zisserman 2004, Multiple View Geometry, section 6.1.
        """
        numbers = [*map(real, (fx, fy, cx, cy, width, height, centre))]
        fx, fy, cx, cy, wide, high, centre = numbers
        if not all(math.isfinite(number) for number in numbers) or min(fx, fy, wide, high) <= 0:
            shown = f"fx {fx:g}, fy {fy:g}, cx {cx:g}, cy {cy:g}, {wide:g}x{high:g} pixels"
            raise InputError(f"no camera: {shown}: expected finite numbers, with fx, fy and the size above 0")
        left, up = cx + 0.5 - centre, cy + 0.5 - centre  # pixels from the picture's corner
        return cls.from_tangents((-left / fx, (wide - left) / fx, -(high - up) / fy, up / fy))

    @classmethod
    def from_projection(cls, matrix: ArrayLike) -> Fov:
        """Return the field of view of a projection matrix, as OpenGL, WebXR, Unity, OpenVR have it.

        matrix: (4, 4) or 16 numbers, by rows or columns, looking along -z or z, y up or down.
        Errors: InputError for one that is no perspective along z.
        """
        found = np.asarray(matrix, np.float64)
        found = found.reshape(4, 4) if found.size == 16 else np.zeros((4, 4))
        whole = [one for one in (found, found.T) if np.allclose(np.abs(one[3]), (0, 0, 1, 0)) and not one[2, :2].any()]
        scaled = whole and np.isfinite(found).all() and whole[0][[0, 1], [0, 1]].all()
        if not scaled or found[0, 1] or found[1, 0]:
            raise InputError(f"projection is {in_brief(matrix)}: expected a perspective along z, (4, 4) or 16 numbers")
        scales = ((whole[0][k, k], whole[0][k, 2] / whole[0][3, 2]) for k in (0, 1))
        (left, right), (down, up) = (sorted(((-1 - off) / scale, (1 - off) / scale)) for scale, off in scales)
        return cls.from_tangents((left, right, down, up))

    def intrinsics(self, size: Size, *, centre: float = 0.0) -> tuple[float, float, float, float]:
        """Return (fx, fy, cx, cy) in pixels of a (w, h) picture: the inverse of from_intrinsics."""
        left, right, down, up = self.tangents.tolist()
        fx, fy = size[0] / (right - left), size[1] / (up - down)
        return fx, fy, -left * fx - 0.5 + centre, up * fy - 0.5 + centre

    @cached_property
    def matrices(self) -> dict[Size | str, tuple[Array, Array]]:
        """What others make of it once: few, and used at every frame; of pictures by their size."""
        return {}

    @cached_property
    def tangents(self) -> Array:
        """(4,) left, right, down, up on the plane z = -1; read-only."""
        tangents = np.tan([self.left, self.right, self.down, self.up])
        tangents.flags.writeable = False
        return tangents

    def pixel_from_tangent(self, size: Size) -> Array:
        """Return the 3x3 matrix from tangent (x, y, 1) to pixel (px, py, 1): 0 is bottom left."""
        left, right, down, up = self.tangents
        width, height = frozen(size, 2).tolist()
        sx, sy = width / (right - left), height / (up - down)
        return np.array([[sx, 0, -left * sx], [0, sy, -down * sy], [0, 0, 1.0]])

    def pixels_per_degree(self, size: Size) -> float:
        """Return the mean of both axes at tangent 0, or at the nearest tangent inside."""
        left, right, down, up = self.tangents
        x, y = np.clip(0, left, right), np.clip(0, down, up)
        per_rad = [size[0] / (right - left) * (1 + x * x), size[1] / (up - down) * (1 + y * y)]
        return float(np.mean(per_rad) * math.pi / 180)

    def guarded(self, guard: Guard, size: Size, least: Size = (0, 0)) -> tuple[Fov, Size]:
        """Return a field of view enlarged by the guard band, and its size in pixels.

        Pixels per tangent stay the same. Whole pixels are added on each side (factors round up), so
        the pixel centres of the unguarded view are pixel centres of the guarded one, and an unmoved
        head loses nothing. least: pad to this size, on the right and at the top.
        Errors: as GuardBand; InputError if the view leaves 89.5 degrees.
        """
        left, right, down, up = self.tangents.tolist()
        per_x, per_y = size[0] / (right - left), size[1] / (up - down)
        band, pad = GuardBand.of(guard), list[int]()
        band.check(size)
        for axis, per, factor, (low, high) in ((0, per_x, band.x, (left, right)), (1, per_y, band.y, (down, up))):
            if band.size is not None:
                added = band.size[axis] - size[axis]
                first = round(added * abs(low) / (abs(low) + abs(high)))
                pad += [first, added - first]
            else:  # 1e-9: a guard of exactly whole pixels must not gain one by rounding
                pad += [math.ceil(abs(side) * per * (factor - 1) - 1e-9) for side in (low, high)]
        pad[1] += max(0, least[0] - size[0] - pad[0] - pad[1])
        pad[3] += max(0, least[1] - size[1] - pad[2] - pad[3])
        if not any(pad):
            return self, size
        grown = (left - pad[0] / per_x, right + pad[1] / per_x, down - pad[2] / per_y, up + pad[3] / per_y)
        return Fov.from_tangents(grown), (size[0] + pad[0] + pad[1], size[1] + pad[2] + pad[3])


Polygon = tuple[tuple[float, float], ...]


def is_a(kind: type, *, optional: bool = False) -> Callable[[object, attrs.Attribute[Any], object], None]:
    """Return a validator that raises InputError for what is of another type."""

    def check(_: object, field: attrs.Attribute[Any], value: object) -> None:
        if not (isinstance(value, kind) or (optional and value is None)):
            wanted = f"a hmdwarp.{kind.__name__}{', or None' * optional}"
            raise InputError(f"{field.name} is {in_brief(value)}: expected {wanted}")

    return check


def _check_polygons(_: object, __: object, polygons: Sequence[Polygon]) -> None:
    try:
        [frozen(point, 2) for polygon in polygons for point in polygon]
    except (InputError, *NO_NUMBERS) as error:
        wanted = "a list of polygons, each of points (x, y) in tangents"
        raise InputError(f"polygons {in_brief(polygons)}: expected {wanted}") from error


@attrs.frozen
class Hidden:
    """The part of an eye's view that its lens hides.

    A pixel is seen if it lies between the first and the last seen one of its column. Triangles of a
    mesh leave cracks of a pixel between them, which are closed.

    Parameters
    ----------
    polygons : tuple of polygons
        Each of three or more points (x, y), in tangents.
    fov : Fov
        The view without a guard band.
    margins : tuple of float
        By how many tangents what is drawn goes beyond what is seen: left, right, down, up.
    """

    polygons: tuple[Polygon, ...] = attrs.field(validator=_check_polygons)
    fov: Fov = attrs.field(validator=is_a(Fov))
    margins: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    _known: dict[tuple[Fov, Size], NDArray[np.int32]] = attrs.field(factory=dict, init=False, repr=False, eq=False)
    _grown: dict[tuple[float, ...], Hidden] = attrs.field(factory=dict, init=False, repr=False, eq=False)

    @classmethod
    def of_rows(cls, rows: Array, fov: Fov) -> Hidden:
        """Return what is hidden where a view's columns, from the left, see a part of their height.

        rows: (n, 2) first and last seen place, 0 (below) to 1; equal where a column sees nothing.
        """
        left, right, down, up = fov.tangents.tolist()
        x = np.repeat(np.linspace(left, right, len(rows) + 1), 2)[1:-1].tolist()
        first, end = (np.repeat(down + side * (up - down), 2).tolist() for side in rows.T)
        below = (*zip(x, first, strict=True), (right, down), (left, down))
        return cls((below, (*zip(x, end, strict=True), (right, up), (left, up))), fov)

    def within(self, fov: Fov) -> Hidden:
        """Return it for a field of view with a guard band: a late frame needs as much beyond it."""
        margins = tuple(np.abs(fov.tangents - self.fov.tangents).tolist())
        if margins not in self._grown:
            self._grown[margins] = self if margins == self.margins else Hidden(self.polygons, self.fov, margins)
        return self._grown[margins]

    def rows(self, fov: Fov, size: Size) -> NDArray[np.int32]:
        """Return (w, 2), read-only: each column's first seen row, and the one after its last."""
        if (known := self._known.get((fov, size))) is not None:
            return known
        seen = self._inside(fov, size)
        any_seen = seen.any(axis=0)
        first = np.where(any_seen, seen.argmax(axis=0), size[1])
        last = np.where(any_seen, size[1] - seen[::-1].argmax(axis=0), 0)
        left, right, down, up = fov.tangents
        per = size[0] / (right - left), size[1] / (up - down)
        # 1e-9: margins of whole pixels must not gain one by rounding.
        pads = [math.ceil(margin * per[side // 2] - 1e-9) for side, margin in enumerate(self.margins)]
        if (reach := pads[0] + pads[1] + 1) > 1:  # columns that are needed if one of these is seen
            pad = pads[1], pads[0]
            first = sliding_window_view(np.pad(first, pad, constant_values=size[1]), reach).min(axis=1)
            last = sliding_window_view(np.pad(last, pad), reach).max(axis=1)
        found = np.stack([np.maximum(first - pads[2], 0), np.minimum(last + pads[3], size[1])], axis=1)
        made = self._known[fov, size] = np.where(found[:, :1] < found[:, 1:], found, 0).astype(np.int32)
        made.flags.writeable = False
        return made

    @np.errstate(over="ignore", invalid="ignore")  # an edge may be as flat as numbers are
    def _inside(self, fov: Fov, size: Size) -> NDArray[np.bool_]:
        to_pixel, seen = fov.pixel_from_tangent(size), np.ones(size[::-1], bool)
        columns, rows = (np.arange(count) + 0.5 for count in size)
        for points in self.polygons:
            xs, ys, _ = to_pixel @ np.column_stack([points, np.ones(len(points))]).T
            inside = np.zeros(size[::-1], bool)  # where an odd number of edges lies right of the pixel's centre
            for x0, y0, x1, y1 in zip(xs, ys, np.roll(xs, -1), np.roll(ys, -1), strict=True):
                crossed = (rows < y0) != (rows < y1)
                at = x0 + (rows[crossed] - y0) * ((x1 - x0) / ((y1 - y0) or 1.0))
                inside[crossed] ^= columns < at[:, None]
            seen &= ~inside
        if any(len(points) == 3 for points in self.polygons):
            from scipy.ndimage import binary_opening

            seen = binary_opening(np.pad(seen, 1, mode="edge"), np.ones((3, 3)))[1:-1, 1:-1]
        left, right, down, up = self.fov.tangents
        ends = to_pixel @ np.array([[left, right], [down, up], [1, 1]])
        across, above = ((at > low) & (at < high) for at, (low, high) in zip((columns, rows), ends, strict=False))
        return np.asarray(seen & across & above[:, None])

    def seen(self, fov: Fov, size: Size) -> NDArray[np.bool_]:
        """Return (h, w): which pixels can be seen, the bottom row first."""
        first, end = self.rows(fov, size).T
        row = np.arange(size[1])[:, None]
        return np.asarray((row >= first) & (row < end))


Gaze = tuple[float, float, float]


def _check_gaze(_: object, __: object, gaze: Gaze | None) -> None:
    frozen((0, 0, -1) if gaze is None else gaze, 3, "a gaze: a direction (x, y, z), or None")


@attrs.frozen
class View:
    """One eye at one instant.

    Parameters
    ----------
    pose : Pose
        world_from_eye.
    fov : Fov
        What the eye sees.
    head_from_eye : Pose
        Head-locked content is seen with this; the head's origin is half way between the eyes.
    hidden : Hidden or None
        What is neither drawn nor shown; None for nothing.
    gaze : tuple of float or None
        Unit direction in the head's axes in which the eye looks; None where it is not known.
    """

    pose: Pose = attrs.field(validator=is_a(Pose))
    fov: Fov = attrs.field(validator=is_a(Fov))
    head_from_eye: Pose = attrs.field(factory=Pose, validator=is_a(Pose))
    hidden: Hidden | None = attrs.field(default=None, validator=is_a(Hidden, optional=True))
    gaze: Gaze | None = attrs.field(default=None, validator=_check_gaze)

    def __hash__(self) -> int:
        return hash((*map(abs, self.pose.unit_quaternion), *self.pose.position_m.tolist()))  # every pass asks

    def at(self, pose: Pose) -> View:
        """Return the same eye at another pose, which is not checked."""
        return _like(self, pose=pose)

    def within(self, fov: Fov) -> View:
        """Return the view with a guard band, or without: its hidden area goes along."""
        return _like(self, fov=fov, hidden=self.hidden and self.hidden.within(fov))

    def seen(self, size: Size) -> NDArray[np.bool_]:
        """Return (h, w): which pixels can be seen, the top row first."""
        return np.ones(size[::-1], bool) if self.hidden is None else self.hidden.seen(self.fov, size)[::-1]

    def rays(self, size: Size) -> Array:
        """Return (h, w, 3) directions in the eye through the pixel centres, z = -1, from below."""
        left, right, down, up = self.fov.tangents
        x = left + (np.arange(size[0]) + 0.5) * (right - left) / size[0]
        y = down + (np.arange(size[1]) + 0.5) * (up - down) / size[1]
        xx, yy = np.meshgrid(x, y)
        return np.stack([xx, yy, -np.ones_like(xx)], axis=-1)


_set = object.__setattr__


def _like(view: View, **changed: object) -> View:
    """Return View(..) of what another view had, without a check: every refresh makes six."""
    made = View.__new__(View)
    for name in ("pose", "fov", "head_from_eye", "hidden", "gaze"):
        _set(made, name, changed.get(name, getattr(view, name)))
    return made


class Eyes(Protocol):
    """Where the eyes are in the head, and their fields of view; a runtime's may change."""

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return the view of each eye, the left one first."""


def guarded_eyes(views: Sequence[View], guard: Guard, size: Size) -> tuple[tuple[Fov, ...], tuple[int, int]]:
    """Return the fields of view of all eyes with a guard band, and the one size they share.

    The smaller one is padded on the right and at the top. Errors: as Fov.guarded.
    """
    return _guarded_fovs(tuple([view.fov for view in views]), GuardBand.of(guard), size)


@lru_cache(maxsize=64)  # every frame needs it for the same eyes
def _guarded_fovs(fovs: tuple[Fov, ...], guard: GuardBand, size: Size) -> tuple[tuple[Fov, ...], Size]:
    sizes = [fov.guarded(guard, size)[1] for fov in fovs]
    largest = (max(w for w, _ in sizes), max(h for _, h in sizes))
    return tuple(fov.guarded(guard, size, largest)[0] for fov in fovs), largest


@attrs.frozen
class WarpMap:
    """`p_to ~ H p_from + e * inverse_depth`, with p in homogeneous pixels.

    inverse_depth is in 1/m, measured in the from view. The third component of the result, w, is the
    ratio of the two depths along -z, so `inverse_depth_to = inverse_depth_from / w`; w <= 0 means
    the point lies beside or behind the `to` eye, outside any picture. Exact for inverse_depth 0
    (infinitely far), for a zero baseline (e = 0) and far from the world origin.

    Source: McMillan and Bishop 1995, Plenoptic Modeling, eq. 8-10 (the planar form of their warp).
    """

    H: Array = attrs.field(eq=attrs.cmp_using(np.array_equal))  # (3, 3); as e read-only from `between`
    e: Array = attrs.field(eq=attrs.cmp_using(np.array_equal))  # (3,)

    @classmethod
    def between(cls, frm: View, frm_size: Size, to: View, to_size: Size) -> WarpMap:
        """Return the map between two views, computed relative to the eyes in float64.

        Parameters
        ----------
        frm, to : View
            From whose pixels, and to whose.
        frm_size, to_size : tuple of int
            (w, h) of their pictures.
        """
        for view in (frm, to):
            if not isinstance(view, View):
                raise InputError(f"expected a hmdwarp.View, found {in_brief(view)}")
        frm_size, to_size = (tuple(frozen(size, 2).tolist()) for size in (frm_size, to_size))
        return view_map(frm, frm_size, to, to_size)

    def apply(self, pixels: ArrayLike, inverse_depth: ArrayLike) -> tuple[Array, Array, Array]:
        """Return pixels (..., 2), inverse depth (...) and w (...) in the other view.

        Where w <= 0 pixel and depth are NaN: the picture has no such point.
        """
        pixels, inverse_depth = floats(pixels), floats(inverse_depth)
        if pixels.shape[-1:] != (2,):
            raise InputError(f"pixels have shape {pixels.shape}: expected (.., 2)")
        homogeneous = pixels @ self.H[:, :2].T + self.H[:, 2] + inverse_depth[..., None] * self.e
        w = homogeneous[..., 2]
        safe = np.where(w > 0, w, np.nan)
        return homogeneous[..., :2] / safe[..., None], inverse_depth / safe, w

    def moves_whole_pixels(self) -> bool:
        """Return whether nothing moved, or only a guard band was cut off."""
        (a, b, x), (c, d, y), (f, g, h) = self.H.tolist()
        off = (a - 1, b, x - round(x), c, d - 1, y - round(y), f, g, h - 1, *self.e.tolist())
        return bool(max(map(abs, off)) <= 1e-9)  # px: what rounding leaves of equal poses, below any real motion


_MAPS: dict[tuple[int, int, Size, Size], tuple[View, View, WarpMap]] = {}  # the oldest first


def view_map(frm: View, frm_size: Size, to: View, to_size: Size) -> WarpMap:
    """Return WarpMap.between unchecked, made once for the same two objects: each pass asks."""
    key = id(frm), id(to), frm_size, to_size
    if key in _MAPS:
        return _MAPS[key][2]
    # A copy, as BLAS adds up in another order where a matrix is transposed.
    to_from_world = to.pose.rotation_matrix.T.copy()
    position_m = to_from_world @ (frm.pose.position_m - to.pose.position_m)
    k_to = (to.fov.matrices.get(to_size) or _camera(to.fov, to_size))[0]
    k_frm_inverse = (frm.fov.matrices.get(frm_size) or _camera(frm.fov, frm_size))[1]
    made, turned = WarpMap.__new__(WarpMap), k_to @ (to_from_world @ frm.pose.rotation_matrix) @ k_frm_inverse
    for name, values in (("H", turned), ("e", k_to @ position_m)):
        values.flags.writeable = False
        _set(made, name, values)
    if len(_MAPS) >= 32:  # a refresh of both eyes makes 18
        del _MAPS[next(iter(_MAPS))]
    _MAPS[key] = frm, to, made
    return made


def _camera(fov: Fov, size: Size) -> tuple[Array, Array]:
    """Return (3x3 from eye points (x, y, -1) to pixels, its inverse), and keep it."""
    pixel_from_eye = fov.pixel_from_tangent(size) @ np.diag([1.0, 1.0, -1.0])
    fov.matrices[size] = pixel_from_eye, np.asarray(np.linalg.inv(pixel_from_eye), np.float64)
    return fov.matrices[size]


MOST_MIRRORS = 8  # as in shaders/lib/mirrors.glsl


@attrs.frozen(eq=False)
class Mirror:
    """One mirror in the world, in metres.

    A plane mirror is the rectangle centre +- right +- up; its front faces right x up. A curved one
    (radius_m > 0) is the ball around centre; right and up are then 0.
    """

    centre_m: Array = attrs.field(converter=frozen)
    right_m: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen)
    up_m: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen)
    radius_m: float = 0.0
    reflectivity: float = 1.0  # at normal incidence, 0 to 1; more at grazing angles (Schlick 1994)

    @property
    def is_curved(self) -> bool:
        """Whether it is a ball."""
        return self.radius_m > 0

    @property
    def normal(self) -> Array:
        """Unit normal of the front of a plane mirror."""
        across = np.cross(self.right_m, self.up_m)
        return across / np.linalg.norm(across)


def mirrors_in_eye(mirrors: Sequence[Mirror], view: View) -> dict[str, object]:
    """Return the mirrors in the axes of an eye, as the uniforms of shaders/lib/mirrors.glsl."""
    if len(mirrors) > MOST_MIRRORS:
        raise ValueError(f"{len(mirrors)} mirrors: expected at most {MOST_MIRRORS}")
    eye_from_world = view.pose.rotation_matrix.T
    rows = np.zeros((3, MOST_MIRRORS, 4))
    reflectivity = np.zeros(MOST_MIRRORS)
    for i, mirror in enumerate(mirrors):
        rows[0, i] = *(eye_from_world @ (mirror.centre_m - view.pose.position_m)), mirror.radius_m
        for row, half in ((1, mirror.right_m), (2, mirror.up_m)):
            length = float(np.linalg.norm(half))
            rows[row, i] = *(eye_from_world @ half / max(length, 1e-30)), length
        reflectivity[i] = mirror.reflectivity
    named = dict(zip(("mirror_centre", "mirror_right", "mirror_up"), rows, strict=True))
    return {"mirror_count": len(mirrors), "mirror_reflectivity": reflectivity, **named}


def tangents_of_pixels(view: View, size: Size) -> dict[str, tuple[float, float]]:
    """Return uniforms of pixel rays: that of pixel p is (tangent_start + p * tangent_step, -1)."""
    left, right, down, up = view.fov.tangents
    return {"tangent_start": (left, down), "tangent_step": ((right - left) / size[0], (up - down) / size[1])}
