"""The client draws the scene under its own direct light; indirect light arrives as photons."""

from __future__ import annotations

from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...frames import Needs
from ...frames.layers.photons import LEAST_BUDGET, PHOTON_BYTES, BundleRoom, Cube, PhotonMap, unpacked
from ...geometry import View
from ...gpu.context import Gpu, drawing_into
from ...gpu.shaders import Inputs, Uniforms
from ...gpu.textures import COLOUR, SCALAR, Canvas, allocate, release_all
from ...scenes import Scene, kernel_factors, lamps_at, light_keys, transport_of
from ...sources.server import Indirect
from ..client_scene import ClientScene, Store, receiver_of
from ..drawn_scenes import Surfaces, whole_weight
from ..inputs import PassInputs, ShownPicture
from ..warp_kinds import ClientDrawing
from . import warps

_DEFAULT = PhotonMap()
MOST_PATHS = 1 << 16
_LIGHT = (4, "f4")  # rgba32f: sums of thousands of photons


@attrs.frozen
class PhotonsSettings:
    # Bytes of each frame, at most, before they are packed: what the link carries in a frame's time,
    # so that no bundle is late by more than one. Bundles are as large as fits, up to 6 kB.
    budget: int = attrs.field(default=_DEFAULT.budget, validator=attrs.validators.ge(LEAST_BUDGET))
    # Paths that each lamp sends; they leave about one photon each.
    paths: int = attrs.field(
        default=_DEFAULT.paths,
        validator=attrs.validators.and_(attrs.validators.ge(1), attrs.validators.le(MOST_PATHS)),
    )
    # Metres that a photon lights around it: less is sharper, and uneven where photons are few.
    radius: float = attrs.field(default=_DEFAULT.radius, validator=attrs.validators.gt(0))
    # Shown pixels of one pixel of the splatted light, on each axis.
    scale: int = attrs.field(default=4, validator=attrs.validators.ge(1))


@receiver_of("photons")
class KeptPhotons(Store):
    """The newest photons of each bundle of one PhotonMap, and the whole scene, that they light.

    The buffer for all, see warps/photons.vert, is allocated at once.
    """

    def __init__(self, client: ClientScene, wanted: PhotonMap) -> None:
        super().__init__(client, wanted)
        gpu, scene = client.gpu, client.scene
        sources = Indirect.SPLATS, Indirect.RECEIVERS
        self._surfaces = Surfaces(gpu, scene, *sources, samples=client.server.samples)
        self._factors: moderngl.Texture | None = None
        if lighting := self._surfaces.lighting(Indirect.RECEIVERS):
            factors = kernel_factors(transport_of(scene), wanted.radius)
            self._factors = lighting.indirect = allocate(gpu.gl, factors.shape[1::-1], COLOUR)
            self._factors.write(factors.tobytes())
        self.photons = gpu.gl.buffer(reserve=PHOTON_BYTES * max(1, most_photons(scene, wanted)))
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget all photons; passes draw from the same buffer still."""
        self._room, self.cube, self.count = BundleRoom(), Cube(np.zeros(3), 1.0), 0
        self.bytes = 0
        self.first_picture_bytes: int | None = None

    def receive(self, content: NDArray[np.uint8]) -> None:
        if not len(content):
            return
        whole, self.cube, bundles = unpacked(content)
        self.bytes += len(content)
        if whole and self.first_picture_bytes is None:
            self.first_picture_bytes = self.bytes
        if sum(self._room.take(sent, words) for sent, words in bundles):
            words = self._room.words()
            self.count = len(words)
            self.photons.write(words.tobytes())

    def draw_receivers(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw what lamps light: the normal, and the factor for photons; 0 for what they do not."""
        self._surfaces.draw(view, into, time_ns, Indirect.RECEIVERS)

    def draw(self, view: View, into: ShownPicture, time_ns: int, splats: Inputs) -> None:
        """Draw the whole picture under the scene's own lamps and the splatted light."""
        if lighting := self._surfaces.lighting(Indirect.SPLATS):
            lighting.splats = splats
        self._surfaces.draw(view, into, time_ns, Indirect.SPLATS)

    def weights(self) -> list[dict[str, Any]]:
        """Return that of the scene; and what has crossed before packing, and what is held."""
        weight = {
            "budget": self.wanted.budget,
            "geometry_bytes": self.photons.size,
            "texture_bytes": 0,
            "start_up_bytes": 0,
            "first_picture_bytes": self.first_picture_bytes,
            "arrived_bytes": self.bytes,
            "photons": self.count,
        }
        return [whole_weight(self.client.scene), weight]

    def close(self) -> None:
        self.photons.release()
        self._surfaces.close()
        if self._factors is not None:
            self._factors.release()


def most_photons(scene: Scene, wanted: PhotonMap) -> int:
    """Return how many photons there can be at most."""
    lights = [light for light, _ in light_keys(lamps_at(scene, 0), scene.background)]
    bundles = sum(wanted.bundles(opened=light is None or not light[0][3]) for light in lights)
    return bundles * wanted.most_photons


class Splats:
    """Photons splatted at a part of the shown resolution, by deferred shading.

    Each pixel gets the light of all photons within `radius` metres of what it shows, on about the
    same plane; see shaders/warps/photons.frag.
    """

    def __init__(self, gpu: Gpu, photons: KeptPhotons, size: tuple[int, int], scale: int, radius: float) -> None:
        """Compile the programs and allocate the buffers. size: of the shown picture."""
        gl = self._gl = gpu.gl
        self._photons, self._radius, self._size = photons, radius, size
        low = (-(-size[0] // scale), -(-size[1] // scale))
        self._receivers = ShownPicture(Canvas(gl, low), allocate(gl, low, SCALAR))
        self.light = allocate(gl, low, _LIGHT)
        self._framebuffer = gl.framebuffer([self.light])
        self._program = gpu.shaders.draw("warps/photons.vert", "warps/photons.frag")
        self._vertices = gl.vertex_array(self._program.program, [(photons.photons, "3u4/i", "in_photon")])
        self._view: dict[str, object] = {}

    def draw(self, view: View, time_ns: int) -> None:
        """Splat all photons for a view."""
        photons = self._photons
        left, right, down, up = view.fov.tangents
        self._view = {
            "eye": tuple((view.pose.position_m - photons.client.scene.origin_m).tolist()),
            "scene_from_eye": view.pose.rotation_matrix,
            "low_tangents": (left, down, right, up),
            "radius": self._radius,
        }
        self._framebuffer.clear()
        if not photons.count:
            return
        photons.draw_receivers(view, self._receivers, time_ns)
        self._bind(self._program.uniforms, 0)
        self._program.uniforms.set(low=tuple(photons.cube.low.tolist()), edge=photons.cube.edge)
        with drawing_into(self._framebuffer, moderngl.BLEND):
            self._gl.blend_func = (moderngl.ONE, moderngl.ONE)
            self._vertices.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=photons.count)
            self._gl.blend_func = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA)

    def use(self, uniforms: Uniforms, unit: int) -> None:
        """Bind what shaders/lib/splatted.glsl reads, from that texture unit on."""
        self._bind(uniforms, unit)
        self.light.use(unit + 2)
        shares = tuple((np.array(self.light.size) / self._size).tolist())
        uniforms.set(splatted=unit + 2, low_per_pixel=shares)

    def _bind(self, uniforms: Uniforms, unit: int) -> None:
        self._receivers.colour.texture.use(unit)
        self._receivers.depth.use(unit + 1)
        uniforms.set(receivers=unit, receiver_depth=unit + 1, **self._view)

    def close(self) -> None:
        """Free the buffers; the shader library owns the programs."""
        self._receivers.colour.release()
        release_all(self._receivers.depth, self._vertices, self._framebuffer, self.light)


@warps.register
class Photons(ClientDrawing):
    """Splat the photons at low resolution, and draw for the shown view and instant with that light.

    Lamps and their shadows are where they are at that instant: the client knows how they move.
    """

    name = "photons"
    summary = "the client draws the scene with direct light at the newest pose, and splats photons as indirect light"
    reads = ("client.model", "rendered.photons")
    exact_when = "never: indirect light is spread over the photons' radius; direct light is exact, and never late"
    gets_wrong = (
        "indirect light is late by the link and by the frames that its bundles take, smooth within the radius, and "
        "uneven where photons are few; takes the whole scene on the client"
    )
    source = "Crassin et al. 2013, CloudLight (photons); Jensen 1996 (photon maps)"
    Settings = PhotonsSettings
    variants = ("scale=8",)
    for_moving_light = True

    @classmethod
    def needs(cls, settings: PhotonsSettings) -> Needs:
        return Needs(photons=frozenset({_wanted(settings)}))

    def prepare_scene(self, geometry: ClientScene) -> None:
        chosen = self.settings
        self._photons = geometry.store(KeptPhotons, _wanted(chosen))
        self._splats = Splats(self.gpu, self._photons, self.shown_size, chosen.scale, chosen.radius)

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        self._splats.draw(inputs.middle, inputs.shown_ns)
        self._photons.draw(inputs.middle, ShownPicture(into, depth), inputs.shown_ns, self._splats)

    def close(self) -> None:
        super().close()
        self._splats.close()


def _wanted(settings: PhotonsSettings) -> PhotonMap:
    return PhotonMap(settings.budget, settings.paths, settings.radius)
