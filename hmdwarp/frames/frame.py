"""What was drawn, and the exact views it was drawn for: they travel together, always."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

import attrs

from ..geometry import Mirror, RigidState, View
from ..scenes.effects import SceneEffect

if TYPE_CHECKING:
    import moderngl

    from ..gpu.timers import Lap
    from ..poses import PoseSample


@attrs.frozen
class Needs:
    """What a plan wants of every frame besides colour and inverse depth, and of the frames before it.

    layers: surfaces behind the visible one, by peeling. cube: whether the surroundings of each eye are drawn too. past: how many
    older frames the client keeps, at least past_spacing_ns apart. other_eye: whether the other eye's picture is used as well.
    ids: which body each pixel belongs to, and how the bodies move. velocity: how what deforms moves. reflections, curved_reflections,
    transparency, overlay: these as layers of their own; what is not asked for is drawn into the picture. wide: a second, wide view.
    """

    layers: int = 0
    cube: bool = False
    past: int = 0
    past_spacing_ns: int = 0
    other_eye: bool = False
    ids: bool = False
    velocity: bool = False
    reflections: bool = False
    curved_reflections: bool = False
    transparency: bool = False
    overlay: bool = False
    wide: bool = False

    def __or__(self, other: Needs) -> Needs:
        """Enough for both."""
        both = {field.name: max(getattr(self, field.name), getattr(other, field.name)) for field in attrs.fields(Needs)}
        spacings = [needs.past_spacing_ns for needs in (self, other) if needs.past]
        return Needs(**(both | {"past_spacing_ns": min(spacings, default=0)}))


@attrs.frozen(eq=False)
class Layer:
    """Another surface of the same view and size: `colour` rgba16f and `inverse_depth` r32f; holes as in EyeImage."""

    colour: moderngl.Texture
    inverse_depth: moderngl.Texture


@attrs.frozen(eq=False)
class Reflection:
    """What mirrors show, apart from the mirrors themselves.

    seen: the mirrored world; inverse_depth is that of the virtual image behind the mirror, so 1 / the depth of the whole reflected
    path. Drawn wherever a mirror is and a little around it, also behind what stands before it; holes elsewhere. surface: rgba16f, of what
    the picture itself shows: reflectivity straight on (r; 0 where nothing mirrors) and the disturbed normal's x and y along the mirror's
    right and up (g, b), coverage. mirrors: all that seen and surface tell of, in the world.
    """

    seen: Layer
    surface: moderngl.Texture
    mirrors: tuple[Mirror, ...] = ()


@attrs.frozen(eq=False)
class Transparent:
    """What one sees through. veil: its own light, premultiplied, with its inverse depth; coverage 1 wherever something see-through is.
    passing: rgba16f, the share of the light behind that passes, by colour, 1 where nothing is; coverage as the veil's."""

    veil: Layer
    passing: moderngl.Texture


@attrs.frozen(eq=False)
class EyeImage:
    """One eye's picture: `colour` rgba16f linear with coverage in alpha, `inverse_depth` r32f in 1/m, and its view.

    Rows run bottom to top, as GL has them. Where nothing was drawn colour is (0, 0, 0, 0) and inverse_depth is
    -1 (no depth), so that a hole is neither averaged into its neighbours nor scattered. Where it was asked for (see Needs): layers: what
    lies behind, nearest first; cube: colour of everything around the eye, rgba16f, the six faces of geometry.cube in one texture; ids:
    r16ui, 0 for what stands still, else 1 + index into `bodies`; velocity: rgba16f, in m/s along the eye's axes (rgb) of what deforms
    (coverage); overlay: rgba16f, premultiplied, what is fixed to the head, for the shown field of view and size; wide: a second picture
    of the same eye and instant. drawn_ns: when it was drawn.
    """

    view: View
    colour: moderngl.Texture
    inverse_depth: moderngl.Texture
    layers: tuple[Layer, ...] = ()
    cube: moderngl.Texture | None = None
    ids: moderngl.Texture | None = None
    bodies: tuple[RigidState, ...] = ()
    velocity: moderngl.Texture | None = None
    reflection: Reflection | None = None
    transparent: Transparent | None = None
    overlay: moderngl.Texture | None = None
    wide: EyeImage | None = None
    drawn_ns: int = 0

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) in pixels."""
        return self.colour.size

    def textures(self) -> Iterator[moderngl.Texture]:
        """Every texture it carries, those of its layers and of the wide view included."""
        return _textures(self)


def _textures(part: Any) -> Iterator[moderngl.Texture]:
    """Those of an EyeImage, or of any part of one: a new kind of layer needs no entry here."""
    if isinstance(part, tuple):
        for one in part:
            yield from _textures(one)
    elif names := _parts_of(type(part)):
        for name in names:
            one = getattr(part, name)
            if one is not None and one != ():
                yield from _textures(one)
    elif part is not None and not isinstance(part, int):
        yield part


@cache
def _parts_of(kind: type) -> tuple[str, ...]:
    """The fields that may hold textures; none for what is no part."""
    return (
        tuple(one.name for one in attrs.fields(kind) if one.name not in ("view", "bodies", "mirrors"))
        if attrs.has(kind)
        else ()
    )


@attrs.frozen(eq=False)
class Frame:
    """Both eyes as the server drew them at `drawn_ns`; `effects` is what the scene called for.

    head: world_from_head the frame was asked for, and how that was obtained; None where only the views are known. drawing: what the GPU
    did for it, to be asked for its time when that is done. took_ms: what else was measured on its way, by name (encode, decode); whoever
    does the work enters it.
    """

    eyes: tuple[EyeImage, ...]
    drawn_ns: int
    effects: SceneEffect = SceneEffect.NONE
    head: PoseSample | None = None
    drawing: Lap | None = None
    took_ms: dict[str, float] = attrs.field(factory=dict)
