"""The scene on the client: exact depth of all triangles, and a reduced model to draw in holes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import moderngl

from ..gpu.scopes import drawing_into
from ..gpu.textures import SCALAR, allocate
from ..scenes import Pieces, partial_scene, pieces_of, reduced, unlit, with_lamps_stopped
from ..sources.server import (
    Framebuffers,
    Renderer,
    SceneBuffers,
    ScenePasses,
    SceneTextures,
    Server,
    Target,
    clear_depth,
    moving_parts,
)
from .arriving_scene import ArrivingScene
from .client_photons import ClientPhotons
from .client_points import ClientPoints
from .client_soft_bodies import ClientSoftBodies
from .scene_under_light import SceneUnderLight, SceneUnderPhotons

if TYPE_CHECKING:
    from ..client import ShownPicture
    from ..frames import Frame
    from ..frames.deliveries import Update
    from ..frames.layers.photons import PhotonMap
    from ..frames.layers.points import Cloud
    from ..frames.layers.scene_update import Delivery
    from ..frames.photon_bundles import PhotonUpdate
    from ..frames.point_blocks import PointUpdate
    from ..geometry import View
    from ..gpu.context import Gpu
    from ..scenes import Scene

Size = tuple[int, int]
# Share of the triangles, scale of the textures, whether lit.
_Key = tuple[float, float, bool]


class ClientScene:
    """The client.ClientGeometry of a scene.

    server: of the same scene; it draws the exact depth. cache: folder of reduced scenes, None for
    the user's cache folder. A model is reduced and uploaded on first use.
    """

    def __init__(self, server: Renderer, cache: Path | None = None) -> None:
        self._server, self._cache = server, cache
        self._models: dict[_Key, DrawnModel] = {}
        self._scenes: dict[_Key, SceneOnClient] = {}
        self._arriving: dict[Delivery, ArrivingScene] = {}
        self._points: dict[Cloud, ClientPoints] = {}
        self._photons: dict[PhotonMap, ClientPhotons] = {}
        self._lit: SceneUnderLight | None = None
        self._soft: ClientSoftBodies | None = None

    @property
    def is_still(self) -> bool:
        """Whether nothing changes, see ClientGeometry.is_still; unknown of recorded frames."""
        return self._server.scene.is_still

    def draw_depth(self, view: View, size: Size, into: moderngl.Texture, time_ns: int = 0) -> moderngl.Texture:
        """Draw the depth of every triangle, see ClientGeometry.draw_depth."""
        return self._server.draw_depth(view, size, into, time_ns)

    def model(self, share: float, *, lit: bool, texture: float = 1.0) -> DrawnModel:
        """Return a model, see ClientGeometry.model."""
        key = (share, texture, lit)
        if key not in self._models:
            scene = reduced(with_lamps_stopped(self._server.scene), share, self._cache, texture=texture)
            self._models[key] = DrawnModel(self._server.gpu, scene, lit=lit)
        return self._models[key]

    def scene(self, share: float, *, lit: bool, texture: float = 1.0) -> SceneOnClient:
        """Return a scene that is drawn whole, see ClientGeometry.scene."""
        key = (share, texture, lit)
        if key not in self._scenes:
            whole = partial_scene(self._server.scene, share, texture, lit=lit, folder=self._cache)
            self._scenes[key] = SceneOnClient(self._server, whole)
        return self._scenes[key]

    def under_light(self) -> SceneUnderLight:
        """Return the whole scene under its lamps, see ClientGeometry.under_light."""
        if self._lit is None:
            self._lit = SceneUnderLight(self._server.gpu, self._server.scene)
        return self._lit

    def soft_bodies(self) -> ClientSoftBodies:
        """Return what deforms, see ClientGeometry.soft_bodies."""
        if self._soft is None:
            self._soft = ClientSoftBodies(self._server.gpu, self._server.scene)
        return self._soft

    def arriving(self, delivery: Delivery) -> ArrivingScene:
        """Return a scene that arrives little by little, see ClientGeometry.arriving."""
        if delivery not in self._arriving:
            pieces = pieces_of(self._server.scene, delivery.share, delivery.texture, lit=delivery.lit)
            self._arriving[delivery] = ArrivingScene(self._server.gpu, pieces)
        return self._arriving[delivery]

    def points(self, cloud: Cloud) -> ClientPoints:
        """Return the points that have arrived, see ClientGeometry.points."""
        if cloud not in self._points:
            self._points[cloud] = ClientPoints(self._server.gpu, self._server.scene, cloud)
        return self._points[cloud]

    def photons(self, wanted: PhotonMap) -> ClientPhotons:
        """Return the photons that have arrived, see ClientGeometry.photons."""
        if wanted not in self._photons:
            lit = SceneUnderPhotons(self._server.gpu, self._server.scene, wanted.radius)
            self._photons[wanted] = ClientPhotons(self._server.gpu, lit, wanted)
        return self._photons[wanted]

    def receive(self, frame: Frame) -> None:
        """Take what a frame brings of the scene; call it with each frame that arrives."""
        updates: Mapping[Delivery, Update] = frame.eyes[0].get("scene_update", {})
        for delivery, update in updates.items():
            self.arriving(delivery).receive(update.content)
        clouds: Mapping[Cloud, PointUpdate] = frame.eyes[0].get("points", {})
        for cloud, points in clouds.items():
            self.points(cloud).receive(points.content)
        maps: Mapping[PhotonMap, PhotonUpdate] = frame.eyes[0].get("photons", {})
        for wanted, photons in maps.items():
            self.photons(wanted).receive(photons.content)

    def weights(self) -> list[dict[str, Any]]:
        """Return what the client must hold of each model that was made: triangles and bytes.

        A model drawn with light and without counts once: it differs by three numbers a vertex.
        Scenes that are drawn instead of a picture say what crossed for them too, packed: at the
        start, until the first whole picture, and in all.
        """
        found = {(share, texture): model.scene for (share, texture, _), model in self._models.items()}
        weights: list[dict[str, Any]] = [
            {"share": share, "texture": texture, **weight_of(scene)} for (share, texture), scene in found.items()
        ]
        for (share, texture, _), whole in self._scenes.items():
            packed = Pieces(whole.scene).whole_bytes
            weights.append(
                {"share": share, "texture": texture, **weight_of(whole.scene), "start_up_bytes": packed}
                | {"first_picture_bytes": packed, "arrived_bytes": packed}
            )
        for scene in [one.scene for one in (self._lit, *(photons.scene for photons in self._photons.values())) if one]:
            packed = Pieces(scene).whole_bytes
            named = {"share": 1.0, "texture": 1.0, **weight_of(scene), "start_up_bytes": packed}
            weights.append({**named, "first_picture_bytes": packed, "arrived_bytes": packed})
        if self._soft is not None:
            packed = Pieces(self._soft.scene).whole_bytes
            named = {"share": 1.0, "texture": 1.0, **weight_of(self._soft.scene), "start_up_bytes": packed}
            weights.append({**named, "first_picture_bytes": packed, "arrived_bytes": packed})
        for delivery, arriving in self._arriving.items():
            named = {"share": delivery.share, "texture": delivery.texture, "budget": delivery.budget}
            weights.append({**named, **weight_of(arriving.scene), **arriving.weight()})
        weights += [cloud.weight() for cloud in self._points.values()]
        weights += [photons.weight() for photons in self._photons.values()]
        return weights

    def close(self) -> None:
        """Free the models; the caller closes the server."""
        for made in (self._models, self._scenes, self._arriving, self._points, self._photons):
            for model in made.values():
                model.close()
            made.clear()
        for one in (self._lit, self._soft):
            if one is not None:
                one.close()
        self._lit = self._soft = None


class SceneOnClient:
    """A client.DrawnScene: a renderer of the client's own, or the server's for the same scene."""

    def __init__(self, server: Renderer, scene: Scene) -> None:
        self.scene = scene
        self._is_own = scene is not server.scene
        self._renderer = Server(server.gpu, scene) if self._is_own else server

    def draw(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw the whole picture, see DrawnScene.draw."""
        target = Target(into.colour.texture, into.depth)
        self._renderer.draw(view, target.size, target, time_ns)

    def close(self) -> None:
        """Free its renderer."""
        if self._is_own:
            self._renderer.close()


class DrawnModel:
    """A client.ClientModel that draws surfaces only."""

    def __init__(self, gpu: Gpu, scene: Scene, *, lit: bool) -> None:
        self._gl = gpu.gl
        self.scene = scene = scene if lit else unlit(scene)
        self._textures = SceneTextures(gpu, scene)
        self._buffers = SceneBuffers(gpu, [mesh for mesh in scene.meshes if mesh.stands_still], self._textures)
        self._moving = moving_parts(gpu, scene, self._textures)
        self._passes = ScenePasses(gpu, scene, self._buffers, colour=True, moving=self._moving)
        self._framebuffers = Framebuffers(gpu.gl)
        self._cover = gpu.shaders.draw("server/background.vert", "fills/model_cover.frag")
        self._empty = gpu.gl.vertex_array(self._cover.program, [])
        self._no_depth = allocate(gpu.gl, (1, 1), SCALAR)

    def reserve(self, size: Size) -> None:
        """Allocate for pictures of that size, see ClientModel.reserve."""
        self._framebuffers.reserve(size)

    def draw(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw the whole picture, see ClientModel.draw."""
        self._passes.draw(view, self._over(into), time_ns)

    def draw_holes(self, view: View, picture: ShownPicture, into: ShownPicture, time_ns: int) -> None:
        """Draw into holes alone, see ClientModel.draw_holes.

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
        self._passes.draw_into(view, framebuffer, None, time_ns)
        gl.polygon_offset = 0.0, 0.0

    def _over(self, into: ShownPicture) -> moderngl.Framebuffer:
        depth = (into.inverse_depth,) if into.inverse_depth is not None else ()
        return self._framebuffers.over(into.colour.texture, *depth)

    def close(self) -> None:
        """Free its buffers; the shader library owns the programs."""
        self._passes.close()
        self._empty.release()
        for one in self._moving:
            one.close()
        self._framebuffers.close()
        self._buffers.close()
        self._textures.close()
        self._no_depth.release()


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
