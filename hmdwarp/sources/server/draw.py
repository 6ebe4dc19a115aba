"""Draw a scene for the eyes: linear colour, and inverse depth exact to the last float32 bits."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any

import attrs
import moderngl

from ...base import InputError, unknown_name
from ...frames import EyeImage, Frame, Needs
from ...frames.layers import PICTURE, layers
from ...geometry import Fov, Guard, View, guarded_eyes
from ...gpu import Gpu
from ...scenes import Scene
from .parts import DrawContext, Drawing, Part, parts
from .passes import Lighting, SceneBuffers, ScenePasses, SceneTextures, moving_parts
from .targets import Framebuffers, Multisampled, Renderer, Target

Size = tuple[int, int]
_MOST_CHOSEN = 256  # sets of parts, by what frames need
MIRRORS = _GEOMETRY, SCREEN = "geometry", "screen"


class Server(Renderer):
    """One scene on the GPU, uploaded once, drawn for any view and instant.

    Rows run bottom to top. Background pixels have coverage 1 and inverse depth 0: sky is drawn, not
    missing. Passes for content that the scene lacks and no frame needs are never compiled.

    mirrors: how frames show plane mirrors: "geometry" (the scene once more, mirrored) or "screen"
    (rays marched through the picture itself); draw(), the truth, always uses "geometry". lighting:
    of a scene with lamps, in place of its own; the caller's. samples: of each pixel of plain
    surfaces; colour is their mean in linear light, depth that of the pixel's centre; all else has
    one. changes: whether the scene's textures will. Errors: UnknownNameError for mirrors;
    MachineError for more samples than the GPU has.
    """

    def __init__(
        self,
        gpu: Gpu,
        scene: Scene,
        mirrors: str = _GEOMETRY,
        *,
        lighting: Lighting | None = None,
        samples: int = 1,
        changes: bool = False,
    ) -> None:
        self.samples = samples
        self._several = self.own(Multisampled(gpu, samples)) if samples > 1 else None
        self._framebuffers = self.own(Framebuffers(gpu.gl))
        super().__init__(gpu, scene, self._framebuffers.forget)
        if mirrors not in MIRRORS:
            raise unknown_name("kind of mirrors", mirrors, list(MIRRORS))
        self._marched = mirrors == SCREEN
        self.textures = self.own(SceneTextures(gpu, scene, lent=not changes))
        still = [mesh for mesh in scene.meshes if mesh.is_surface and mesh.stands_still]
        self._buffers = self.own(SceneBuffers(gpu, still, self.textures))
        self._moving = [self.own(one) for one in moving_parts(gpu, scene, self.textures)]
        colour = ScenePasses(gpu, scene, self._buffers, colour=True, moving=self._moving, lighting=lighting)
        self._colour, self._depth = self.own(colour), None  # type: ScenePasses, ScenePasses | None
        self._parts: dict[tuple[Hashable, str], Part] = {}  # by client and name; None for those that all share
        self._chosen: dict[tuple[Hashable, Needs], list[Part]] = {}
        resources = gpu, scene, self.textures, self._framebuffers, self._colour
        draws = self.acquire, self._draw, self._passes_for, self._draw_colour, self.of_another
        self._context = DrawContext(*resources, *draws)

    def of_another(self, scene: Scene, lighting: Lighting | None = None, *, changes: bool = False) -> Server:
        """Return a server of another scene that draws as this one does; who makes it closes it."""
        return Server(self.gpu, scene, lighting=lighting, samples=self.samples, changes=changes)

    def draw(self, view: View, size: Size, into: Target | None = None, time_ns: int = 0) -> EyeImage:
        return self._draw(view, size, Drawing(view, size, time_ns), into)

    def _draw(self, view: View, size: Size, drawing: Drawing, into: Target | None = None) -> EyeImage:
        target = into if into is not None else self.acquire(size)
        _check_same_size(target.colour.size, size)
        needed, colour, depth = self._parts_for(drawing), target.colour, target.inverse_depth
        passes = self._passes_of(needed, drawing)
        if self._several is None:
            passes.draw(view, self._framebuffers.over(colour, depth), drawing.time_ns)
        else:
            self._several.draw(passes, view, colour, drawing.time_ns)
            # Parts compare depth at the centres of pixels, and test against its buffer.
            self._depth_passes().draw(view, self._framebuffers.over(depth), drawing.time_ns)
        eye = EyeImage(view, colour, depth, drawn_ns=drawing.time_ns)
        for part in needed:
            eye = part.add(eye, drawing)
        return eye

    def _draw_colour(self, passes: ScenePasses, view: View, into: moderngl.Texture, time_ns: int) -> None:
        if self._several is None:
            passes.draw(view, self._framebuffers.over(into), time_ns)
        else:
            self._several.draw(passes, view, into, time_ns)

    def _depth_passes(self) -> ScenePasses:
        if self._depth is None:
            passes = ScenePasses(self.gpu, self.scene, self._buffers, colour=False, moving=self._moving)
            self._depth = self.own(passes)
        return self._depth

    def _passes_for(self, drawing: Drawing) -> ScenePasses:
        return self._passes_of(self._parts_for(drawing), drawing)

    def _passes_of(self, needed: Sequence[Part], drawing: Drawing) -> ScenePasses:
        for part in needed:
            if (passes := part.passes_for(drawing)) is not None:
                return passes
        return self._colour

    def _parts_for(self, drawing: Drawing) -> list[Part]:
        client, needs = drawing.client, drawing.needs
        chosen = self._chosen.get((client, needs))
        if chosen is None:
            if len(self._chosen) > _MOST_CHOSEN:
                self._chosen.clear()
            needed = {layers.get(name).drawn_by for name in needs}
            kinds = [part for part in parts if part.name in needed or part.in_scene(self.scene)]
            chosen = []
            for part in sorted(kinds, key=lambda part: part.order):
                key = client if part.of_client else None, part.name
                if key not in self._parts:
                    self._parts[key] = part(self._context)
                chosen.append(self._parts[key])
            self._chosen[client, needs] = chosen
        return chosen

    def forget(self, client: Hashable) -> None:
        for key in [key for key in self._parts if key[0] == client]:
            self._parts.pop(key).close()
        self._chosen = {key: chosen for key, chosen in self._chosen.items() if key[0] != client}

    def draw_depth(self, view: View, size: Size, into: moderngl.Texture, time_ns: int = 0) -> moderngl.Texture:
        _check_same_size(into.size, size)
        self._depth_passes().draw(view, self._framebuffers.over(into), time_ns)
        for part in self._parts_for(Drawing(view, size, time_ns)):
            part.add_depth(view, time_ns, into)
        return into

    def draw_frame(
        self,
        views: Sequence[View],
        drawn_ns: int,
        size: Size,
        guard: Guard = 1.0,
        needs: Needs | None = None,
        shown_size: Size | None = None,
        age_ns: int = 0,
        pictures: bool | None = True,
    ) -> Frame:
        """Draw all eyes, and the needed layers, into pooled targets.

        guard: how much each field of view is enlarged. shown_size: of the display's picture, if the
        frame has another resolution. age_ns: how old it will be when it is seen. pictures: False
        leaves the eyes' pictures empty, None leaves in them what they had. Return the frame to the
        pools with recycle(). Errors: as guarded_eyes; InputError for a cube beyond the GL limit.
        """
        needs = needs if needs is not None else Needs()
        fovs, grown = guarded_eyes(views, guard, size)
        guarded = [view.within(fov) for view, fov in zip(views, fovs, strict=True)]
        drawings = [Drawing(view, size, drawn_ns, needs, shown_size, self._marched, age_ns) for view in views]
        return self._draw_all(guarded, grown, drawings, pictures=pictures)

    def draw_guarded(
        self,
        views: Sequence[View],
        drawn_ns: int,
        size: Size,
        needs: Needs,
        shown: Sequence[Fov],
        shown_size: Size,
        *,
        age_ns: int = 0,
        client: Hashable = None,
        pictures: bool = True,
    ) -> Frame:
        """Draw all eyes as draw_frame does, guard band added; shown, shown_size: without it."""
        seen = [attrs.evolve(view, fov=fov, hidden=None) for view, fov in zip(views, shown, strict=True)]
        what = drawn_ns, needs, shown_size, self._marched, age_ns, client
        drawings = [Drawing(view, shown_size, *what) for view in seen]
        return self._draw_all(views, size, drawings, pictures=pictures)

    def _draw_all(
        self, views: Sequence[View], size: Size, drawings: Sequence[Drawing], *, pictures: bool | None
    ) -> Frame:
        drawn_ns, eyes = drawings[0].time_ns, []
        shared: dict[str, Any] = {}
        for part in self._parts_for(drawings[0]):
            shared |= part.of_frame(views, drawings[0])
        for view, drawing in zip(views, drawings, strict=True):
            if pictures:
                eyes.append(self._draw(view, size, drawing))
                continue
            target, empty = self.acquire(size), frozenset(PICTURE)
            if pictures is not None:
                self.clear(target)
            eyes.append(EyeImage(view, target.colour, target.inverse_depth, drawn_ns=drawn_ns, left_out=empty))
        return Frame(tuple([eye.having(**shared) for eye in eyes] if shared else eyes), drawn_ns)

    def clear(self, into: Target) -> None:
        self._framebuffers.over(into.colour).clear()
        self._framebuffers.over(into.inverse_depth).clear(red=-1.0)

    def heard_of(self, client: Hashable, carried: Mapping[str, Any], arrived: bool, heard_ns: int) -> None:
        for (of_client, _), part in self._parts.items():
            if of_client == client:
                part.heard(carried, arrived, heard_ns)

    def has_more(self, now_ns: int, client: Hashable = None) -> bool:
        return any(part.has_more(now_ns) for (of_client, _), part in self._parts.items() if of_client == client)

    def surfaces(self) -> Iterator[SceneBuffers]:
        """Yield the buffers of all plain surfaces: those that stand still, then those that move."""
        yield self._buffers
        yield from (drawing.buffers for drawing in self._moving)

    def trim(self) -> None:
        for part in self._parts.values():
            part.trim()
        self._framebuffers.trim()
        if self._several is not None:
            self._several.trim()
        super().trim()

    def close(self) -> None:
        for part in self._parts.values():
            part.close()
        super().close()


def _check_same_size(target: Size, picture: Size) -> None:
    if tuple(target) != tuple(picture):
        why = "they must be the same"
        raise InputError(f"target is {target[0]}x{target[1]} pixels, the picture {picture[0]}x{picture[1]}: {why}")
