"""Draw Dear ImGui's output with moderngl: into a texture, then over the picture.

The bundle's own renderers are not used: the compiled one brings a second libGL that does not know
our context, and the Python one queries twenty states a frame through PyOpenGL.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator, Sequence
from typing import Protocol

import attrs
import moderngl
import numpy as np
from imgui_bundle import imgui

from ....gpu.context import drawing_into
from ....gpu.shaders import ShaderLibrary

CORNER = np.dtype([("position_px", "<f4", 2), ("ink_uv", "<f4", 2), ("tint", "u1", 4)])  # ImDrawVert
LEAST_BYTES = 1 << 18  # of each buffer: a full panel has some 8000 corners

# Over clear: the texture holds colours times alpha, so that it goes over a picture as the widgets
# themselves would have.
INTO_TEXTURE = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA)
OVER_PICTURE = (moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA)


class _Vector(Protocol):
    """One of Dear ImGui's vectors."""

    def size(self) -> int: ...

    def data_address(self) -> int: ...


@attrs.frozen(eq=False)
class _Painting:
    """The panel's picture, and the framebuffer that draws into it."""

    texture: moderngl.Texture
    framebuffer: moderngl.Framebuffer

    def release(self) -> None:
        self.framebuffer.release()
        self.texture.release()


@attrs.frozen
class Batch:
    """Triangles with one texture: `count` indices of the corners from `first` on."""

    texture: moderngl.Texture
    first: int
    count: int
    clip: tuple[float, float, float, float]  # left, top, right, bottom in pixels


class PanelRenderer:
    """Draw the panel: paint() renews its picture, put() composites it over a framebuffer.

    Both restore flags, blending and framebuffer as a pass expects them.
    """

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        draw = ShaderLibrary(gl).draw("display/panel.vert", "display/panel.frag")
        self._program, self._uniforms = draw.program, draw.uniforms
        self._corners = _Growing(gl)
        self._indices = _Growing(gl)
        self._array: moderngl.VertexArray | None = None
        self._atlases: dict[int, moderngl.Texture] = {}
        self._painting: _Painting | None = None

    @property
    def picture(self) -> moderngl.Texture | None:
        """The painted picture; None before the first."""
        return self._painting.texture if self._painting is not None else None

    # --- the picture ---

    def paint(self, data: imgui.ImDrawData, size: tuple[int, int]) -> int:
        """Draw into the texture `picture` of that size, (w, h) in pixels.

        Return the used rows from the top.
        """
        for texture in data.textures:
            self._renew(texture)
        corners, indices, batches = gathered(data, self._atlases)
        self.draw(corners, indices, batches, size)
        return min(math.ceil(corners["position_px"][:, 1].max()), size[1]) if len(corners) else 0

    def draw(self, corners: np.ndarray, indices: np.ndarray, batches: Sequence[Batch], size: tuple[int, int]) -> None:
        """Draw triangles into the texture. corners: CORNER; indices: uint32, three a triangle."""
        framebuffer = self._resize(size).framebuffer
        with drawing_into(framebuffer, moderngl.BLEND):
            _clip(framebuffer, None)
            framebuffer.clear()
            _blend(self._gl, INTO_TEXTURE)
            array = self._write(corners, indices)
            self._uniforms.set(panel_size=tuple(map(float, size)))
            for batch in batches:
                left, top, right, bottom = _inside(batch.clip, size)
                if right > left and bottom > top:
                    batch.texture.use()
                    _clip(framebuffer, (left, size[1] - bottom, right - left, bottom - top))
                    array.render(vertices=batch.count, first=batch.first)
            _clip(framebuffer, None)
            _blend(self._gl, moderngl.DEFAULT_BLENDING)

    def _resize(self, size: tuple[int, int]) -> _Painting:
        if self._painting is None or self._painting.texture.size != size:
            self._drop_picture()
            texture = self._gl.texture(size, 4)
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self._painting = _Painting(texture, self._gl.framebuffer([texture]))
        return self._painting

    def _write(self, corners: np.ndarray, indices: np.ndarray) -> moderngl.VertexArray:
        grown = self._corners.write(corners), self._indices.write(indices)
        if self._array is None or any(grown):
            if self._array is not None:
                self._array.release()
            layout = [(self._corners.buffer, "2f 2f 4f1", "position_px", "ink_uv", "tint")]
            self._array = self._gl.vertex_array(self._program, layout, self._indices.buffer, index_element_size=4)
        return self._array

    # --- over the picture ---

    def put(self, into: moderngl.Framebuffer, corner: tuple[int, int], size: tuple[int, int]) -> None:
        """Composite the top left part of the picture, of that size, over `into`.

        corner: (x, y) of its lower left pixel there.
        """
        if self.picture is None or min(size) < 1:
            return
        w, h = self.picture.size
        before = into.viewport
        with drawing_into(into, moderngl.BLEND):
            _blend(self._gl, OVER_PICTURE)
            # The whole texture's place, so that its pixels and the framebuffer's coincide; what
            # lies below the part is cut off.
            into.viewport = (corner[0], corner[1] - (h - size[1]), w, h)
            _clip(into, (*corner, *size))
            array = self._write(*_whole(w, h))
            self._uniforms.set(panel_size=(float(w), float(h)))
            self.picture.use()
            array.render(vertices=6)
            _clip(into, None)
            into.viewport = before
            _blend(self._gl, moderngl.DEFAULT_BLENDING)

    # --- the atlases of glyphs ---

    def _renew(self, texture: imgui.ImTextureData) -> None:
        """Create, update or drop our copy on request of Dear ImGui, which adds glyphs at first use.

        Since version 1.92.
        """
        if texture.status == imgui.ImTextureStatus.want_create:
            made = self._gl.texture((texture.width, texture.height), 4, _pixels(texture))
            self._atlases[made.glo] = made
            texture.set_tex_id(made.glo)
            texture.set_status(imgui.ImTextureStatus.ok)
        elif texture.status == imgui.ImTextureStatus.want_updates:
            box = texture.update_rect
            part = np.ascontiguousarray(_pixels(texture)[box.y : box.y + box.h, box.x : box.x + box.w])
            self._atlases[texture.tex_id].write(part, viewport=(box.x, box.y, box.w, box.h))
            texture.set_status(imgui.ImTextureStatus.ok)
        elif texture.status == imgui.ImTextureStatus.want_destroy:
            self._forget(texture)

    def _forget(self, texture: imgui.ImTextureData) -> None:
        ours = self._atlases.pop(texture.tex_id, None)
        if ours is not None:
            ours.release()
        texture.set_tex_id(0)
        texture.set_status(imgui.ImTextureStatus.destroyed)

    def _drop_picture(self) -> None:
        if self._painting is not None:
            self._painting.release()
        self._painting = None

    def close(self) -> None:
        """Free everything; Dear ImGui's context must still exist and be current."""
        for texture in imgui.get_platform_io().textures:
            if texture.tex_id in self._atlases:
                self._forget(texture)
        self._drop_picture()
        if self._array is not None:
            self._array.release()
        self._corners.close()
        self._indices.close()
        self._program.release()


class _Growing:
    """A buffer that is replaced by one of twice the size when data does not fit."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self.buffer = gl.buffer(reserve=LEAST_BYTES, dynamic=True)

    def write(self, values: np.ndarray) -> bool:
        """Write; return whether the buffer was replaced."""
        grows = values.nbytes > self.buffer.size
        if grows:
            self.buffer.release()
            self.buffer = self._gl.buffer(reserve=2 * values.nbytes, dynamic=True)
        else:
            self.buffer.orphan()
        if values.size:
            self.buffer.write(values)
        return grows

    def close(self) -> None:
        self.buffer.release()


def gathered(
    data: imgui.ImDrawData, atlases: dict[int, moderngl.Texture]
) -> tuple[np.ndarray, np.ndarray, list[Batch]]:
    """Return copies of all corners and indices of a frame, one array each, and their batches."""
    corners: list[np.ndarray] = []
    indices: list[np.ndarray] = []
    batches: list[Batch] = []
    first_corner = first_index = 0
    for drawn in data.cmd_lists:
        corners.append(_copied(drawn.vtx_buffer, CORNER))
        indices.append(_copied(drawn.idx_buffer, np.dtype("<u4")) + np.uint32(first_corner))
        batches += _batches(drawn, first_index, atlases)
        first_corner += len(corners[-1])
        first_index += len(indices[-1])
    if not corners:
        return np.empty(0, CORNER), np.empty(0, np.uint32), []
    return np.concatenate(corners), np.concatenate(indices), batches


def _batches(drawn: imgui.ImDrawList, first_index: int, atlases: dict[int, moderngl.Texture]) -> Iterator[Batch]:
    for command in drawn.cmd_buffer:
        texture = atlases.get(command.get_tex_id())
        if texture is not None and command.elem_count:
            clip = command.clip_rect
            yield Batch(texture, first_index + command.idx_offset, command.elem_count, (clip.x, clip.y, clip.z, clip.w))


def _copied(vector: _Vector, dtype: np.dtype) -> np.ndarray:
    """Copy the elements of one of Dear ImGui's vectors, valid only until its next frame."""
    count = vector.size()
    if not count:
        return np.empty(0, dtype)
    return np.frombuffer(ctypes.string_at(vector.data_address(), count * dtype.itemsize), dtype)


# moderngl's annotations list what these two return, not all that they accept.
def _clip(framebuffer: moderngl.Framebuffer, rectangle: tuple[int, int, int, int] | None) -> None:
    framebuffer.scissor = rectangle  # type: ignore[assignment]


def _blend(gl: moderngl.Context, factors: tuple[int, ...] | int) -> None:
    gl.blend_func = factors  # type: ignore[assignment]


def _pixels(texture: imgui.ImTextureData) -> np.ndarray:
    return texture.get_pixels_array().reshape(texture.height, texture.width, 4)


def _inside(clip: tuple[float, float, float, float], size: tuple[int, int]) -> tuple[int, int, int, int]:
    left, top, right, bottom = clip
    return max(int(left), 0), max(int(top), 0), min(int(right), size[0]), min(int(bottom), size[1])


def _whole(w: int, h: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the two triangles of the whole picture, white.

    v is flipped: row 0 of what was drawn is the bottom one.
    """
    corners = np.zeros(4, CORNER)
    corners["position_px"] = [(0, 0), (w, 0), (w, h), (0, h)]
    corners["ink_uv"] = [(0, 1), (1, 1), (1, 0), (0, 0)]
    corners["tint"] = 255
    return corners, np.array([0, 1, 2, 0, 2, 3], np.uint32)
