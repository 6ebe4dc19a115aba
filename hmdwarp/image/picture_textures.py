"""A caller's picture, and further layers of it, as textures: of arrays, or of textures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..client.effects.text import HeldPanel, panel_texture
from ..colour import linear_from_srgb
from ..errors import InputError, in_brief
from ..frames import BodyIds, Needs
from ..frames.layers import layers
from ..geometry import DepthLayer, RigidState
from ..geometry.depth import HALF_STEP
from ..gpu import Gpu
from ..gpu.textures import COLOUR, NUMBER, SCALAR, Owner, allocate, release_all, upload
from ..scenes import Panel, Texture
from ..sources.array_passes import LINEAR, SRGB
from .picture_arrays import ENCODINGS, is_one_of

Size = tuple[int, int]
Array = NDArray[Any]
INVERSE, METRES = "inverse", "metres"
_FORMS = {INVERSE: 0, METRES: 1}
_OF_BUFFER = 2
_MOST = 3.4028234e38  # of a float32
Pair = tuple[moderngl.Texture, moderngl.Texture]


class HeldPicture(Owner):
    """Colour and inverse depth of one picture, and with a repair how sure the depth is."""

    def __init__(self, gpu: Gpu, size: tuple[int, int], has_confidence: bool) -> None:
        self.pair = self.own(allocate(gpu.gl, size, COLOUR)), self.own(allocate(gpu.gl, size, SCALAR))
        # rgba16f: confidence in red, coverage in alpha; for a Warper with a repair.
        self.sure: Any = self.own(allocate(gpu.gl, size, COLOUR) if has_confidence else None)

    def hold_confidence(self, confidence: NDArray[np.float32]) -> None:
        nothing = np.zeros_like(confidence)
        upload(self.sure, np.stack([confidence, nothing, nothing, confidence > 0], axis=2))


def converted(
    gpu: Gpu,
    size: Size,
    colour: moderngl.Texture,
    depth: moderngl.Texture,
    depth_as: str | DepthLayer,
    encoding: str,
    into: Pair,
) -> Pair:
    """Return rgba16f linear light with coverage, and r32f inverse depth.

    The textures themselves where they are that; else `into`, written by a pass. depth_as,
    encoding: as Warper.warp_textures. Errors: InputError.
    """
    for name, texture in (("colour", colour), ("depth", depth)):
        if not isinstance(texture, moderngl.Texture):
            raise InputError(
                f"{name} is a {type(texture).__name__}: expected a moderngl.Texture; for an OpenGL id take "
                "gpu.gl.external_texture(id, size, components, 0, dtype)"
            )
        if texture.size != size:
            wide, high = size
            raise InputError(f"{name} is {texture.width}x{texture.height} pixels: this Warper is for {wide}x{high}")
    if colour.components != 4:
        raise InputError(f"colour has {colour.components} components: expected 4, with coverage in alpha")
    if depth_as is None or not (isinstance(depth_as, DepthLayer) or is_one_of(depth_as, _FORMS)):
        raise InputError(f"depth_as is {in_brief(depth_as)}: expected {', '.join(_FORMS)} or a hmdwarp.DepthLayer")
    if encoding is None or not is_one_of(encoding, ENCODINGS):
        raise InputError(f"encoding is {in_brief(encoding)}: expected {' or '.join(ENCODINGS)}")
    kinds = [(picture.components, picture.dtype) for picture in (colour, depth)]
    if kinds == [COLOUR, SCALAR] and depth_as == INVERSE and encoding == LINEAR:
        return colour, depth
    form = _OF_BUFFER if isinstance(depth_as, DepthLayer) else _FORMS[depth_as]
    program = gpu.shaders.compute("image/given.comp", ENCODED=int(encoding == SRGB), DEPTH=form)
    colour.use(0)
    depth.use(1)
    into[0].bind_to_image(0, read=False, write=True)
    into[1].bind_to_image(1, read=False, write=True)
    program.uniforms.set(given_colour=0, given_depth=1, colour=0, inverse_depth=1, rendered_size=size)
    if isinstance(depth_as, DepthLayer):
        span = depth_as.max_depth - depth_as.min_depth
        near, far = 1 / depth_as.near_z, 1 / depth_as.far_z
        program.uniforms.set(low=depth_as.min_depth, high=depth_as.max_depth, slack=min(HALF_STEP, 0.01 * span))
        program.uniforms.set(at_least=min(near, _MOST), per_value=(far - near) / span)
    program.run(*size)
    gpu.barrier()
    return into


_MOST_BODIES = np.iinfo(np.uint16).max  # numbers on the GPU have 16 bits


class _HeldLayer:
    """One layer's texture; of panels, those of their pictures."""

    def __init__(self, gpu: Gpu, name: str, kind: Kind, size: Size) -> None:
        self.gpu, self.name, self.size, self.kind = gpu, name, size, kind
        self.texture = allocate(gpu.gl, size, kind.texel)
        self.panels: dict[Texture, moderngl.Texture] = {}

    def array(self, what: str, value: ArrayLike, channels: int | None) -> Array:
        """Return finite numbers of the layer's size. Errors: InputError."""
        found, (wide, high) = np.asarray(value), self.size
        shape = (high, wide) if channels is None else (high, wide, channels)
        named = f"{what}layer '{self.name}'"
        if found.shape != shape or found.dtype.kind not in "fiu":
            raise InputError(f"{named} is {found.dtype} {found.shape}: expected numbers of shape {shape}")
        if not np.isfinite(found).all():
            raise InputError(f"{named} has NaN or infinite values: expected finite numbers")
        return found

    def parts(self, value: Any, count: int) -> tuple[Any, ...]:
        """Return so many parts of a tuple. Errors: InputError."""
        if not isinstance(value, list | tuple) or len(value) != count:
            raise InputError(f"layer '{self.name}' is a {type(value).__name__}: expected {self.kind.expected}")
        return tuple(value)

    def close(self) -> None:
        """Free the textures."""
        release_all(self.texture, *self.panels.values())


def _velocity(layer: _HeldLayer, value: Any) -> moderngl.Texture:
    velocity = layer.array("", value, 3)
    moves = (velocity != 0).any(axis=2, keepdims=True)
    upload(layer.texture, np.concatenate([velocity, moves], axis=2).astype(np.float32))
    return layer.texture


def _ids(layer: _HeldLayer, value: Any) -> BodyIds:
    numbers, bodies = layer.parts(value, 2)
    numbers, bodies = layer.array("numbers of ", numbers, None), tuple(bodies)
    if not all(isinstance(body, RigidState) for body in bodies):
        raise InputError("bodies of layer 'ids': expected a hmdwarp.geometry.RigidState for each")
    if len(bodies) > _MOST_BODIES:
        raise InputError(f"layer 'ids' has {len(bodies)} bodies: expected {_MOST_BODIES} at most")
    if numbers.dtype.kind == "f" or numbers.min() < 0 or numbers.max() > len(bodies):
        raise InputError(
            f"numbers of layer 'ids' are {numbers.dtype}, {numbers.min()} to {numbers.max()}: expected whole "
            f"numbers of 0 to {len(bodies)}, as there are {len(bodies)} bodies"
        )
    upload(layer.texture, numbers.astype(np.uint16))
    return BodyIds(layer.texture, bodies)


def _overlay(layer: _HeldLayer, value: Any) -> moderngl.Texture:
    pixels = layer.array("", value, 4)
    is_bytes = pixels.dtype == np.uint8
    light = linear_from_srgb(pixels[..., :3]) if is_bytes else pixels[..., :3]
    alpha = pixels[..., 3:] / (255 if is_bytes else 1)
    if alpha.min() < 0 or alpha.max() > 1:
        raise InputError(f"alpha of layer 'overlay' is {alpha.min():g} to {alpha.max():g}: expected 0 to 1")
    upload(layer.texture, np.concatenate([light * alpha, alpha], axis=2).astype(np.float32))
    return layer.texture


def _panels(layer: _HeldLayer, value: Any) -> tuple[HeldPanel, ...]:
    """Take panels over; pictures that those of the call before had too stay where they are."""
    panels = layer.parts(value, len(value) if isinstance(value, list | tuple) else 0)
    if not all(isinstance(panel, Panel) for panel in panels):
        raise InputError(f"layer 'panels': expected {layer.kind.expected}")
    pictures, before = {panel.pictures[0] for panel in panels}, layer.panels
    layer.panels = {picture: before.pop(picture) for picture in pictures if picture in before}
    for picture in pictures - layer.panels.keys():
        layer.panels[picture] = panel_texture(layer.gpu, picture.image)
    release_all(*before.values())
    return tuple(HeldPanel(panel, layer.panels[panel.pictures[0]]) for panel in panels)


@attrs.frozen
class Kind:
    """A layer that a caller can pass."""

    hold: Callable[[_HeldLayer, Any], Any]  # takes arrays over, and returns what passes read; Errors: InputError
    expected: str  # what the caller passes, in words
    texel: tuple[int, str] = COLOUR
    is_shown: bool = False  # whether it has the size of the result instead of the picture's
    is_optional: bool = False  # whether a picture may lack it: it is empty then


KNOWN = {
    "velocity": Kind(_velocity, "(h, w, 3) m/s along the eye's axes, 0 for what stands still"),
    "ids": Kind(
        _ids,
        "(numbers, bodies): (h, w) whole numbers, 0 for what stands still, n for bodies[n - 1], each a RigidState",
        NUMBER,
    ),
    "overlay": Kind(
        _overlay,
        "(h, w, 4) of the result's size, uint8 sRGB or float linear light, alpha its share of the pixel",
        is_shown=True,
    ),
    "panels": Kind(_panels, "[hmdwarp.Panel(picture, pose, size_m), ..]", is_optional=True),
}


class CallerLayers(Owner):
    """The layers that a plan reads and a caller can pass."""

    def __init__(self, gpu: Gpu, needs: Needs, rendered_size: Size, shown_size: Size) -> None:
        self._held = {
            name: self.own(_HeldLayer(gpu, name, kind, shown_size if kind.is_shown else rendered_size))
            for name, kind in KNOWN.items()
            if name in needs
        }

    def check(self, passed: Mapping[str, Any], who: str) -> None:
        """Check that the layers passed are those that are read. Errors: InputError."""
        if not isinstance(passed, Mapping):
            raise InputError(f"layers is of type {type(passed).__name__}: expected a dict of arrays by name")
        for name in passed:
            if name not in KNOWN:
                why = "is unknown"
                if name in layers.names():
                    why = f"({layers.get(name).summary}) comes from a server or the feed alone"
                raise InputError(f"layer '{name}' {why}: expected {', '.join(KNOWN)}")
            if name not in self._held:
                raise InputError(f"layer '{name}': {who} does not read it; leave it out, or name an effect that does")
        for name, held in self._held.items():
            if name not in passed and not held.kind.is_optional:
                raise InputError(f"{who} reads layer '{name}': give layers={{'{name}': ..}}, {held.kind.expected}")

    def hold(self, passed: Mapping[str, Any]) -> dict[str, Any]:
        """Return what passes read, by name. Errors: InputError."""
        return {name: held.kind.hold(held, passed.get(name, ())) for name, held in self._held.items()}
