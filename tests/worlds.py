"""Random rendered pictures and everything a warp may read, on the GPU and for the float64 twins."""

from __future__ import annotations

import functools
import importlib
import pkgutil
import typing

import attrs
import numpy as np
import reference
from reference.picture import GPU_SAMPLER_PIXELS, ReferencePicture, RenderedPicture, TwinInputs
from scipy.spatial.transform import Rotation

from hmdwarp.client import CLIENT_DEPTH, PassInputs, every_baseline, every_warp, parse_warp
from hmdwarp.client.warps import Output, Warp, warps
from hmdwarp.frames import EyeImage, Surface
from hmdwarp.frames.layers import RENDERED, layers
from hmdwarp.geometry import Fov, Pose, View, face_views
from hmdwarp.geometry.cube import FACES
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate, download, flip_rows

ONE_TEXTURE = (("rgba16f",), ("r32f",))  # formats of colour and of depth
PICTURED = ("mesh", "mesh_adaptive", "splat")
"""Warps without a twin: golden pictures hold them, tests/client/test_contract.py.

What a rasteriser does at edges, or a footprint, would be the same route again in float64.
"""


def has_twin(spec: str) -> bool:
    return parse_warp(spec).entry.name not in PICTURED


@functools.cache
def twin_of(name: str):
    """The float64 twin of a warp: the public function of its name in a module of reference."""
    modules = (importlib.import_module(f"reference.{found.name}") for found in pkgutil.iter_modules(reference.__path__))
    twins = {
        module: vars(module)[name]
        for module in modules
        if name in vars(module) and vars(module)[name].__module__ == module.__name__
    }
    assert len(twins) == 1, f"warp '{name}' needs one function '{name}' in tests/reference, found {len(twins)}"
    return next(iter(twins.values()))


def every_compared() -> list[str]:
    """Each warp with its defaults, its variants, and its settings that are somebody's baseline.

    Without mesh:grid=512,ring=0.002, half a million triangles: it is mesh:grid=64 with other
    numbers. Without what draws a scene: that is compared in tests/client/test_model.py.
    """
    every = [*every_warp(), *(spec for spec in every_baseline() if spec != "mesh:grid=512,ring=0.002")]
    return [spec for spec in every if parse_warp(spec).entry.kind != "draw"]


def every_choice() -> list[str]:
    """The same, and each warp with every other word that one of its settings may be."""
    specs = every_compared()
    for warp in (warp for warp in warps if warp.kind != "draw"):
        for field in attrs.fields(warp.Settings):
            words = typing.get_args(typing.get_type_hints(warp.Settings)[field.name])
            specs += [f"{warp.name}:{field.name}={word}" for word in words if word != field.default]
    return list(dict.fromkeys(specs))


def pixels(texture) -> np.ndarray:
    """Texture to float64, bottom row first: (h, w) of one channel, else (h, w, channels)."""
    return flip_rows(download(texture)).astype(np.float64)


def read(texture) -> np.ndarray:
    """Texture to float64 (h, w, channels), bottom row first as stored."""
    return pixels(texture).reshape(texture.height, texture.width, -1)


def shown_by(
    gpu,
    spec: str,
    inputs: PassInputs,
    shown_size: tuple[int, int],
    output: Output | None = None,
    geometry: object = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Colour (h, w, 4) and, where `output` asks for it, inverse depth (h, w) of one run."""
    choice, output = parse_warp(spec), output or Output()
    warp = choice.entry(gpu, inputs.rendered.size, shown_size, choice.settings, output, geometry)
    canvas, depth = Canvas(gpu.gl, shown_size), allocate(gpu.gl, shown_size, SCALAR)
    if output.depth:
        warp.run_with_depth(inputs, canvas, depth)
    else:
        warp.run(inputs, canvas)
    gpu.barrier()
    found = read(canvas.texture), read(depth)[..., 0]
    for thing in (canvas, depth):
        thing.release()
    warp.close()
    return found


class World:
    """A rendered picture of a few planes with holes, and a view a plausible head motion away."""

    def __init__(
        self, gpu, seed: int, size: tuple[int, int], shown_size: tuple[int, int] | None = None, *, moved: bool = True
    ) -> None:
        self.rng = rng = np.random.default_rng(seed)
        self.size, self.shown_size = size, shown_size or size
        self.layers: tuple[RenderedPicture, ...] = ()
        self.others: tuple[RenderedPicture, ...] = ()
        self.other_images: tuple[EyeImage, ...] = ()
        self.cube: np.ndarray | None = None
        fov = Fov(*np.deg2rad([-rng.uniform(30, 55), rng.uniform(30, 55), -rng.uniform(30, 55), rng.uniform(30, 55)]))
        self.rendered_view = View(Pose(rng.normal(size=3), rng.normal(size=4)), fov)
        turn = Rotation.from_rotvec(np.deg2rad(rng.normal(scale=5 if moved else 0, size=3)))
        step = rng.normal(scale=0.03 if moved else 0, size=3)
        pose = Pose(self.rendered_view.pose.position_m + step, (self.rendered_view.pose.rotation * turn).as_quat())
        self.shown_view = View(pose if moved else self.rendered_view.pose, fov)
        self._draw()
        self.client = self._client_depth()
        self.upload(gpu)
        # llvmpipe turns a place into 0..1 and back in float32: a division and a product, each half
        # a unit of the place.
        self.sampler_pixels = 4 * 2.0**-24 * max(size) if gpu.is_software else GPU_SAMPLER_PIXELS

    def _draw(self) -> None:
        rng, (wide, high) = self.rng, self.size
        colour = rng.uniform(0, 2, (high, wide, 3))
        depth = np.full((high, wide), 0.2)
        y, x = np.mgrid[:high, :wide] / max(self.size)
        for _ in range(6):
            inside = (abs(x - rng.uniform(0, 1)) < rng.uniform(0.05, 0.2)) & (
                abs(y - rng.uniform(0, 1)) < rng.uniform(0.05, 0.2)
            )
            plane = rng.uniform(0.05, 1.5) + rng.normal(scale=0.1) * x + rng.normal(scale=0.1) * y
            depth = np.where(inside & (plane > depth), plane, depth)
        depth[(x + y) % 0.3 < 0.03] = 0  # infinitely far
        if depth.size > 4:
            depth[rng.uniform(size=depth.shape) < 0.02] = -1  # no depth
        covered = depth >= 0
        self.inverse_depth = depth.astype(np.float32).astype(np.float64)
        self.colour = (
            np.concatenate([colour * covered[..., None], covered[..., None]], axis=2)
            .astype(np.float16)
            .astype(np.float64)
        )

    def _client_depth(self) -> np.ndarray:
        """Any depth will do for the contract.

        The rendered depth itself, resized, so that many pixels agree and many do not.
        """
        (wide, high), (w, h) = self.size, self.shown_size
        return self.inverse_depth[np.arange(h) * high // h][:, np.arange(w) * wide // w]

    def render_wider(self, gpu, guard) -> None:
        """Render another picture, with a guard band; what is shown stays as it is."""
        fov, self.size = self.rendered_view.fov.guarded(guard, self.size)
        self.rendered_view = View(self.rendered_view.pose, fov)
        self._draw()
        self.client = self._client_depth()
        self.upload(gpu)
        self.sampler_pixels *= max(self.size) / max(self.shown_size) if gpu.is_software else 1

    def upload(self, gpu) -> None:
        self.rendered = EyeImage(self.rendered_view, *self._textures(gpu, self.colour, self.inverse_depth))
        self.client_texture = allocate(gpu.gl, self.shown_size, SCALAR)
        self.client_texture.write(self.client.astype(np.float32).tobytes(), alignment=1)

    def _textures(self, gpu, colour: np.ndarray, inverse_depth: np.ndarray) -> tuple:
        texture, depth = self._colour_texture(gpu, colour), allocate(gpu.gl, self.size, SCALAR)
        depth.write(inverse_depth.astype(np.float32).tobytes(), alignment=1)
        return texture, depth

    def _colour_texture(self, gpu, colour: np.ndarray):
        texture = allocate(gpu.gl, colour.shape[1::-1], COLOUR)
        texture.write(colour.astype(np.float16).tobytes(), alignment=1)
        return texture

    def _picture(self) -> tuple[np.ndarray, np.ndarray]:
        """Another random picture of this world's rendered size."""
        before = self.colour, self.inverse_depth
        self._draw()
        drawn = self.colour, self.inverse_depth
        self.colour, self.inverse_depth = before
        return drawn

    def bring(self, gpu, entry: type[Warp]) -> None:
        """Everything else that a warp of this kind reads.

        Layers behind the visible surfaces, a cube around the eye, further pictures.
        """
        settings = entry.Settings()
        if "rendered.cube" in entry.reads:
            self.bring_cube(gpu)
        if "rendered.irradiance" in entry.reads:
            self.rendered = self.rendered.having(irradiance=self._colour_texture(gpu, np.zeros((64, 64, 4))))
        if "rendered.peeled" in entry.reads:
            self.layers = self.layers or tuple(self._behind(k + 1) for k in range(entry.needs(settings)["peeled"]))
            uploaded = tuple(Surface(*self._textures(gpu, layer.colour, layer.inverse_depth)) for layer in self.layers)
            self.rendered = self.rendered.having(peeled=uploaded)
        if "rendered.others" in entry.reads:
            self.others = self.others or tuple(RenderedPicture(*self._picture(), self._beside()) for _ in range(2))
            self.other_images = tuple(
                EyeImage(other.view, *self._textures(gpu, other.colour, other.inverse_depth)) for other in self.others
            )

        self.bring_layers(gpu, entry.reads)

    def bring_layers(self, gpu, reads: tuple[str, ...]) -> None:
        """Noise for each layer that is one texture of the picture's size, and not there yet."""
        for layer in (layers.get(name.partition(".")[2]) for name in reads if name.startswith("rendered.")):
            lacks = not layer.always and layer.name not in self.rendered
            if lacks and layer.size_class == RENDERED and layer.formats in ONE_TEXTURE:
                texture = self._textures(gpu, *self._picture())[ONE_TEXTURE.index(layer.formats)]
                self.rendered = self.rendered.having(**{layer.name: texture})

    def bring_cube(self, gpu) -> None:
        """Random colours around the rendered eye, faces as wide as the picture's longer side."""
        if self.cube is None:
            side = max(self.size) + 2
            colour = self.rng.uniform(0, 2, (2 * side, 3 * side, 3))
            self.cube = np.dstack([colour, np.ones(colour.shape[:2])]).astype(np.float16).astype(np.float64)
        self.rendered = self.rendered.having(cube=self._colour_texture(gpu, self.cube))

    def look_along_a_face(self, gpu, index: int, margin: int = 0) -> np.ndarray:
        """Show what the cube holds in one face, less `margin` of its pixels on each side.

        Returns that picture.
        """
        self.bring_cube(gpu)
        face, side = FACES[index], max(self.size) + 2
        edge, left = 1 + margin, (side - 2) / 2
        narrower = (left - margin) / left
        turned = face_views(self.rendered_view, side)[index].pose
        self.shown_view = View(turned, Fov.from_tangents([-narrower, narrower, -narrower, narrower]))
        self.shown_size = (side - 2 * edge, side - 2 * edge)
        x, y = face.column * side, face.row * side
        return self.cube[y + edge : y + side - edge, x + edge : x + side - edge]

    def _behind(self, number: int) -> RenderedPicture:
        """A layer.

        Farther than the visible surface by a factor, missing where a peel would find nothing more.
        """
        colour, _ = self._picture()
        missing = (self.inverse_depth <= 0) | (self.rng.uniform(size=self.inverse_depth.shape) < 0.3)
        depth = np.where(missing, -1, self.inverse_depth * 0.6**number).astype(np.float32).astype(np.float64)
        colour[..., 3] = 1
        return RenderedPicture(colour * ~missing[..., None], depth, self.rendered_view)

    def _beside(self) -> View:
        """The rendered view from a few centimetres beside."""
        pose = self.rendered_view.pose
        return View(
            Pose(pose.position_m + self.rng.normal(scale=0.03, size=3), pose.orientation_xyzw), self.rendered_view.fov
        )

    def inputs(self, entry: type[Warp] | None) -> PassInputs:
        own = self.client_texture if entry is not None and CLIENT_DEPTH in entry.reads else None
        return PassInputs(self.rendered, self.shown_view, others=self.other_images, client_inverse_depth=own)

    def warp(self, gpu, spec: str) -> np.ndarray:
        choice = parse_warp(spec)
        self.bring(gpu, choice.entry)
        warp = choice.entry(gpu, self.size, self.shown_size, choice.settings)
        canvas, inputs = Canvas(gpu.gl, self.shown_size), self.inputs(choice.entry)
        warp.run(inputs, canvas)
        gpu.gl.memory_barrier()
        out = read(canvas.texture)
        warp.run(inputs, canvas)  # a second run must not see what the first left behind
        gpu.gl.memory_barrier()
        assert np.array_equal(out, read(canvas.texture), equal_nan=True), "two runs differ"
        warp.close()
        canvas.release()
        return out

    def asked(self, settings: object) -> TwinInputs:
        return TwinInputs(
            self.colour, self.inverse_depth, self.rendered_view, self.shown_view, self.shown_size,
            client_inverse_depth=self.client, layers=self.layers, cube=self.cube, others=self.others, settings=settings,
            sampler_pixels=self.sampler_pixels,
        )  # fmt: skip

    def reference(self, spec: str):
        """What the twin makes of it; after warp(), which brings what the warp reads."""
        choice = parse_warp(spec)
        return twin_of(choice.entry.name)(self.asked(choice.settings))


def assert_equals_twin(got: np.ndarray, wanted: ReferencePicture, least_decided: float = 0.9) -> None:
    """Rounding may decide near borders between pixels and near equal depths, a few of a hundred."""
    decided = ~wanted.undecided
    if decided.size > 1000:
        assert decided.mean() > least_decided
    assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
    difference = np.abs(got[..., :3] - wanted.colour[..., :3]).max(axis=-1)
    assert (difference <= wanted.tolerance)[decided].all(), f"worst {(difference - wanted.tolerance)[decided].max()}"
