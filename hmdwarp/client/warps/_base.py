"""What every warp is and says of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Literal

if TYPE_CHECKING:
    import moderngl

    from ...frame import EyeImage
    from ...geometry import View
    from ...gpu.context import Gpu
    from ...gpu.shaders import Compute
    from ...gpu.textures import Canvas


class Warp(ABC):
    """Turns one eye's late picture into the shown view, coverage 0 where nothing is known.

    kind: "gather" (each shown pixel asks where it was drawn) or "scatter" (drawn pixels move). reads: what it needs, by the
    names of client/plan.py. The object owns its programs and buffers for one pair of sizes; it serves both eyes in turn.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    kind: ClassVar[Literal["gather", "scatter"]]
    reads: ClassVar[tuple[str, ...]]
    exact_when: ClassVar[str]
    gets_wrong: ClassVar[str]
    source: ClassVar[str]

    def __init__(self, gpu: Gpu, late_size: tuple[int, int], shown_size: tuple[int, int]) -> None:
        self.gpu, self.late_size, self.shown_size = gpu, late_size, shown_size
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs and allocate the buffers; run() does neither."""

    @abstractmethod
    def run(self, late: EyeImage, shown: View, into: Canvas, client_inverse_depth: moderngl.Texture | None = None) -> None:
        """Write the shown view's colour and coverage into `into` (rgba16f, shown_size).

        client_inverse_depth: r32f of shown_size, only for warps that read it: the client's own depth in the shown view, -1
        where it has none.
        """

    def close(self) -> None:  # noqa: B027 (most warps own no buffers)
        """Free the buffers, if there are any."""

    def set_sizes(self, program: Compute) -> None:
        """The uniforms that stay the same as long as the sizes do."""
        known = {
            "late_size": self.late_size,
            "late_pixel": (1 / self.late_size[0], 1 / self.late_size[1]),
            "shown_size": self.shown_size,
        }
        program.uniforms.set(**{name: value for name, value in known.items() if program.uniforms.declares(name)})
