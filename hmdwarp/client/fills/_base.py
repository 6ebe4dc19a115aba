"""What every fill is and says of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from ...gpu.context import Gpu
    from ...gpu.textures import Canvas


class Fill(ABC):
    """Turns pixels of coverage 0 into a guess; never touches a covered one.

    is_pass: False for the fill that does nothing, which the plan then leaves out.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    reads: ClassVar[tuple[str, ...]] = ("shown.colour",)
    source: ClassVar[str]
    is_pass: ClassVar[bool] = True

    def __init__(self, gpu: Gpu, shown_size: tuple[int, int]) -> None:
        self.gpu, self.shown_size = gpu, shown_size
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs and allocate the buffers; run() does neither."""

    @abstractmethod
    def run(self, warped: Canvas, into: Canvas) -> None:
        """Write the picture with its guesses into `into`; what stays unknown keeps coverage 0."""

    @classmethod
    def bytes_moved(cls, shown_pixels: int) -> int:
        """What one eye's picture must at least read and write in memory: one colour of 8 bytes each way."""
        return 16 * shown_pixels
