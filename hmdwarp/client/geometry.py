"""What a client can draw by itself, because it has the scene's triangles, or some of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import moderngl

    from ..geometry import View
    from .picture import ShownPicture


class ClientModel(Protocol):
    """A scene with fewer triangles, on the GPU. Draws into rgba16f colour, and r32f inverse depth where it is not None."""

    def reserve(self, size: tuple[int, int]) -> None:
        """Allocate now what pictures of that size need."""

    def draw(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """The whole picture; coverage 1 everywhere, sky included (inverse depth 0)."""

    def draw_holes(self, view: View, picture: ShownPicture, into: ShownPicture, time_ns: int) -> None:
        """Into the holes of `picture` alone; where it is covered its colour and inverse depth, unchanged."""


class ClientGeometry(Protocol):
    """Draws for any view and instant; programs and buffers are made when they are first asked for."""

    def draw_depth(self, view: View, size: tuple[int, int], into: moderngl.Texture, time_ns: int) -> object:
        """Inverse depth alone into an r32f texture, -1 where there is nothing."""

    def model(self, share: float, *, lit: bool) -> ClientModel:
        """What hides what is behind it, with about `share` of its triangles; light as baked, or light of 1 everywhere (albedo).

        The same one for the same share; it belongs to the geometry. Errors: SceneError for a share that is not above 0 and at most 1.
        """
