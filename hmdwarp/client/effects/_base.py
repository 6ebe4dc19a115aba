"""What every effect and every pass that compensates effects is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

import attrs

from ...frames import Needs
from ...scenes.effects import SceneEffect

if TYPE_CHECKING:
    from ...gpu.context import Gpu
    from ...gpu.textures import Canvas
    from ..carry import Carry
    from ..inputs import PassInputs
    from ..picture import ShownPicture


@attrs.frozen
class Effect:
    """How one SceneEffect is compensated. made_by: its pass; effects may share one. needs: what frames carry for it. without: what is seen
    where its pass is left out. refines: the name of an effect without which it means nothing, "" for none.
    """

    flag: SceneEffect
    summary: str
    made_by: type[EffectPass]
    needs: Needs
    without: str
    source: str
    refines: str = ""

    @property
    def name(self) -> str:
        """Of its flag, in small letters."""
        return self.flag.name.lower()


@attrs.frozen(eq=False)
class Tools:
    """What passes may use: `carry` takes other late pictures along with the colour; pictures: how many it hands over at most.

    images: how many late images of one eye a pass is given at most, the newest and `others`.
    """

    carry: Carry
    pictures: int
    images: int = 1


class EffectPass(ABC):
    """One pass of the compensator. parts: the names of the effects it does in this plan, one at least.

    name: as the plan tells it. order: among the passes of its kind. reads, writes: by the names of client/plan.py. carries: whether it
    takes pictures along with the colour, which not every warp can.
    The object owns its programs and textures for one pair of sizes; it serves both eyes in turn, so it keeps nothing of one eye's picture.
    """

    name: ClassVar[str]
    order: ClassVar[int]
    reads: ClassVar[tuple[str, ...]]
    writes: ClassVar[tuple[str, ...]]
    carries: ClassVar[bool] = False

    def __init__(
        self, gpu: Gpu, parts: frozenset[str], rendered_size: tuple[int, int], shown_size: tuple[int, int], tools: Tools
    ) -> None:
        self.gpu, self.parts, self.rendered_size, self.shown_size, self.tools = (
            gpu,
            parts,
            rendered_size,
            shown_size,
            tools,
        )
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs and allocate the textures; run() does neither."""

    @abstractmethod
    def close(self) -> None:
        """Free the textures and buffers."""

    @classmethod
    def reads_for(cls, parts: frozenset[str]) -> tuple[str, ...]:
        """Those of `reads` that it needs for these effects."""
        return cls.reads

    @classmethod
    def bytes_moved(cls, rendered_pixels: int, shown_pixels: int) -> int:
        """What one eye's picture must at least read and write in memory."""
        return 16 * shown_pixels


class LatePass(EffectPass):
    """Changes the late pictures before the warp."""

    writes: ClassVar[tuple[str, ...]] = ("rendered.colour", "rendered.inverse_depth")

    @abstractmethod
    def run(self, inputs: PassInputs) -> PassInputs:
        """The same with other late pictures, its own textures; what it was given stays as it is."""


class ShownPass(EffectPass):
    """Composites into the shown picture after the fills."""

    writes: ClassVar[tuple[str, ...]] = ("shown.colour",)

    @abstractmethod
    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        """Write the whole shown picture with the effect into `into`."""
