"""What every warp is and says of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import attrs

from ...frames import Needs
from ..settings import NoSettings

if TYPE_CHECKING:
    from ...gpu.context import Gpu
    from ...gpu.shaders import Compute
    from ...gpu.textures import Canvas
    from ..inputs import PassInputs
    from ..lens import LensPass

# What one pixel weighs: rgba16f colour, r32f inverse depth, 32-bit key.
COLOUR_BYTES, DEPTH_BYTES, KEY_BYTES = 8, 4, 4


@attrs.frozen(eq=False)
class Output:
    """What a warp writes. lens: the lens it looks through itself (one resample from the late picture to the panel), None for the
    shown view before the lens. scanout: whether rows are shown one after the other, from Given.shown to Given.shown_last.
    """

    lens: LensPass | None = None
    scanout: bool = False


class Warp(ABC):
    """Turns one eye's late picture into the shown view, coverage 0 where nothing is known.

    kind: "gather" (each shown pixel asks where it was drawn) or "scatter" (drawn pixels move). reads: what it needs, by the
    names of client/plan.py. Settings: an attrs class of what may be set, each with a default (`mesh:cut=slope`). variants: settings
    that trade accuracy for time, and so are benchmarked beside the defaults. fuses, scans_out: whether it can write the panel in
    one resample, and row by row. carries: whether it takes other pictures than late.colour along, see client/carry.py.
    The object owns its programs and buffers for one pair of sizes; it serves both eyes in turn.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    kind: ClassVar[Literal["gather", "scatter"]]
    reads: ClassVar[tuple[str, ...]]
    exact_when: ClassVar[str]
    gets_wrong: ClassVar[str]
    source: ClassVar[str]
    Settings: ClassVar[type] = NoSettings
    variants: ClassVar[tuple[str, ...]] = ()
    fuses: ClassVar[bool] = False
    scans_out: ClassVar[bool] = False
    resamples: ClassVar[bool] = False
    carries: ClassVar[bool] = True

    def __init__(
        self,
        gpu: Gpu,
        rendered_size: tuple[int, int],
        shown_size: tuple[int, int],
        settings: Any = None,
        output: Output | None = None,
    ) -> None:
        self.gpu, self.rendered_size, self.shown_size = gpu, rendered_size, shown_size
        self.settings = self.Settings() if settings is None else settings
        self.output = Output() if output is None else output
        rendered_pixel = (1 / rendered_size[0], 1 / rendered_size[1])
        self._size_uniforms: dict[str, object] = {
            "rendered_size": tuple(rendered_size),
            "rendered_pixel": rendered_pixel,
            "shown_size": tuple(shown_size),
        }
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs and allocate the buffers; run() does neither."""

    @abstractmethod
    def run(self, inputs: PassInputs, into: Canvas) -> None:
        """Write the shown view's colour and coverage into `into` (rgba16f, shown_size)."""

    def close(self) -> None:  # noqa: B027 (most warps own no buffers)
        """Free the buffers, if there are any."""

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        """What frames must carry, and be kept, besides what every frame has."""
        return Needs()

    @classmethod
    def bytes_moved(cls, rendered_pixels: int, shown_pixels: int, settings: Any) -> int:
        """What one eye's picture must at least read and write in memory, each byte once: the bound the bench holds its time against.

        By default that of a gather: for each shown pixel one of colour and one of each depth it reads, and the result.
        """
        depths = sum(name.endswith("inverse_depth") for name in cls.reads)
        return shown_pixels * (2 * COLOUR_BYTES + DEPTH_BYTES * depths)

    def set_sizes(self, program: Compute) -> None:
        """The uniforms that stay the same as long as the sizes do."""
        program.uniforms.settle(self._size_uniforms)
