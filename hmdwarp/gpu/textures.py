"""The few kinds of textures in use, and the one place where picture rows flip.

Inside, row 0 is the bottom row, as GL has it; in files and in Python row 0 is the top row.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, TypeVar

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..base import InputError

T = TypeVar("T")
Images = Mapping[str, Any] | None  # textures or canvases by the uniform that names their unit
COLOUR = (4, "f2")  # rgba16f: linear light, coverage in alpha
SCALAR = (1, "f4")  # r32f: inverse depth
NUMBER = (1, "u2")  # r16ui: which body a pixel belongs to
_NUMPY = {"f1": np.uint8, "f2": np.float16, "f4": np.float32, "u2": np.uint16, "u4": np.uint32}  # by moderngl's name


def allocate(
    gl: moderngl.Context, size: tuple[int, int], kind: tuple[int, str], *, linear: bool = False
) -> moderngl.Texture:
    """Return an empty (w, h) texture, clamped at its edges. Errors: as check_size."""
    check_size(gl, size)
    texture = gl.texture(size, kind[0], dtype=kind[1])
    texture.repeat_x = texture.repeat_y = False
    texture.filter = (moderngl.LINEAR if linear else moderngl.NEAREST,) * 2
    return texture


def texture_bytes(texture: moderngl.Texture) -> int:
    """Return the bytes of its pixels."""
    return int(texture.width * texture.height * texture.components * int(texture.dtype[1:]))


class Canvas:
    """A colour texture (rgba16f) that passes write into, with the framebuffer that clears it.

    Clearing through a framebuffer is four times faster on llvmpipe than a shader that stores zeros.
    """

    def __init__(self, gl: moderngl.Context, size: tuple[int, int]) -> None:
        self.texture = allocate(gl, size, COLOUR, linear=True)
        self._framebuffer = gl.framebuffer([self.texture])
        self.size = size
        # Called with an image unit, binds as the image that a compute shader stores into.
        self.bind_for_writing = partial(self.texture.bind_to_image, read=False, write=True)

    def clear(self) -> None:
        """Set every pixel to (0, 0, 0, 0): nothing drawn."""
        self._framebuffer.clear()

    def copy_from(self, drawn: moderngl.Framebuffer | Canvas) -> None:
        """Copy the colours of a framebuffer or canvas of the same size, bit for bit."""
        source = drawn._framebuffer if isinstance(drawn, Canvas) else drawn
        self._framebuffer.ctx.copy_framebuffer(self._framebuffer, source)

    def release(self) -> None:
        self._framebuffer.release()
        self.texture.release()


def drawing_into(framebuffer: moderngl.Framebuffer, flags: int | None = None) -> moderngl.Scope:
    """Return a scope that draws into `framebuffer` with only these flags on; None: as they are.

    The same ones give the same scope, as a context keeps a part of each scope ever made.
    """
    if framebuffer.extra is None:
        framebuffer.extra = {}
    made: dict[int | None, moderngl.Scope] = framebuffer.extra
    if flags not in made:
        made[flags] = framebuffer.ctx.scope(framebuffer, flags)
    return made[flags]


def bind_images(
    read: Images = None, write: Images = None, change: Images = None, *, first: int = 0
) -> dict[str, object]:
    """Bind what a shader loads, stores, and both to image units; return the units by uniform."""
    units: dict[str, object] = {}
    for textures, loads, stores in ((read, True, False), (write, False, True), (change, True, True)):
        for name, texture in (textures or {}).items():
            units[name] = unit = first + len(units)
            chosen = texture.texture if isinstance(texture, Canvas) else texture
            chosen.bind_to_image(unit, read=loads, write=stores)
    return units


def release_all(*things: Any) -> None:
    """Release textures, buffers, framebuffers or vertex arrays, in this order."""
    for thing in things:
        thing.release()


class Owner:
    """Something that owns textures, buffers and other owners, and frees them all at once."""

    def own(self, thing: T) -> T:
        """Return a thing, or None, that close() frees: the newest first."""
        self.__dict__.setdefault("_owned", []).append(thing)
        return thing

    def close(self) -> None:
        """Free what it owns."""
        owned = self.__dict__.get("_owned", [])
        while owned:
            thing: Any = owned.pop()
            if thing is not None:
                (getattr(thing, "close", None) or thing.release)()


def tiles(size: tuple[int, int], side: int) -> tuple[int, int]:
    """Return how many square tiles of `side` pixels cover a (w, h) picture, across and down."""
    return -(-size[0] // side), -(-size[1] // side)


def check_size(gl: moderngl.Context, size: tuple[int, int]) -> None:
    """Raise InputError for a side below 1 or beyond the GL limit."""
    limit = gl.info["GL_MAX_TEXTURE_SIZE"]
    if min(size) < 1 or max(size) > limit:
        raise InputError(f"picture size {size[0]}x{size[1]}: expected 1 to {limit} on each side (this GPU's limit)")


def upload(texture: moderngl.Texture, image: NDArray[Any]) -> None:
    """Write a top-row-first (h, w[, c]) array into a texture; c = 3 gets alpha 1 (255 in bytes).

    Errors: InputError for another size or number of components.
    """
    height, width = image.shape[:2]
    if (width, height) != texture.size:
        raise InputError(f"picture is {width}x{height}, texture {texture.width}x{texture.height}")
    dtype = _NUMPY[texture.dtype]
    if image.ndim == 3 and image.shape[2] == 3 and texture.components == 4:
        opaque = 255 if dtype is np.uint8 else 1
        image = np.concatenate([image, np.full((height, width, 1), opaque, image.dtype)], axis=2)
    if image.shape[2:] != (texture.components,) and not (texture.components == 1 and image.ndim == 2):
        raise InputError(f"picture has shape {image.shape}, texture {texture.components} components")
    texture.write(np.ascontiguousarray(flip_rows(image), dtype=dtype), alignment=1)


def download(texture: moderngl.Texture) -> NDArray[Any]:
    """Return the texture as a top-row-first (h, w, c) or (h, w) array of its own type."""
    dtype = _NUMPY[texture.dtype]
    array = np.frombuffer(texture.read(alignment=1), dtype).reshape(texture.height, texture.width, texture.components)
    return flip_rows(array[..., 0] if texture.components == 1 else array)


def flip_rows(image: NDArray[Any]) -> NDArray[Any]:
    """Turn top row first into bottom row first, or back. No other module flips rows."""
    return image[::-1]


def flip_map(matrix: NDArray[np.float64], height: int) -> NDArray[np.float64]:
    """Return a (3, 3) map between pixels, of pictures so high, as flip_rows turns their rows."""
    turned = np.array([[1.0, 0, 0], [0, -1, height], [0, 0, 1]])
    return np.asarray(turned @ matrix @ turned)
