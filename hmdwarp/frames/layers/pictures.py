"""Layers that are pictures: of the same eye or instant, or marks of what the picture holds."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError
from ...geometry import Fov, Fovea, FoveaGrid, Mirror, Pose, RigidState, View, cube_size, grid_of, wide_size
from ..frame import EyeImage
from . import BRIGHT_VIDEO, DEPTH, OWN, PIXEL_BYTES, VECTORS, EyeSizes, Layer, Rows, Size, Surface, layers

if TYPE_CHECKING:
    import moderngl

Numbers = NDArray[Any] | None
MOST_VIEWS = 12  # as many places as the server looks at
_VIEW_NUMBERS, _BODY_NUMBERS, _MIRROR_NUMBERS = 18, 16, 11


def _rows(rows: Iterable[Sequence[float]], numbers: int) -> NDArray[np.float64]:
    return np.array([*rows], np.float64).reshape(-1, numbers)


def _turns(*quaternions: NDArray[Any]) -> bool:
    """Return whether all of them, (n, 4), are of length 1."""
    return all((np.abs(np.linalg.norm(each, axis=1) - 1) <= 1e-3).all() for each in quaternions)


@layers.register
class Cube(Layer):
    """Colour of the six faces of geometry.cube in one texture, of the larger eye's size."""

    name = "cube"
    summary = "colour of everything around the eye, six faces in one texture"
    formats = ("rgba16f",)
    size_class = OWN
    drawn_by = "cube"

    @classmethod
    def size(cls, sizes: EyeSizes) -> Size:
        return max(cube_size(fov, sizes.shown) for fov in sizes.fovs)


class _WithViews(Layer):
    formats = ("rgba16f", "r32f")

    @classmethod
    def numbers(cls, data: Any) -> NDArray[np.float64]:
        """Return a row for the view of each EyeImage: world_from_eye, head_from_eye, angles."""
        rows = [
            (*v.pose.position_m, *v.pose.orientation_xyzw, *v.head_from_eye.position_m,
             *v.head_from_eye.orientation_xyzw, v.fov.left, v.fov.right, v.fov.down, v.fov.up)
            for v in (image.view for image in data)
        ]  # fmt: skip
        return _rows(rows, _VIEW_NUMBERS)

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: Numbers) -> str:
        count = len(pictures) // 2
        if numbers is None or numbers.shape != (count, _VIEW_NUMBERS):
            return f"its views are missing: expected {count} rows of {_VIEW_NUMBERS} numbers"
        if not _turns(numbers[:, 3:7], numbers[:, 10:14]):
            return "a view's quaternion is not of length 1"
        try:
            [*map(_view_of, numbers)]
        except InputError as error:
            return str(error)
        return ""

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: Numbers, amount: Any, drawn_ns: int) -> Any:
        assert numbers is not None, "misfit() says so"
        pairs = zip(numbers, sent[::2], sent[1::2], strict=True)
        return tuple(EyeImage(_view_of(row), colour, depth, drawn_ns=drawn_ns) for row, colour, depth in pairs)


def _view_of(row: NDArray[np.float64]) -> View:
    return View(Pose(row[:3], row[3:7]), Fov(*row[14:18].tolist()), Pose(row[7:10], row[10:14]))


@layers.register
class Views(_WithViews):
    """A tuple of EyeImage, the most useful first; the amount is their number."""

    name = "views"
    summary = "whole pictures of the same instant from places that the eye may come to"
    drawn_by = "views"
    something = 2

    @classmethod
    def amount_of(cls, stated: int | Rows) -> int:
        found = int(super().amount_of(stated))
        if found > MOST_VIEWS:
            raise ValueError(f"{found} views: expected {MOST_VIEWS} at most")
        return found


@layers.register
class Wide(_WithViews):
    """An EyeImage of its own, with the view that geometry.wide gives, of the larger eye's size."""

    name = "wide"
    summary = "a second picture of the same eye, wide and coarse"
    size_class = OWN
    drawn_by = "wide"

    @classmethod
    def size(cls, sizes: EyeSizes) -> Size:
        widths, heights = zip(*(wide_size(fov, sizes.shown) for fov in sizes.fovs), strict=True)
        return max(widths), max(heights)

    @classmethod
    def sent(cls, data: EyeImage) -> Iterable[moderngl.Texture]:
        """Return the picture alone: what head-locked content was drawn into is not read."""
        return data.colour, data.inverse_depth

    @classmethod
    def numbers(cls, data: Any) -> NDArray[np.float64]:
        return super().numbers((data,))

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: Numbers, amount: Any, drawn_ns: int) -> Any:
        return super().made(sent, numbers, amount, drawn_ns)[0]


@layers.register
class Peeled(Layer):
    """A tuple of Surface, nearest first; the amount is their number."""

    name = "peeled"
    summary = "the surfaces behind the visible one, nearest first"
    formats = ("rgba16f", "r32f")
    drawn_by = "peeled"
    something = 2

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: Numbers, amount: Any, drawn_ns: int) -> tuple[Surface, ...]:
        return tuple(Surface(*pair) for pair in zip(sent[::2], sent[1::2], strict=True))


@attrs.frozen(eq=False)
class Transparent:
    """Glass and the like, as one veil before the picture."""

    # Its own light, premultiplied, with its inverse depth; coverage 1 wherever something
    # transparent is.
    veil: Surface
    # rgba16f, the share of the light behind that passes, by colour, 1 where nothing is; coverage as
    # the veil's.
    passing: moderngl.Texture

    def textures(self) -> Iterable[moderngl.Texture]:
        """Return all of them, in the order of the layer's formats."""
        return (*self.veil.textures(), self.passing)


@layers.register
class Transparency(Layer):
    """A Transparent."""

    name = "transparent"
    summary = "glass and the like as a veil with a depth of its own"
    formats = ("rgba16f", "r32f", "rgba16f")
    drawn_by = "transparency"
    apart = True

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: Numbers, amount: Any, drawn_ns: int) -> Transparent:
        colour, inverse_depth, passing = sent
        return Transparent(Surface(colour, inverse_depth), passing)


class Mirrored(enum.Flag):
    """The kinds of mirrors whose reflections are a layer; the picture has the others."""

    PLANE = enum.auto()
    CURVED = enum.auto()


@attrs.frozen(eq=False)
class Reflection:
    """What mirrors show."""

    # The mirrored world. Its inverse depth is that of the virtual image behind the mirror: 1 / the
    # depth of the whole reflected path. Drawn wherever a mirror is and a little around it, also
    # behind what stands before it; holes elsewhere.
    seen: Surface
    # rgba16f, of what the picture itself shows: reflectivity straight on (r; 0 where nothing
    # mirrors), the disturbed normal's x and y along the mirror's right and up (g, b), and coverage.
    surface: moderngl.Texture
    mirrors: tuple[Mirror, ...] = ()  # all mirrors that `seen` and `surface` describe, in the world
    # The pixels outside which nothing mirrors: x, y of the first, x, y after the last, from the
    # bottom left; None for the whole picture. Only they are sent; a codec spends nothing on the
    # others, which are all the same.
    bounds: tuple[int, int, int, int] | None = None

    def textures(self) -> Iterable[moderngl.Texture]:
        """Return all of them, in the order of the layer's formats."""
        return (*self.seen.textures(), self.surface)


@layers.register
class Reflections(Layer):
    """A Reflection; the amount is a Mirrored."""

    name = "reflection"
    summary = "what mirrors show, with the depth of the mirrored world"
    formats = ("rgba16f", "r32f", "rgba16f")
    # What is seen is shown by a share of its light, so light beyond 1 matters.
    codings = (BRIGHT_VIDEO, DEPTH, VECTORS)
    drawn_by = "reflections"
    apart = True
    something = Mirrored.PLANE | Mirrored.CURVED

    @classmethod
    def sent_bytes(cls, data: Reflection) -> int:
        """Return the bytes of what is within the bounds."""
        if data.bounds is None:
            return super().sent_bytes(data)
        low_x, low_y, high_x, high_y = data.bounds
        return sum(PIXEL_BYTES[kind] for kind in cls.formats) * (high_x - low_x) * (high_y - low_y)

    @classmethod
    def numbers(cls, data: Reflection) -> NDArray[np.float64]:
        """Return a row for each mirror: centre, right, up, radius, reflectivity."""
        rows = ((*one.centre_m, *one.right_m, *one.up_m, one.radius_m, one.reflectivity) for one in data.mirrors)
        return _rows(rows, _MIRROR_NUMBERS)

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: Numbers) -> str:
        if numbers is None or numbers.shape[1] != _MIRROR_NUMBERS:
            return f"its mirrors are missing: expected rows of {_MIRROR_NUMBERS} numbers"
        radius, reflectivity = numbers[:, 9], numbers[:, 10]
        areas = np.linalg.norm(np.cross(numbers[:, 3:6], numbers[:, 6:9]), axis=1)
        is_there = (radius > 0) | ((radius == 0) & (areas > 0))
        if not (is_there & (reflectivity >= 0) & (reflectivity <= 1)).all():
            return "a mirror without an area, or that reflects less than nothing or more than all"
        return ""

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: Numbers, amount: Any, drawn_ns: int) -> Reflection:
        assert numbers is not None, "misfit() says so"
        colour, inverse_depth, surface = sent
        mirrors = tuple(Mirror(row[:3], row[3:6], row[6:9], *map(float, row[9:])) for row in numbers)
        return Reflection(Surface(colour, inverse_depth), surface, mirrors)


@attrs.frozen(eq=False)
class BodyIds:
    """The bodies of a picture."""

    # r16ui of the picture's size: 0 for what stands still, else 1 + index into `bodies`.
    numbers: moderngl.Texture
    bodies: tuple[RigidState, ...] = ()  # how each body moved when the picture was drawn

    def textures(self) -> Iterable[moderngl.Texture]:
        """Return the one."""
        return (self.numbers,)


@layers.register
class Ids(Layer):
    """A BodyIds."""

    name = "ids"
    summary = "the rigid body each pixel belongs to, and how the bodies move"
    formats = ("r16ui",)
    drawn_by = "motion"

    @classmethod
    def numbers(cls, data: BodyIds) -> NDArray[np.float64]:
        """Return a row for each body: pose, velocity, angular velocity, acceleration."""
        rows = (
            (
                *(*body.pose.position_m, *body.pose.orientation_xyzw, *body.velocity_m_s),
                *(*body.angular_velocity_rad_s, *body.acceleration_m_s2),
            )
            for body in data.bodies
        )
        return _rows(rows, _BODY_NUMBERS)

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: Numbers) -> str:
        if numbers is None or numbers.shape[1] != _BODY_NUMBERS:
            return f"its bodies are missing: expected rows of {_BODY_NUMBERS} numbers"
        highest = int(pictures[0].max())
        if highest > len(numbers):
            return f"a pixel of body {highest}, and there are {len(numbers)} bodies"
        return "" if _turns(numbers[:, 3:7]) else "a body's quaternion is not of length 1"

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: Numbers, amount: Any, drawn_ns: int) -> BodyIds:
        assert numbers is not None, "misfit() says so"
        bodies = [RigidState(Pose(row[:3], row[3:7]), row[7:10], row[10:13], row[13:]) for row in numbers]
        return BodyIds(sent[0], tuple(bodies))


# What comes in place of colour and of inverse depth.
FOVEATED = ("foveated", "foveated_depth")


@attrs.frozen(eq=False)
class FoveatedPicture:
    """A picture on a coarser grid."""

    # Of the layer's format, and of the grid's small size.
    texture: moderngl.Texture
    grid: FoveaGrid

    def textures(self) -> Iterable[moderngl.Texture]:
        """Return the one."""
        return (self.texture,)


class _FoveatedLayer(Layer):
    """A FoveatedPicture. The amount is the Fovea."""

    size_class = OWN
    drawn_by = "foveated"
    something = Fovea()

    @classmethod
    def size(cls, sizes: EyeSizes) -> Size:
        return cls.something.small(sizes.fovs[0], sizes.shown, sizes.rendered)

    @classmethod
    def bytes(cls, amount: Fovea, sizes: EyeSizes) -> int:
        width, height = amount.small(sizes.fovs[0], sizes.shown, sizes.rendered)
        return PIXEL_BYTES[cls.formats[0]] * width * height

    @classmethod
    def numbers(cls, data: FoveatedPicture) -> NDArray[Any]:
        return data.grid.numbers()

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: Numbers) -> str:
        if numbers is None:
            return "its grid is missing"
        try:
            grid_of(numbers, pictures[0].shape[1::-1])
        except InputError as error:
            return str(error)
        return ""

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: Numbers, amount: Fovea, drawn_ns: int) -> FoveatedPicture:
        assert numbers is not None, "misfit() says so"
        return FoveatedPicture(sent[0], grid_of(numbers, sent[0].size))


@layers.register
class Foveated(_FoveatedLayer):
    """Its colour: the mean of the covered pixels that one of the rim holds."""

    name = "foveated"
    summary = "the rendered picture, coarser away from where the eye looks"
    formats = ("rgba16f",)


@layers.register
class FoveatedDepth(_FoveatedLayer):
    """In 1/m: of the pixels that one of the rim holds, the mean over their nearest surface."""

    name = "foveated_depth"
    summary = "inverse depth of the rendered picture, coarser away from where the eye looks"
    formats = ("r32f",)
