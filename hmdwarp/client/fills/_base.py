"""The base class of fills, and the list of the pieces of a picture that have holes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from ...errors import InputError
from ...frames import Needs
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import tiles
from ...options import NoSettings
from ..client_scene import ClientScene, DrawnModel, ReducedModel
from ..inputs import PassInputs, ShownPicture


class Fill(ABC):
    """Give pixels of coverage 0 a plausible colour, and leave all others as they are.

    Fills chain: each fills what those before it left empty.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    reads: ClassVar[tuple[str, ...]] = ("shown.colour",)  # By the names of client/plan.py.
    # A fill that also writes shown.inverse_depth gives its pixels a depth, for fills after it.
    writes: ClassVar[tuple[str, ...]] = ("shown.colour",)
    # Whether it leaves out that depth where nothing after it reads it.
    drops_depth: ClassVar[bool] = False
    source: ClassVar[str]
    # False for the fill that does nothing, which the plan leaves out.
    is_pass: ClassVar[bool] = True
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

    def model(self, share: float, *, lit: bool, texture: float = 1.0) -> DrawnModel:
        """Return the client's model of the scene, for fills that read client.model."""
        assert self.geometry is not None
        return self.geometry.store(ReducedModel, (share, texture)).drawn(lit=lit)

    def learn(self, inputs: PassInputs) -> None:  # noqa: B027 (most remember nothing)
        """Remember what run() would of the picture as it was drawn, and show nothing."""

    def renew(self) -> None:  # noqa: B027 (most remember nothing)
        """Take the next frame for a new one, even if it is the last one again: for timing."""

    def close(self) -> None:  # noqa: B027 (some own nothing)
        """Free the textures and buffers."""

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
_WARPED, _FILLED, _WARPED_DEPTH, _FILLED_DEPTH = range(4)  # image units


class HolePieces:
    """The list of pieces with holes of the newest picture; owns its buffers.

    with_depth: copies the inverse depth too. coarse: also lists the pieces of the picture at half
    the resolution that see a hole.
    """

    def __init__(
        self, gpu: Gpu, name: str, size: tuple[int, int], *, with_depth: bool = False, coarse: bool = False
    ) -> None:
        self._gpu, self._size, self._stamp, self._with_depth = gpu, size, 0, with_depth
        self._program = gpu.shaders.compute(
            "fills/holes.comp", grid="shown", WITH_DEPTH=int(with_depth), COARSE=int(coarse)
        )
        self.count = _pieces_in(size)
        most = gpu.gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][0]
        if self.count * PIECE[0] > 64 * most:
            raise InputError(
                f"a shown picture of {size[0]}x{size[1]} is beyond what fill '{name}' can do on this GPU: use a "
                "smaller one"
            )
        self.list = gpu.gl.buffer(reserve=len(_HEADER) + 4 * self.count)
        self._stamps = gpu.gl.buffer(bytes(8 * self.count))
        at_half = _pieces_in(tiles(size, 2))
        self._coarse = gpu.gl.buffer(reserve=len(_HEADER) + 4 * at_half) if coarse else None
        self._coarse_stamps = gpu.gl.buffer(bytes(4 * at_half)) if coarse else None
        self._run_find = self._program.over(*size)

    def find(self, picture: ShownPicture, into: ShownPicture) -> int:
        """Copy the picture, and list its pieces with holes.

        Return the stamp that marks its pieces with covered pixels.
        """
        self._stamp = self._stamp % (2**32 - 1) + 1
        self.list.write(_HEADER)
        uniforms = {"warped": _WARPED, "filled": _FILLED, "shown_size": self._size, "stamp": self._stamp}
        picture.colour.texture.bind_to_image(_WARPED, read=True, write=False)
        into.colour.texture.bind_to_image(_FILLED, read=False, write=True)
        if self._with_depth and picture.inverse_depth is not None:
            picture.inverse_depth.bind_to_image(_WARPED_DEPTH, read=True, write=False)
            into.depth.bind_to_image(_FILLED_DEPTH, read=False, write=True)
            uniforms |= {"warped_depth": _WARPED_DEPTH, "filled_depth": _FILLED_DEPTH}
        self.list.bind_to_storage_buffer(0)
        self._stamps.bind_to_storage_buffer(1)
        if self._coarse is not None and self._coarse_stamps is not None:
            self._coarse.write(_HEADER)
            self._coarse.bind_to_storage_buffer(2)
            self._coarse_stamps.bind_to_storage_buffer(3)
        self._program.uniforms.set(**uniforms)
        self._run_find()
        self._gpu.barrier()
        return self._stamp

    def run(self, program: Compute) -> None:
        """Run a program that includes lib/hole_columns.glsl over the listed pieces."""
        self.list.bind_to_storage_buffer(0)
        self._stamps.bind_to_storage_buffer(1)
        program.program.run_indirect(self.list)
        self._gpu.barrier()

    def run_coarse(self, program: Compute) -> None:
        """Run it over the pieces at half the resolution; its shown_size is that resolution."""
        assert self._coarse is not None
        self._coarse.bind_to_storage_buffer(0)
        program.program.run_indirect(self._coarse)
        self._gpu.barrier()

    def close(self) -> None:
        """Free the buffers."""
        for buffer in (self.list, self._stamps, self._coarse, self._coarse_stamps):
            if buffer is not None:
                buffer.release()


def _pieces_in(size: tuple[int, int]) -> int:
    return -(-size[0] // PIECE[0]) * -(-size[1] // PIECE[1])
