"""Composites of several pictures with depth, and of the layers of one.

The shown rays are intersected with one picture after the other; the best hit stays per pixel.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, Literal

import attrs
import moderngl
import numpy as np

from ...base import InputError, PlanError
from ...frames import EyeImage, Needs, Others
from ...geometry import View, WarpMap, view_map
from ...gpu import Gpu
from ...gpu.textures import Canvas, Owner, allocate, bind_images
from ..inputs import PassInputs, as_image
from ..settings import chosen, limited
from . import KEY_BYTES, warps
from ._base import Warp, pixel_of
from .forward import check_room
from .gather import USUAL_LIMITS, bind_rendered_colour

_PIECE_ROWS = 4
# Pixels of a piece (lib/hole_pieces.glsl) and invocations of a work group (lib/rows.glsl).
_PIECE, _GROUP = 8, 64
_HEADER_BYTES = 16  # of a list: three work-group counts and one count of pieces


class DepthGuesses(Owner):
    """The nearest inverse depth that lands in each cell of the shown picture."""

    def __init__(self, gpu: Gpu, cells: tuple[int, int]) -> None:
        self._gpu, self._cells = gpu, cells
        self._empty = gpu.shaders.compute("warps/layered_empty.comp")
        self._seed = gpu.shaders.compute("warps/layered_seed.comp")
        self._quads = -(-cells[0] * cells[1] // 4)
        self._keys = self.own(gpu.gl.buffer(reserve=4 * KEY_BYTES * self._quads))
        self._run_empty = self._empty.over(self._quads)
        self._run_seed: dict[tuple[int, int], Callable[[], object]] = {}  # by the size of what is moved

    def empty(self, pieces: moderngl.Buffer) -> None:
        """Clear all guesses and the list; both stay bound."""
        self._keys.bind_to_storage_buffer(0)
        pieces.bind_to_storage_buffer(1)
        self._empty.uniforms.set(quads=self._quads)
        self._gpu.barrier()
        self._run_empty()

    def scatter(self, inverse_depth: moderngl.Texture, view: View, shown: View, unit: int) -> None:
        """Move an inverse depth rendered for `view` to the shown view.

        It stays bound as image `unit`.
        """
        size = inverse_depth.size
        forward = view_map(view, size, shown, self._cells)
        units = bind_images({"rendered_inverse_depth": inverse_depth}, first=unit)
        self._keys.bind_to_storage_buffer(0)
        self._seed.uniforms.set(H=forward.H, e=forward.e, rendered_size=size, shown_size=self._cells, **units)
        if size not in self._run_seed:
            self._run_seed[size] = self._seed.over(*size)
        self._gpu.barrier()
        self._run_seed[size]()


def piece_list(gpu: Gpu, user: str, shown_size: tuple[int, int]) -> moderngl.Buffer:
    """Return an empty list with room for every piece of the shown picture.

    user: for the message. Errors: InputError where the indirect dispatch over all pieces would
    exceed the GL limit, and be dropped silently.
    """
    pieces = -(-shown_size[0] // _PIECE) * -(-shown_size[1] // _PIECE_ROWS)
    most = gpu.gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][0]
    if -(-pieces * _PIECE // _GROUP) > most:
        wide, high = shown_size
        found = f"a shown picture of {wide}x{high}: {user} would need more than this GPU's {most} work groups"
        raise InputError(f"{found}; use a smaller one")
    return gpu.gl.buffer(bytes(_HEADER_BYTES + 8 * pieces))


def no_pieces(gpu: Gpu) -> moderngl.Buffer:
    """Return a list of zero capacity, for guesses whose pieces are listed elsewhere."""
    return gpu.gl.buffer(bytes(_HEADER_BYTES))


_COLOUR = 1  # texture unit
_RESULT, _BEST, _DEPTH = 0, 1, 2  # image units; from 3 on they are the warp's own
_GUESSES = 3


class CompositeWarp(Warp):
    """A gather from several pictures with depth, each seeded by a scatter of its depth alone.

    The scatter leaves in each shown pixel the nearest depth that lands there. From these guesses
    the gather finds where the ray meets the picture's surface (lib/meeting.glsl).
    """

    kind = "scatter"
    best: ClassVar[tuple[int, str]] = (1, "f4")  # texture format of the best hit so far

    def prepare(self) -> None:
        check_room(self.gpu, self.name, self.shown_size, KEY_BYTES)
        self._guesses = self.own(DepthGuesses(self.gpu, self.shown_size))
        self._pieces = self.own(piece_list(self.gpu, f"warp '{self.name}'", self.shown_size))
        compute = partial(self.gpu.shaders.compute, f"warps/{self.name}.comp", ROWS=_PIECE_ROWS)
        self._choose, self._first = (compute(grid="shown", PASS=k) for k in (0, 1))
        self._more = compute(PASS=2)
        self._stamp = 0
        self._best = self.own(allocate(self.gpu.gl, self.shown_size, self.best))

    @abstractmethod
    def pictures(self, inputs: PassInputs) -> list[EyeImage]:
        """Return the pictures to combine, the preferred of equals first."""

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        """Return further uniforms of the warp's own shader, by name."""
        return {}

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        into.bind_for_writing(_RESULT)
        self._best.bind_to_image(_BEST, read=True, write=True)
        own = self.own_uniforms(inputs)
        for index, picture in enumerate(self.pictures(inputs)):
            self._guesses.empty(self._pieces)
            self._guesses.scatter(picture.inverse_depth, picture.view, inputs.shown, _DEPTH)
            self._gather(picture, inputs.middle, own, is_first=index == 0)

    def _gather(self, picture: EyeImage, shown: View, own: dict[str, object], *, is_first: bool) -> None:
        size = picture.size
        back = view_map(shown, self.shown_size, picture.view, size)
        bind_rendered_colour(picture, _COLOUR, whole_pixels=back.moves_whole_pixels())
        sizes = {"rendered_size": size, "rendered_pixel": pixel_of(size), "shown_size": self.shown_size}
        units = {"rendered_colour": _COLOUR, "rendered_depth": _DEPTH, "shown_colour": _RESULT, "best": _BEST}
        uniforms = {"H": back.H, "e": back.e, "guesses": _GUESSES, **units, **sizes, **USUAL_LIMITS, **own}
        self.gpu.barrier()
        if is_first:
            self._first.uniforms.set(**uniforms)
            self._first.run(*self.shown_size)
            return
        self._stamp = self._stamp % 0xFFFFFFFF + 1
        self._choose.uniforms.set(stamp=self._stamp, **uniforms)
        self._choose.run(*self.shown_size)
        self._more.uniforms.set(**uniforms)
        self.gpu.barrier()
        self._more.program.run_indirect(self._pieces)


MOST_LAYERS = 4


@attrs.frozen
class _LayeredSettings:
    layers: int = limited(3, 2, MOST_LAYERS, "depth layers, the visible one included")


@warps.register
class Layered(CompositeWarp):
    """Warp all layers together, the nearest surface wins: real content behind edges."""

    name = "layered"
    reads = ("rendered.colour", "rendered.inverse_depth", "rendered.peeled")
    Settings = _LayeredSettings

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        return Needs(peeled=settings.layers - 1)

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        inputs.rendered.inverse_depth.bind_to_image(3, read=True, write=False)
        return {"front_inverse_depth": 3}

    def pictures(self, inputs: PassInputs) -> list[EyeImage]:
        rendered, behind = inputs.rendered, self.settings.layers - 1
        peeled = rendered.get("peeled", ())
        if len(peeled) < behind:
            raise PlanError(
                f"warp 'layered' needs {behind} layers behind the visible one, this frame has {len(peeled)}"
            )
        return [rendered, *(as_image(rendered, surface) for surface in peeled[:behind])]


MOST_FRAMES, MOST_VIEWS = 8, 4
_CHOSEN = "rendered.views"


@attrs.frozen
class _MultiSettings:
    """The pictures to use besides the newest."""

    frames: int = limited(2, 0, MOST_FRAMES, "past frames")  # Of the same eye.
    spacing: float = limited(300.0, 0, 60_000, "milliseconds")  # The least between two of them.
    # Whether to use the other eye's picture too, or only the eye's own.
    eye: Literal["other", "own"] = chosen("other", "own")
    # That the server draws for this eye, from places that it may come to.
    views: int = limited(0, 0, MOST_VIEWS, "further pictures")


@warps.register
class Multi(CompositeWarp):
    """Combine the newest frame, the other eye's, further views and past ones, in this order."""

    name = "multi"
    reads = ("rendered.colour", "rendered.inverse_depth", "rendered.others", _CHOSEN)
    Settings = _MultiSettings
    best = (2, "f4")

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        spacing_ns = round(settings.spacing * 1e6) if settings.frames else 0
        return Needs(others=Others(settings.frames, spacing_ns, settings.eye == "other"), views=settings.views)

    @classmethod
    def reads_for(cls, settings: Any) -> tuple[str, ...]:
        return cls.reads if settings.views else tuple(name for name in cls.reads if name != _CHOSEN)

    def pictures(self, inputs: PassInputs) -> list[EyeImage]:
        """Return the newest picture and the others.

        The newest alone for an eye that has not moved and sees no more than before.
        """
        rendered, others = inputs.rendered, inputs.others
        back = self._newest(inputs)
        if back.moves_whole_pixels():
            low = np.round(back.H[:2, 2])
            if (low >= 0).all() and (low + self.shown_size <= rendered.size).all():
                others = ()
        return [rendered, *others]

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        inputs.rendered.inverse_depth.bind_to_image(3, read=True, write=False)
        newest = self._newest(inputs)
        maps = {"newest_H": newest.H, "newest_e": newest.e}
        return {"newest_inverse_depth": 3, "newest_size": inputs.rendered.size, **maps}

    def _newest(self, inputs: PassInputs) -> WarpMap:
        return view_map(inputs.shown, self.shown_size, inputs.rendered.view, inputs.rendered.size)
