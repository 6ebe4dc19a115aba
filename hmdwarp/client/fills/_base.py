"""What every fill is and says of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar

from ...frames import Needs
from ..settings import NoSettings

if TYPE_CHECKING:
    from ...gpu.context import Gpu
    from ..geometry import ClientGeometry, ClientModel
    from ..inputs import PassInputs
    from ..picture import ShownPicture


class Fill(ABC):
    """Turns pixels of coverage 0 into a guess; never touches a covered one. Fills chain: each takes what those before it left empty.

    is_pass: False for the fill that does nothing, which the plan then leaves out. reads, writes: by the names of client/plan.py; one
    that writes shown.inverse_depth too gives its guesses a depth, for those after it. complete: leaves nothing empty, if anything is
    covered. Settings, variants: as a warp's. geometry: what the client can draw; wanted only by a fill that reads client.* .
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    reads: ClassVar[tuple[str, ...]] = ("shown.colour",)
    writes: ClassVar[tuple[str, ...]] = ("shown.colour",)
    source: ClassVar[str]
    is_pass: ClassVar[bool] = True
    complete: ClassVar[bool] = False
    Settings: ClassVar[type] = NoSettings
    variants: ClassVar[tuple[str, ...]] = ()

    def __init__(
        self,
        gpu: Gpu,
        rendered_size: tuple[int, int],
        shown_size: tuple[int, int],
        settings: Any = None,
        geometry: ClientGeometry | None = None,
    ) -> None:
        self.gpu, self.rendered_size, self.shown_size, self.geometry = gpu, rendered_size, shown_size, geometry
        self.settings = self.Settings() if settings is None else settings
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs and allocate the buffers; run() does neither."""

    @abstractmethod
    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        """Write the picture with its guesses into `into`; what stays unknown keeps coverage 0. Inverse depth is None on both or neither
        side; into's is written by a fill that writes shown.inverse_depth alone, for others it is that of `picture`.
        """

    def model(self, share: float, *, lit: bool) -> ClientModel:
        """Return the client's model of the scene, for fills that read client.model."""
        assert self.geometry is not None
        return self.geometry.model(share, lit=lit)

    def close(self) -> None:  # noqa: B027 (some own nothing)
        """Free the textures and buffers."""

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        """What frames must carry besides what every frame has."""
        return Needs()

    @classmethod
    def bytes_moved(cls, shown_pixels: int) -> int:
        """What one eye's picture must at least read and write in memory: one colour of 8 bytes each way."""
        return 16 * shown_pixels
