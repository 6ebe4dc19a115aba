"""Scenes that the client draws by itself: a model of surfaces alone, and whole scenes."""

from __future__ import annotations

from typing import Any, TypeVar, cast

import attrs
import moderngl

from ..geometry import View
from ..gpu.context import Gpu
from ..gpu.textures import SCALAR, allocate, drawing_into
from ..scenes import Pieces, Scene, only_emission, partial_scene, reduced, unlit, with_lamps_stopped
from ..sources.server import (
    ConvergedLight,
    Framebuffers,
    Lighting,
    Multisampled,
    Renderer,
    SceneBuffers,
    ScenePasses,
    SceneTextures,
    Server,
    Target,
    clear_depth,
    moving_parts,
)
from .client_scene import ClientScene, Store
from .inputs import ShownPicture

Size = tuple[int, int]
Light = TypeVar("Light", bound=Lighting)


class Surfaces:
    """The surfaces of a scene, drawn by the server's own passes: rgba16f and r32f inverse depth.

    kinds: of light; there are passes for each. samples: of each pixel, as the server has them:
    colour is their mean, inverse depth that of the pixel's centre.
    """

    def __init__(self, gpu: Gpu, scene: Scene, *kinds: type[Lighting], samples: int = 1) -> None:
        self.scene = scene
        self._several = Multisampled(gpu, samples) if samples > 1 else None
        surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
        self._textures = SceneTextures(gpu, scene)
        self._buffers = SceneBuffers(gpu, [mesh for mesh in surfaces if mesh.stands_still], self._textures)
        self._moving = moving_parts(gpu, scene, self._textures)
        self._passes = {
            kind: ScenePasses(gpu, scene, self._buffers, colour=True, moving=self._moving, light=kind) for kind in kinds
        }
        self._gpu = gpu
        self._depth: ScenePasses | None = None
        self._framebuffers = Framebuffers(gpu.gl)

    def reserve(self, size: Size) -> None:
        """Allocate what pictures of that size need."""
        self._framebuffers.reserve(size)

    def lighting(self, kind: type[Light]) -> Light | None:
        """Return the light of the passes of that kind; None without lamps."""
        return cast("Light | None", self._passes[kind].lighting)

    def draw(self, view: View, into: ShownPicture, time_ns: int, kind: type[Lighting] = ConvergedLight) -> None:
        """Draw the whole picture: coverage 1 everywhere, sky included (inverse depth 0).

        What is read as data, not seen, has one sample a pixel: a mean of normals is none.
        """
        if self._several is None or not kind.coloured:
            self._passes[kind].draw(view, self._over(into), time_ns)
            return
        self._several.draw(self._passes[kind], view, into.colour.texture, time_ns)
        if into.inverse_depth is not None:
            self._depth_passes().draw(view, self._framebuffers.over(into.inverse_depth), time_ns)

    def _depth_passes(self) -> ScenePasses:
        if self._depth is None:
            self._depth = ScenePasses(self._gpu, self.scene, self._buffers, colour=False, moving=self._moving)
        return self._depth

    def _over(self, into: ShownPicture) -> moderngl.Framebuffer:
        depth = (into.inverse_depth,) if into.inverse_depth is not None else ()
        return self._framebuffers.over(into.colour.texture, *depth)

    def close(self) -> None:
        """Free its buffers; the shader library owns the programs."""
        for passes in self._passes.values():
            passes.close()
        if self._several is not None:
            self._several.close()
        if self._depth is not None:
            self._depth.close()
        self._framebuffers.close()
        for part in self._moving:
            part.close()
        self._buffers.close()
        self._textures.close()


class ReducedModel(Store):
    """Surfaces with a share of the scene's triangles and of its textures' resolution.

    wanted: both, as (share, texture). Errors: SceneError for a share or scale that is not above 0
    and at most 1.
    """

    def __init__(self, client: ClientScene, wanted: tuple[float, float]) -> None:
        super().__init__(client, wanted)
        self._scene = reduced(with_lamps_stopped(client.scene), wanted[0], texture=wanted[1])
        self._drawn: dict[bool | None, DrawnModel] = {}

    def drawn(self, *, lit: bool) -> DrawnModel:
        """Return the model with baked light, else with light of 1 everywhere (albedo)."""
        if lit not in self._drawn:
            self._drawn[lit] = DrawnModel(self.client, self._scene if lit else unlit(self._scene))
        return self._drawn[lit]

    def shining(self) -> DrawnModel | None:
        """Return the model with what its textures emit alone, black elsewhere; None without any."""
        if None not in self._drawn and (scene := only_emission(self._scene)) is not None:
            self._drawn[None] = DrawnModel(self.client, scene)
        return self._drawn.get(None)

    def weights(self) -> list[dict[str, Any]]:
        """Count it once, with light and without: that differs by three numbers a vertex."""
        share, texture = self.wanted
        return [{"share": share, "texture": texture, **weight_of(self._scene)}]

    def close(self) -> None:
        for model in self._drawn.values():
            model.close()


class DrawnModel(Surfaces):
    """A model that can also be drawn into holes alone, then with one sample a pixel."""

    def __init__(self, client: ClientScene, scene: Scene) -> None:
        super().__init__(client.gpu, scene, ConvergedLight, samples=client.server.samples)
        gpu, self._gl = client.gpu, client.gpu.gl
        self._cover = gpu.shaders.draw("server/background.vert", "fills/model_cover.frag")
        self._empty = gpu.gl.vertex_array(self._cover.program, [])
        self._no_depth = allocate(gpu.gl, (1, 1), SCALAR)

    def draw_holes(self, view: View, picture: ShownPicture, into: ShownPicture, time_ns: int) -> None:
        """Draw into the holes of `picture`; elsewhere copy its colour and inverse depth.

        Covered pixels get the nearest value in the depth buffer, so that only holes are shaded.
        """
        framebuffer, gl = self._over(into), self._gl
        clear_depth(gl, framebuffer)
        picture.colour.texture.use(0)
        (picture.inverse_depth if picture.inverse_depth is not None else self._no_depth).use(1)
        self._cover.uniforms.set(warped=0, warped_inverse_depth=1)
        with drawing_into(framebuffer, moderngl.DEPTH_TEST):
            self._empty.render(moderngl.TRIANGLES, vertices=3)
        gl.polygon_offset = 0.0, 2.0  # surfaces at the near plane must stay behind covered pixels
        self._passes[ConvergedLight].draw_into(view, framebuffer, None, time_ns)
        gl.polygon_offset = 0.0, 0.0

    def close(self) -> None:
        super().close()
        self._empty.release()
        self._no_depth.release()


class WholeScene(Store):
    """A scene that is drawn with all that is in it: mirrors, glass, overlays.

    wanted: a Simplified of frames.layers.scene_parts: share of the triangles of plain surfaces,
    scale of textures, whether lit. With a share and a scale of 1, lit, it is drawn as the server
    draws it, to the last bit.
    """

    def __init__(self, client: ClientScene, wanted: Any) -> None:
        super().__init__(client, wanted)
        self.scene = partial_scene(client.scene, wanted.share, wanted.texture, lit=wanted.lit)
        self._is_own = self.scene is not client.scene
        server = client.server
        self._renderer = server if not self._is_own else server_of(server, self.scene)

    def draw(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw the whole picture."""
        target = Target(into.colour.texture, into.depth)
        self._renderer.draw(view, target.size, target, time_ns)

    def weights(self) -> list[dict[str, Any]]:
        return [whole_weight(self.scene, self.wanted.share, self.wanted.texture)]

    def close(self) -> None:
        if self._is_own:
            self._renderer.close()


def server_of(server: Renderer, scene: Scene, lighting: Lighting | None = None, *, changes: bool = False) -> Server:
    """Return a server of another scene, which draws as `server` does where that draws.

    changes: whether its textures will.
    """
    if isinstance(server, Server):
        return server.of_another(scene, lighting, changes=changes)
    return Server(server.gpu, scene, lighting=lighting, changes=changes)


def weight_of(scene: Scene) -> dict[str, int]:
    """Return `triangles`, `geometry_bytes` and `texture_bytes` of a scene, uncompressed.

    Vertices are a position, a place on the texture and a light in float32; triangles three 32-bit
    indices; texels 8 bits a channel, without mipmaps, of the textures that some mesh has.
    """
    vertices = sum(len(mesh.positions) for mesh in scene.meshes)
    used = {mesh.texture for mesh in scene.meshes if mesh.texture >= 0}
    return {
        "triangles": scene.triangle_count,
        "geometry_bytes": 4 * (3 + 2 + 3) * vertices + 4 * 3 * scene.triangle_count,
        "texture_bytes": sum(scene.textures[index].image.nbytes for index in used),
    }


def whole_weight(scene: Scene, share: float = 1.0, texture: float = 1.0) -> dict[str, Any]:
    """Return the weight of a scene that is drawn instead of a picture, with what crosses of it.

    It crosses once, packed: at the start, so until the first whole picture, and in all.
    """
    packed = dict.fromkeys(("start_up_bytes", "first_picture_bytes", "arrived_bytes"), Pieces(scene).whole_bytes)
    return {"share": share, "texture": texture, **weight_of(scene), **packed}


def share_of(default: float) -> float:
    """Return a setting that is more than 0 and at most 1."""
    return attrs.field(default=default, validator=_check_share)


def _check_share(_: object, field: attrs.Attribute[float], value: float) -> None:
    if not 0 < value <= 1:
        raise ValueError(f"{field.name} is {value:g}: expected more than 0 and at most 1")
