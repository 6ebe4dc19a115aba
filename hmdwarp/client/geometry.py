"""What a client can draw by itself, because it has the scene's triangles, or some of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import moderngl

    from ..geometry import View


class ClientGeometry(Protocol):
    """Draws for any view and instant; programs and buffers are made when they are first asked for."""

    def draw_depth(self, view: View, size: tuple[int, int], into: moderngl.Texture, time_ns: int) -> object:
        """Inverse depth alone into an r32f texture, -1 where there is nothing."""
