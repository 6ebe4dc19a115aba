"""The base class of fills, and the list of the pieces of a picture that have holes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import moderngl
import numpy as np

from ...base import InputError, NoSettings
from ...frames import Needs
from ...gpu import Compute, Gpu
from ...gpu.textures import SCALAR, Canvas, Owner, allocate, bind_images, tiles
from ..client_scene import ClientScene, DrawnModel, ReducedModel
from ..inputs import PassInputs, ShownPicture


class Fill(Owner, ABC):
    """Give pixels of coverage 0 a plausible colour, and leave all others as they are.

    Fills chain: each fills what those before it left empty.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    reads: ClassVar[tuple[str, ...]] = ("shown.colour",)  # By the names of client/plan.py.
    # A fill that also writes shown.inverse_depth gives its pixels a depth, for fills after it.
    writes: ClassVar[tuple[str, ...]] = ("shown.colour",)
    drops_depth: ClassVar[bool] = False  # Whether it leaves out that depth where nothing after it reads it.
    source: ClassVar[str]
    is_pass: ClassVar[bool] = True  # False for the fill that does nothing, which the plan leaves out.
    complete: ClassVar[bool] = False  # Whether it leaves nothing empty, provided that anything is covered.
    remembers: ClassVar[bool] = False  # Whether it uses what it was given at earlier refreshes.
    needs_compute: ClassVar[bool] = True  # As a warp's.
    Settings: ClassVar[type] = NoSettings  # As a warp's.
    variants: ClassVar[tuple[str, ...]] = ()  # As a warp's.

    def __init__(
        self,
        gpu: Gpu,
        rendered_size: tuple[int, int],
        shown_size: tuple[int, int],
        settings: Any = None,
        geometry: ClientScene | None = None,
        *,
        depth_read: bool = True,
    ) -> None:
        """Make the fill for one pair of sizes.

        depth_read: whether anything after it reads the inverse depth of what it fills.
        """
        self.depth_read = depth_read or not self.drops_depth
        self.gpu, self.rendered_size, self.shown_size, self.geometry = gpu, rendered_size, shown_size, geometry
        self.settings = self.Settings() if settings is None else settings
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs and allocate the buffers; run() does neither."""

    @abstractmethod
    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        """Write the picture with its holes filled into `into`; unknown pixels keep coverage 0.

        Inverse depth is None on both sides or on neither; that of `into` also where the fill drops
        it. Only a fill that writes shown.inverse_depth writes that of `into`; for others it is that
        of `picture`.
        """

    def picture(self) -> ShownPicture:
        """Return a picture of the shown size with depth, for what the client draws."""
        gl = self.gpu.gl
        return ShownPicture(self.own(Canvas(gl, self.shown_size)), self.own(allocate(gl, self.shown_size, SCALAR)))

    def model(self, share: float, *, lit: bool, texture: float = 1.0) -> DrawnModel:
        """Return the client's model of the scene, for fills that read client.model."""
        assert self.geometry is not None
        drawn = self.geometry.store(ReducedModel, (share, texture)).drawn(lit=lit)
        drawn.reserve(self.shown_size)
        return drawn

    def learn(self, inputs: PassInputs) -> None:  # noqa: B027 (most remember nothing)
        """Remember what run() would of the picture as it was drawn, and show nothing."""

    def renew(self) -> None:  # noqa: B027 (most remember nothing)
        """Take the next frame for a new one, even if it is the last one again: for timing."""

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        """Return the layers that frames must carry besides colour and inverse depth."""
        return Needs()

    @classmethod
    def needs_compute_for(cls, settings: Any) -> bool:
        """Return whether it needs compute shaders with these settings."""
        return cls.needs_compute

    @classmethod
    def bytes_kept(cls, rendered_pixels: int, settings: Any) -> int:
        """Return the bytes of the pictures that it may keep."""
        return 0


PIECE = (8, 4)  # pixels, as in shaders/lib/holes.glsl
_HEADER = np.array([0, 1, 1, 0], np.uint32).tobytes()  # three work-group counts, one count of pieces


class HolePieces(Owner):
    """The list of pieces with holes of the newest picture; owns its buffers.

    with_depth: copies the inverse depth too. coarse: also lists the pieces of the picture at half
    the resolution that see a hole.
    """

    def __init__(
        self, gpu: Gpu, name: str, size: tuple[int, int], *, with_depth: bool = False, coarse: bool = False
    ) -> None:
        self._gpu, self._size, self._stamp, self._with_depth = gpu, size, 0, with_depth
        defines = {"WITH_DEPTH": int(with_depth), "COARSE": int(coarse)}
        self._program = gpu.shaders.compute("fills/holes.comp", grid="shown", **defines)
        count, at_half = (-(-w // PIECE[0]) * -(-h // PIECE[1]) for w, h in (size, tiles(size, 2)))
        if count * PIECE[0] > 64 * gpu.gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][0]:
            raise InputError(
                f"a shown picture of {size[0]}x{size[1]} is beyond what fill '{name}' can do on this GPU: use a "
                "smaller one"
            )
        room = [len(_HEADER) + 4 * count, 8 * count, *([len(_HEADER) + 4 * at_half, 4 * at_half] if coarse else [])]
        # The list and the stamps of pieces, then both of those at half the resolution.
        self._buffers = [self.own(gpu.gl.buffer(bytes(count))) for count in room]
        self._run_find = self._program.over(*size)

    def find(self, picture: ShownPicture, into: ShownPicture) -> int:
        """Copy the picture, and list its pieces with holes.

        Return the stamp that marks its pieces with covered pixels.
        """
        self._stamp = self._stamp % (2**32 - 1) + 1
        read, write = {"warped": picture.colour.texture}, {"filled": into.colour.texture}
        if self._with_depth and picture.inverse_depth is not None:
            read["warped_depth"], write["filled_depth"] = picture.inverse_depth, into.depth
        for binding, buffer in enumerate(self._buffers):
            if binding % 2 == 0:
                buffer.write(_HEADER)
            buffer.bind_to_storage_buffer(binding)
        self._program.uniforms.set(shown_size=self._size, stamp=self._stamp, **bind_images(read, write))
        self._run_find()
        self._gpu.barrier()
        return self._stamp

    def run(self, program: Compute) -> None:
        """Run a program that includes lib/hole_columns.glsl over the listed pieces."""
        self._run_over(program, *self._buffers[:2])

    def run_coarse(self, program: Compute) -> None:
        """Run it over the pieces at half the resolution; its shown_size is that resolution."""
        self._run_over(program, self._buffers[2])

    def _run_over(self, program: Compute, *buffers: moderngl.Buffer) -> None:
        for binding, buffer in enumerate(buffers):
            buffer.bind_to_storage_buffer(binding)
        program.program.run_indirect(buffers[0])
        self._gpu.barrier()
