"""The declaration of an effect, and the base classes of passes that compensate effects."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable
from typing import Any, ClassVar

import attrs

from ...base import InputError, Registry, unknown_name
from ...frames import EyeImage, Needs
from ...frames.layers import readable
from ...gpu import Gpu
from ...gpu.textures import COLOUR, SCALAR, Canvas, Owner, allocate, bind_images
from ...scenes import Mesh, Scene
from ..carry import Carry
from ..client_scene import ClientScene
from ..inputs import PassInputs, ShownPicture
from ..lens import LensPass
from ..settings import DescribedRegistry


@attrs.frozen
class Effect:
    """One kind of content that a plain warp gets wrong, and how it is compensated."""

    name: str
    order: int  # Place in lists; the passes of a plan run in this order too.
    summary: str
    applies: Callable[[Scene, Mesh], bool]  # Whether a mesh of the scene has the effect.
    made_by: type[EffectPass]  # The pass that compensates it; effects may share one.
    needs: Needs  # Layers that frames carry for it.
    without: str  # The artefact that the viewer sees without the pass.
    source: str
    refines: str = ""  # Name of the effect that this one builds on, "" for none.
    # Names of the effects that it stands in for: they are left out where it is used.
    instead_of: tuple[str, ...] = ()
    in_scene: Callable[[Scene], bool] = lambda _: False  # Whether the scene has it beside its meshes.
    fuses: bool = False  # Whether its pass can look through the lens too, after a warp that does.
    for_display: bool = False  # Whether a display that composes panels can do it.
    # Whether only `--effects` asks for it: a way to draw frames, or another way to compensate
    # content. Requested in a scene without a mesh that has the effect, it is left out.
    by_name_only: bool = False


@attrs.frozen(eq=False)
class Tools:
    """What the compensator lends to effect passes."""

    carry: Carry  # Warps further rendered pictures along with the colour.
    pictures: int  # Most pictures that `carry` passes on at a time.
    images: int = 1  # Most rendered images of one eye that a pass receives: the newest and `others`.
    # What the client draws by itself; None for plans that read none of it.
    geometry: ClientScene | None = None
    # The lens that the warp looks through; None where pictures are composited before it.
    lens: LensPass | None = None
    hands_panels_on: bool = False  # Whether the display composes panels that nothing hides.


class EffectPass(Owner, ABC):
    """One pass of the compensator, for one or more effects.

    It serves both eyes in turn, so it keeps nothing of one eye's picture.
    """

    name: ClassVar[str]  # Name in the plan's list.
    reads: ClassVar[tuple[str, ...]]  # Inputs and outputs, by the names of client/plan.py.
    writes: ClassVar[tuple[str, ...]]
    # Whether it warps pictures along with the colour, which some warps cannot.
    carries: ClassVar[bool] = False
    needs_compute: ClassVar[bool] = True  # As a warp's.
    of_light: ClassVar[bool] = False  # Whether pictures hold light alone until it has run.

    def __init__(
        self, gpu: Gpu, parts: frozenset[str], rendered_size: tuple[int, int], shown_size: tuple[int, int], tools: Tools
    ) -> None:
        self.gpu = gpu
        self.parts = parts  # names of the effects that it compensates in this plan, at least one
        self.rendered_size, self.shown_size = rendered_size, shown_size
        self.tools = tools
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs and allocate the textures; run() does neither."""

    @classmethod
    def reads_for(cls, parts: frozenset[str]) -> tuple[str, ...]:
        """Return those of `reads` that these effects need."""
        return cls.reads


class RenderedPass(EffectPass):
    """Changes the rendered pictures before the warp."""

    writes: ClassVar[tuple[str, ...]] = ("rendered.colour", "rendered.inverse_depth")

    @abstractmethod
    def run(self, inputs: PassInputs) -> PassInputs:
        """Return the inputs with other rendered pictures, held in the pass's own textures.

        The pictures of `inputs` stay as they are.
        """


class ShownPass(EffectPass):
    """Composites into the shown picture after the fills."""

    writes: ClassVar[tuple[str, ...]] = ("shown.colour",)
    # Whether it takes something out of the rendered pictures before all other passes.
    takes_out: ClassVar[bool] = False

    def take_out(self, inputs: PassInputs) -> PassInputs:
        """Return the inputs without what run() will draw; called before run() if takes_out."""
        return inputs

    @abstractmethod
    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        """Write the whole shown picture with the effect into `into`."""

    def run_through_lens(self, inputs: PassInputs, panel: Canvas) -> None:
        """Composite in the display's picture; called in place of run() where tools.lens is one."""
        raise NotImplementedError(f"{self.name} cannot look through the lens")


AUTO, NONE, FORBID = "auto", "none", "no-"


def _no_mesh(scene: Scene, mesh: Mesh) -> bool:
    return False


class EffectRegistry(DescribedRegistry[Effect]):
    """Effects by name, with an order in which lists show them."""

    def declare(
        self,
        name: str,
        made_by: type[EffectPass],
        needs: Needs = Needs(),  # noqa: B008 (frozen)
        applies: Callable[[Scene, Mesh], bool] = _no_mesh,
        in_scene: Callable[[Scene], bool] = lambda _: False,
    ) -> None:
        """Register one of this package's effects, of which _table.toml says the rest."""
        said: dict[str, Any] = self.table[name]
        said = {key: tuple(value) if isinstance(value, list) else value for key, value in said.items()}
        Registry.register(self, Effect(name, made_by=made_by, needs=needs, applies=applies, in_scene=in_scene, **said))

    def of(self, scene: Scene) -> tuple[str, ...]:
        """Return the names of the effects that a scene calls for."""
        return self.ordered(effect.name for effect in self if not effect.by_name_only and _occurs(effect, scene))

    def selected(self, text: str, declared: Collection[str], scene: Scene | None = None) -> tuple[str, ...]:
        """Return the names of the effects that a run compensates: `declared`, changed by `text`.

        text: "auto" changes nothing, "none" forbids all. Else names separated by commas, each
        forced, or forbidden by a leading "no-". Forcing an effect without content costs its pass
        and changes no picture; what only a name asks for is left out in a `scene` without content.
        Errors: UnknownNameError for a name; InputError for one that is both forced and forbidden.
        """
        forced, forbidden = self._told(text)
        idle = {name for name in forced if self.get(name).by_name_only and not _occurs(self.get(name), scene)}
        return self.ordered({*declared, *forced} - forbidden - idle)

    def forced(self, text: str) -> frozenset[str]:
        """Return the names that `text` forces. text, errors: as `selected`."""
        return frozenset(self._told(text)[0])

    def _told(self, text: str) -> tuple[set[str], set[str]]:
        """Return the names that are forced and those that are forbidden."""
        known = self.names()
        forced, forbidden = set[str](), set[str]()
        for word in filter(None, (part.strip() for part in text.split(","))):
            name = word.removeprefix(FORBID)
            if word == NONE:
                forbidden.update(known)
            elif name in known:
                (forced if name == word else forbidden).add(name)
            elif word != AUTO:
                raise unknown_name("effect", name, [*known, *(f"{FORBID}{effect}" for effect in known), AUTO, NONE])
        if both := self.ordered(forced & forbidden):
            raise InputError(f"--effects '{text}': {', '.join(both)} both forced and forbidden; choose one of the two")
        return forced, forbidden

    def ordered(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return the names in the order of their effects."""
        return tuple(sorted(names, key=lambda name: self.get(name).order))


def _occurs(effect: Effect, scene: Scene | None) -> bool:
    """Return whether some mesh has the effect; True where the scene is not known."""
    return scene is None or effect.in_scene(scene) or any(effect.applies(scene, mesh) for mesh in scene.meshes)


# By the layer: the picture that it stands for, and its kind of texture.
_PICTURES = {"foveated": ("colour", COLOUR), "foveated_depth": ("inverse_depth", SCALAR)}
EXPANDED = {layer: readable(picture) for layer, (picture, _) in _PICTURES.items()}


class ExpandPass(RenderedPass):
    """Expand each rendered picture that came foveated; parts: the layers that it comes in.

    Warps, fills and effects read the result as if it had come whole, so that each works as it is.
    """

    name = "expand"
    needs_compute = False
    reads = ("rendered.foveated", "rendered.foveated_depth")

    def prepare(self) -> None:
        self._programs, self._pictures = {}, {}
        for number, (layer, (_, kind)) in enumerate(_PICTURES.items()):
            if layer in self.parts:
                self._programs[layer] = self.gpu.shaders.compute("effects/expand.comp", DEPTH=number)
                textures = (allocate(self.gpu.gl, self.rendered_size, kind) for _ in range(self.tools.images))
                self._pictures[layer] = [self.own(texture) for texture in textures]

    def run(self, inputs: PassInputs) -> PassInputs:
        return inputs.having(self._expanded(image, number) for number, image in enumerate(inputs.images))

    def _expanded(self, image: EyeImage, number: int) -> EyeImage:
        """Return the image with its whole picture; the same object where it came whole."""
        found = {layer: image[layer] for layer in self._programs if layer in image}
        if not found:
            return image
        pictures: dict[str, Any] = {}
        for layer, picture in found.items():
            program, into = self._programs[layer], self._pictures[layer][number]
            units = bind_images({"foveated": picture.texture}, {"picture": into})
            program.uniforms.set(**units, **picture.grid.uniforms)
            program.run(*picture.grid.small)
            pictures[_PICTURES[layer][0]] = into
        self.gpu.barrier()
        came = {EXPANDED[layer] for layer in found}
        return attrs.evolve(image, **pictures, left_out=image.left_out - came)
