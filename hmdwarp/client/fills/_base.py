"""The base class of fills."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from ...frames import Needs
from ...gpu.context import Gpu
from ...options import NoSettings
from ..client_scene import ClientScene
from ..drawn_scenes import DrawnModel, ReducedModel
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
