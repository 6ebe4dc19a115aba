"""Further layers of a caller's picture: arrays, checked, and held on the GPU."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..client.effects import effects as every_effect
from ..client.effects.text import HeldPanel, panel_texture
from ..colour import linear_from_srgb
from ..errors import InputError
from ..frames import Needs, Surface
from ..frames.layers import layers
from ..frames.layers.pictures import BodyIds, Reflection, Reflections, Transparent
from ..geometry import Mirror, RigidState
from ..gpu.context import Gpu
from ..gpu.textures import COLOUR, NUMBER, SCALAR, allocate, release_all, upload
from ..scenes import Panel, Scene, Texture
from .picture_arrays import NO_DEPTH, PictureArrays, checked_picture
from .usable import LAYERS

Size = tuple[int, int]
Array = NDArray[Any]
_MOST_BODIES = np.iinfo(np.uint16).max  # numbers on the GPU have 16 bits


class HeldLayer(ABC):
    """One layer's textures."""

    # What the caller passes, in words.
    expected: ClassVar[str]
    # Its textures; of a layer with an amount, those of one.
    kinds: ClassVar[tuple[tuple[int, str], ...]] = (COLOUR,)
    has_amount: ClassVar[bool] = False
    # Whether it has the size of the result instead of the picture's.
    is_shown: ClassVar[bool] = False
    # Whether a picture may lack it: it is empty then.
    is_optional: ClassVar[bool] = False

    def __init__(self, gpu: Gpu, size: Size, amount: Any) -> None:
        self._size, self._amount = size, amount if self.has_amount else 1
        self.textures = [allocate(gpu.gl, size, kind) for kind in self.kinds * self._amount]

    @abstractmethod
    def hold(self, value: Any) -> Any:
        """Take arrays over, and return what passes read. Errors: InputError."""

    def array(self, name: str, value: ArrayLike, channels: int | None) -> Array:
        """Return finite numbers of the layer's size. Errors: InputError."""
        found, (wide, high) = np.asarray(value), self._size
        shape = (high, wide) if channels is None else (high, wide, channels)
        if found.shape != shape or found.dtype.kind not in "fiu":
            raise InputError(f"{name} is {found.dtype} {found.shape}: expected numbers of shape {shape}")
        if not np.isfinite(found).all():
            raise InputError(f"{name} has NaN or infinite values: expected finite numbers")
        return found

    def share(self, name: str, value: Array) -> Array:
        """Return numbers of 0 to 1. Errors: InputError."""
        if value.min() < 0 or value.max() > 1:
            raise InputError(f"{name} is {value.min():g} to {value.max():g}: expected 0 to 1")
        return value

    def picture(self, name: str, colour: ArrayLike, depth_m: ArrayLike) -> PictureArrays:
        """Return colour and depth of the layer's size, as a picture. Errors: InputError."""
        found = checked_picture(colour, depth_m)
        if found.size != self._size:
            raise InputError(f"{name} is {found.size[0]}x{found.size[1]} pixels: expected those of the picture")
        return found

    def parts(self, name: str, value: Any, count: int) -> tuple[Any, ...]:
        """Return so many parts of a tuple. Errors: InputError."""
        if not isinstance(value, list | tuple) or len(value) != count:
            raise InputError(f"layer '{name}' is a {type(value).__name__}: expected {self.expected}")
        return tuple(value)

    def close(self) -> None:
        """Free the textures."""
        release_all(*self.textures)


class _Velocity(HeldLayer):
    expected = "(h, w, 3) m/s along the eye's axes, 0 for what stands still"

    def hold(self, value: Any) -> moderngl.Texture:
        velocity = self.array("layer 'velocity'", value, 3)
        moves = (velocity != 0).any(axis=2, keepdims=True)
        upload(self.textures[0], np.concatenate([velocity, moves], axis=2).astype(np.float32))
        return self.textures[0]


class _Ids(HeldLayer):
    expected = (
        "(numbers, bodies): (h, w) whole numbers, 0 for what stands still, n for bodies[n - 1], each a RigidState"
    )
    kinds = (NUMBER,)

    def hold(self, value: Any) -> BodyIds:
        numbers, bodies = self.parts("ids", value, 2)
        numbers, bodies = self.array("numbers of layer 'ids'", numbers, None), tuple(bodies)
        if not all(isinstance(body, RigidState) for body in bodies):
            raise InputError("bodies of layer 'ids': expected a hmdwarp.geometry.RigidState for each")
        if len(bodies) > _MOST_BODIES:
            raise InputError(f"layer 'ids' has {len(bodies)} bodies: expected {_MOST_BODIES} at most")
        if numbers.dtype.kind == "f" or numbers.min() < 0 or numbers.max() > len(bodies):
            raise InputError(
                f"numbers of layer 'ids' are {numbers.dtype}, {numbers.min()} to {numbers.max()}: expected whole "
                f"numbers of 0 to {len(bodies)}, as there are {len(bodies)} bodies"
            )
        upload(self.textures[0], numbers.astype(np.uint16))
        return BodyIds(self.textures[0], bodies)


class _Overlay(HeldLayer):
    expected = "(h, w, 4) of the result's size, uint8 sRGB or float linear light, alpha its share of the pixel"
    is_shown = True

    def hold(self, value: Any) -> moderngl.Texture:
        pixels = self.array("layer 'overlay'", value, 4)
        is_bytes = pixels.dtype == np.uint8
        light = linear_from_srgb(pixels[..., :3]) if is_bytes else pixels[..., :3]
        alpha = self.share("alpha of layer 'overlay'", pixels[..., 3:] / (255 if is_bytes else 1))
        upload(self.textures[0], np.concatenate([light * alpha, alpha], axis=2).astype(np.float32))
        return self.textures[0]


class _Peeled(HeldLayer):
    expected = "[(colour, depth_m), ..]: the surfaces behind the picture, nearest first, as colour and depth_m"
    kinds = (COLOUR, SCALAR)
    has_amount = True

    def hold(self, value: Any) -> tuple[Surface, ...]:
        passed = self.parts("peeled", value, self._amount)
        for number, one in enumerate(passed):
            picture = self.picture(f"surface {number} of layer 'peeled'", *self.parts("peeled", one, 2))
            for texture, array in zip(self.textures[2 * number :], picture.arrays(), strict=False):
                upload(texture, array)
        return tuple(map(Surface, self.textures[::2], self.textures[1::2]))


class _Transparent(HeldLayer):
    expected = (
        "(light, depth_m, passing): (h, w, 3) linear light that it adds, (h, w) metres with 0 where there is none, and "
        "(h, w, 3) the share of the light behind that passes"
    )
    kinds = (COLOUR, SCALAR, COLOUR)

    def hold(self, value: Any) -> Transparent:
        light, depth_m, passing = self.parts("transparent", value, 3)
        light = self.array("light of layer 'transparent'", light, 3)
        depth = self.array("depth_m of layer 'transparent'", depth_m, None)
        there = depth > 0
        passing = np.where(there[..., None], self.array("passing of layer 'transparent'", passing, 3), 1)
        self.share("passing of layer 'transparent'", passing)
        if depth.min() < 0 or light.min() < 0:
            raise InputError(
                f"light of layer 'transparent' is {light.min():g} at least, depth_m {depth.min():g}: expected none "
                "below 0"
            )
        with np.errstate(divide="ignore"):
            inverse = np.where(there, 1 / depth, NO_DEPTH)
        covered = there[..., None].astype(np.float32)
        added, through = (np.concatenate([light_of, covered], axis=2) for light_of in (light * covered, passing))
        for texture, array in zip(self.textures, (added, inverse, through), strict=True):
            upload(texture, array.astype(np.float32))
        return Transparent(Surface(*self.textures[:2]), self.textures[2])


class _Reflection(HeldLayer):
    expected = (
        "(colour, depth_m, surface, mirrors): the mirrored world as colour and depth_m, along the whole path of the "
        "light, (h, w, 3) reflectivity straight on with 0 where nothing mirrors and the normal's share along right and "
        "up of the mirror, and a hmdwarp.geometry.Mirror each"
    )
    kinds = (COLOUR, SCALAR, COLOUR)

    def hold(self, value: Any) -> Reflection:
        colour, depth_m, surface, mirrors = self.parts("reflection", value, 4)
        picture = self.picture("what layer 'reflection' mirrors", colour, depth_m)
        surface = self.array("surface of layer 'reflection'", surface, 3)
        self.share("reflectivity in the surface of layer 'reflection'", surface[..., 0])
        mirrors = tuple(mirrors)
        if not mirrors or not all(isinstance(mirror, Mirror) for mirror in mirrors):
            raise InputError("mirrors of layer 'reflection': expected one hmdwarp.geometry.Mirror or more")
        surface = np.concatenate([surface, np.ones_like(surface[..., :1])], axis=2)  # it covers all of the picture
        pictures = (*picture.arrays(), surface.astype(np.float32))
        found = Reflection(Surface(*self.textures[:2]), self.textures[2], mirrors)
        if wrong := Reflections.misfit(pictures, Reflections.numbers(found)):
            raise InputError(f"layer 'reflection': {wrong}")
        for texture, array in zip(Reflections.textures(found), pictures, strict=True):
            upload(texture, array)
        return found


class _Panels(HeldLayer):
    expected = "[hmdwarp.Panel(picture, pose, size_m), ..]"
    kinds = ()
    is_optional = True

    def __init__(self, gpu: Gpu, size: Size, amount: Any) -> None:
        super().__init__(gpu, size, amount)
        self._gpu, self._sent = gpu, dict[Texture, moderngl.Texture]()

    def hold(self, value: Any) -> tuple[HeldPanel, ...]:
        """Take panels over; pictures that those of the call before had too stay where they are."""
        panels = self.parts("panels", value, len(value) if isinstance(value, list | tuple) else 0)
        if not all(isinstance(panel, Panel) for panel in panels):
            raise InputError(f"layer 'panels': expected {self.expected}")
        pictures, before = {panel.pictures[0] for panel in panels}, self._sent
        self._sent = {picture: before.pop(picture) for picture in pictures if picture in before}
        for picture in pictures - self._sent.keys():
            self._sent[picture] = panel_texture(self._gpu, picture.image)
        release_all(*before.values())
        return tuple(HeldPanel(panel, self._sent[panel.pictures[0]]) for panel in panels)

    def close(self) -> None:
        release_all(*self._sent.values())
        super().close()


_KINDS: tuple[type[HeldLayer], ...] = (_Velocity, _Ids, _Overlay, _Peeled, _Transparent, _Reflection, _Panels)
KNOWN = dict(zip(LAYERS, _KINDS, strict=True))


class CallerLayers:
    """The layers that a plan reads and a caller can pass."""

    def __init__(self, gpu: Gpu, needs: Needs, rendered_size: Size, shown_size: Size) -> None:
        self._held = {
            name: kind(gpu, shown_size if kind.is_shown else rendered_size, needs[name])
            for name, kind in KNOWN.items()
            if name in needs
        }

    def check(self, passed: Mapping[str, Any], who: str) -> None:
        """Check that the layers passed are those that are read. Errors: InputError."""
        for name in passed:
            if name not in KNOWN:
                why = "is unknown"
                if name in layers.names():
                    why = f"({layers.get(name).summary}) comes from a server of our own alone"
                raise InputError(f"layer '{name}' {why}: expected {', '.join(KNOWN)}")
            if name not in self._held:
                raise InputError(f"layer '{name}': {who} does not read it; leave it out, or name an effect that does")
        for name, held in self._held.items():
            if name not in passed and not held.is_optional:
                raise InputError(f"{who} reads layer '{name}': give layers={{'{name}': ..}}, {held.expected}")

    def hold(self, passed: Mapping[str, Any]) -> dict[str, Any]:
        """Return what passes read, by name. Errors: InputError."""
        return {name: held.hold(passed.get(name, ())) for name, held in self._held.items()}

    def close(self) -> None:
        """Free all textures."""
        for held in self._held.values():
            held.close()


def with_panels(passed: Mapping[str, Any], panels: Any) -> Mapping[str, Any]:
    """Return the layers with the panels of a call, if it has any."""
    if not isinstance(passed, Mapping):
        raise InputError(f"layers is of type {type(passed).__name__}: expected a dict of arrays by name, maybe empty")
    has_none = panels is None or (isinstance(panels, list | tuple) and not panels)
    return passed if has_none else {**passed, "panels": panels}


def with_panel_effects(effects: str, panels: Any) -> str:
    """Return the effects with those that lay the panels of a call over its picture."""
    if not isinstance(panels, list | tuple) or not all(isinstance(panel, Panel) for panel in panels):
        return effects
    called_for = every_effect.of(Scene("panels", "", (), panels=panels))
    return ",".join([*(effects.split(",") if effects != "none" else []), *called_for]) or effects
