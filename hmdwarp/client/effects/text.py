"""Panels of text and menus: kept as textures, and sampled once at the newest pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, PlanError, linear_from_srgb
from ...frames import Needs
from ...frames.layers import Inbox
from ...frames.layers.panels import UNREADABLE, PanelDelivery, picture_in, places_in, showing_in
from ...geometry import View
from ...gpu import Compute, Gpu
from ...gpu.textures import COLOUR, Canvas, allocate, flip_rows, texture_bytes
from ...scenes import Panel
from ..client_scene import ClientScene, Store, receiver_of
from ..inputs import PassInputs, ShownPicture
from . import ShownPass, effects

Array = NDArray[np.float64]
Size = tuple[int, int]
# The shown depth has been through half floats; as of the veil, see effects/transparency.py.
NEARER = 1 + 2.0**-10
# An eye that is nearer than this to a panel's plane sees its edge, or its back.
EDGE_ON_M = 1e-6


@attrs.frozen(eq=False)
class HeldPanel:
    """A panel, and on the GPU the picture that it shows."""

    panel: Panel
    texture: moderngl.Texture


def panel_texture(gpu: Gpu, image: NDArray[np.uint8]) -> moderngl.Texture:
    """Return premultiplied linear light with mip levels, each of means of the one before."""
    alpha = image[..., 3:] / np.float32(255) if image.shape[2] == 4 else np.ones((*image.shape[:2], 1), np.float32)
    light = flip_rows(np.concatenate([linear_from_srgb(image[..., :3]) * alpha, alpha], axis=2).astype(np.float32))
    texture = allocate(gpu.gl, (light.shape[1], light.shape[0]), COLOUR)
    texture.build_mipmaps()
    for level in range(max(texture.size).bit_length()):
        light = _halved(_halved(light, 0), 1) if level else light
        texture.write(np.ascontiguousarray(light, np.float16), level=level, alignment=1)
    texture.filter = moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR
    return texture


def _halved(light: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Return the means of half as many equal parts along an axis, at least one."""
    count = light.shape[axis]
    half = max(1, count // 2)
    if count % half == 0:
        shape = (*light.shape[:axis], half, count // half, *light.shape[axis + 1 :])
        return np.asarray(light.reshape(shape).mean(axis=axis + 1), np.float32)
    sums = np.cumsum(light, axis=axis, dtype=np.float64)
    ends = np.arange(1, half + 1) * count / half
    last = np.ceil(ends).astype(int) - 1  # the texel in which each part ends, of which it has a share
    beyond = (last + 1 - ends).reshape([-1 if each == axis else 1 for each in range(light.ndim)])
    to_ends = sums.take(last, axis) - beyond * light.take(last, axis)
    return np.asarray(np.diff(to_ends, axis=axis, prepend=0) * half / count, np.float32)


@receiver_of("panels")
class KeptPanels(Store):
    """The panels of a scene as far as they have come; one shows the picture before until then."""

    def __init__(self, client: ClientScene, wanted: PanelDelivery) -> None:
        super().__init__(client, wanted)
        self._inbox, self._newest_ns = Inbox(), -1
        self._panels: list[tuple[Panel, int]] = []
        self._textures: dict[int, moderngl.Texture] = {}
        self._showing: list[int] = []
        self._held: dict[int, HeldPanel] = {}
        self._first_bytes: int | None = None  # that had come once all panels had a picture

    @property
    def held(self) -> Sequence[HeldPanel]:
        """Those that have a picture."""
        return tuple(self._held.values())

    def receive(self, content: NDArray[np.uint8]) -> None:
        try:
            self._take(content)
        except UNREADABLE as error:
            raise InputError(f"panels that cannot be read ({' '.join(str(error).split())})") from error

    def _take(self, content: NDArray[np.uint8]) -> None:
        time_ns, showing, update = showing_in(content)
        for number, thing in self._inbox.take(update):
            if number:
                self._textures[number] = self.own(panel_texture(self.client.gpu, picture_in(thing)))
            else:
                self._panels = places_in(thing)
        if time_ns >= self._newest_ns:
            self._newest_ns, self._showing = time_ns, showing
        first = 1
        for index, ((panel, count), shown) in enumerate(zip(self._panels, self._showing, strict=False)):
            if texture := self._textures.get(first + shown):
                self._held[index] = HeldPanel(panel, texture)
            first += count
        if self._first_bytes is None and 0 < len(self._panels) == len(self._held):
            self._first_bytes = self._inbox.bytes

    def weights(self) -> list[dict[str, Any]]:
        """Return what has come, and the room that the pictures take, with their mip levels."""
        room = sum(texture_bytes(texture) * 4 // 3 for texture in self._textures.values())
        come = {"start_up_bytes": 0, "first_picture_bytes": self._first_bytes, "arrived_bytes": self._inbox.bytes}
        return [{"geometry_bytes": room, "texture_bytes": 0, **come, "panels": len(self._held)}]


def panel_from_shown(panel: Panel, view: View, size: Size) -> Array | None:
    """Return M, (3, 3): M (x, y, 1) of a shown pixel is (u w, v w, w), w the inverse depth in 1/m.

    u, v: 0 to 1 on the panel, from its bottom left. None where the eye does not see its front.
    """
    placed = panel.eye_from_panel(view)
    right, up, normal = placed.rotation_matrix.T
    facing = float(normal @ placed.position_m)
    if facing > -EDGE_ON_M:
        return None
    inverse_depth = normal / facing  # of a ray (x, y, -1)
    of_ray = [
        axis / length + (0.5 - placed.position_m @ axis / length) * inverse_depth
        for axis, length in zip((right, up), panel.size_m, strict=True)
    ]
    left, rightmost, down, top = view.fov.tangents
    ray = [[(rightmost - left) / size[0], 0, left], [0, (top - down) / size[1], down], [0, 0, -1]]
    return np.array([*of_ray, inverse_depth]) @ np.array(ray)


def box_of(maps: Sequence[Array], size: Size) -> tuple[int, int, int, int] | None:
    """Return first pixel and the one past the last that may show the panel; None for none."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for each in maps:
        # Of the corners, homogeneous pixels; the scale of M makes the third the depth.
        corners = np.array([(u, v, 1.0) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))]) @ np.linalg.inv(each).T
        places = _before_the_eye(corners)
        if len(places):
            pixels = places[:, :2] / places[:, 2:]
            low, high = np.minimum(low, pixels.min(axis=0)), np.maximum(high, pixels.max(axis=0))
    first = np.maximum(np.floor(np.clip(low, -1, 1e9)) - 1, 0).astype(int)
    end = np.minimum(np.ceil(np.clip(high, -1, 1e9)) + 1, size).astype(int)
    return (int(first[0]), int(first[1]), int(end[0]), int(end[1])) if (first < end).all() else None


def _before_the_eye(corners: Array) -> Array:
    """Return the part of a polygon of homogeneous pixels with a depth above 0."""
    least = 1e-6 * max(float(corners[:, 2].max()), 0.0)
    kept = []
    for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if here[2] > least:
            kept.append(here)
        if (here[2] > least) != (there[2] > least):
            kept.append(here + (there - here) * ((least - here[2]) / (there[2] - here[2])))
    return np.array([place for place in kept if place[2] > 0]).reshape(-1, 3)


def held_panels(inputs: PassInputs, client: ClientScene | None) -> Sequence[HeldPanel]:
    """Return the panels of a frame, the farthest first. client: who keeps what frames bring."""
    data = inputs.rendered.get("panels")
    if data is None:
        raise PlanError("panels are laid over the picture, but this frame has none; frames from a scene have them")
    if isinstance(data, Mapping):
        assert client is not None, "a plan that reads what arrives is for a client that keeps it"
        data = [held for wanted in data for held in client.store(KeptPanels, wanted).held]
    return sorted(data, key=lambda one: -one.panel.away_m(inputs.middle))


class PanelsPass(ShownPass):
    """Lay the panels over the shown picture, the farthest first; each pays for what it covers.

    Where the warp looks through the lens, they do too, over the display's picture.
    """

    name = "panels"
    reads = ("shown.colour", "shown.inverse_depth", "rendered.panels")

    @classmethod
    def reads_for(cls, parts: frozenset[str]) -> tuple[str, ...]:
        return cls.reads if "occluded_panels" in parts else ("shown.colour", "rendered.panels")

    def prepare(self) -> None:
        compute, lens = self.gpu.shaders.compute, self.tools.lens
        self._programs: dict[bool, Compute] = {}
        if lens is not None:
            self._programs[False] = compute("effects/panel_lens.comp", LENS=lens.library, **lens.library_defines())
            return
        self._programs[False] = compute("effects/panel.comp")
        if "occluded_panels" in self.parts:
            self._programs[True] = compute("effects/panel.comp", OCCLUDED=1)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        into.copy_from(picture.colour)
        for held, maps in self._seen(inputs):
            if box := box_of(maps, into.size):
                program = self._bound(held, maps, into)
                program.uniforms.set(box=box, rows=into.size[1])
                if held.panel.occluded and True in self._programs:
                    picture.depth.bind_to_image(1, read=True, write=False)
                    program.uniforms.set(shown_inverse_depth=1, nearer=NEARER)
                program.run(box[2] - box[0], box[3] - box[1])
                self.gpu.barrier()

    def run_through_lens(self, inputs: PassInputs, panel: Canvas) -> None:
        assert self.tools.lens is not None
        for held, maps in self._seen(inputs):
            if box_of(maps, self.shown_size):
                program = self._bound(held, maps, panel)
                panel.bind_for_writing(1)
                lens = self.tools.lens.library_uniforms(inputs.shown.fov, inputs.eye)
                program.uniforms.set(written=1, panel_size=panel.size, shown_size=self.shown_size, **lens)
                program.run(*panel.size)
                self.gpu.barrier()

    def _seen(self, inputs: PassInputs) -> Iterator[tuple[HeldPanel, list[Array]]]:
        """Yield panels whose front is seen, the farthest first, with their maps.

        One map, or those of the first, middle and last instant of the scan-out.
        """
        views = [inputs.shown]
        if inputs.shown_last is not None:
            views = [inputs.shown, inputs.middle, attrs.evolve(inputs.shown, pose=inputs.shown_last.pose)]
        for held in held_panels(inputs, self.tools.geometry):
            if self.tools.hands_panels_on and not held.panel.occluded:
                continue
            found = [panel_from_shown(held.panel, view, self.shown_size) for view in views]
            maps = [each for each in found if each is not None]
            if len(maps) == len(views):
                yield held, maps

    def _bound(self, held: HeldPanel, maps: Sequence[Array], picture: Canvas) -> Compute:
        """Return the program of a panel, with all that both of its kinds read."""
        first, middle, last = maps if len(maps) == 3 else [maps[0]] * 3
        square = 2 * (first + last - 2 * middle)
        program = self._programs[held.panel.occluded and True in self._programs]
        picture.texture.bind_to_image(0, read=True, write=self.tools.lens is None)
        held.texture.use(0)
        by_time = {"at_first": first, "linear": last - first - square, "square": square}
        program.uniforms.set(picture=0, panel=0, panel_texels=held.texture.size, **by_time)
        return program


effects.declare(
    "panels", PanelsPass, Needs(panels=frozenset({PanelDelivery()})), in_scene=lambda scene: bool(scene.panels)
)

effects.declare(
    "occluded_panels",
    PanelsPass,
    Needs(panels=frozenset({PanelDelivery()})),
    in_scene=lambda scene: any(panel.occluded for panel in scene.panels),
)
