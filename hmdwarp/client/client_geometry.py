"""Interfaces for what a client with some of the scene's triangles can draw by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

    import moderngl
    import numpy as np
    from numpy.typing import NDArray

    from ..frames.layers.photons import PhotonMap
    from ..frames.layers.points import Cloud
    from ..frames.layers.scene_update import Delivery
    from ..frames.photon_bundles import Cube
    from ..geometry import View
    from ..gpu.shaders import Inputs
    from .shown_picture import ShownPicture


class ClientModel(Protocol):
    """A scene with fewer triangles and texels, on the GPU.

    It draws rgba16f colour, and r32f inverse depth if the target has one.
    """

    def reserve(self, size: tuple[int, int]) -> None:
        """Allocate what pictures of that size need."""

    def draw(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw the whole picture: coverage 1 everywhere, sky included (inverse depth 0)."""

    def draw_holes(self, view: View, picture: ShownPicture, into: ShownPicture, time_ns: int) -> None:
        """Draw into the holes of `picture`; elsewhere copy its colour and inverse depth."""


class DrawnScene(Protocol):
    """A scene that the client draws with all that is in it: mirrors, glass, overlays.

    It draws rgba16f colour and r32f inverse depth.
    """

    def draw(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw the whole picture."""


class PointCloud(Protocol):
    """Points that the client has got, in pages of 16, and the cells that they belong to."""

    # Three words a point; a cell's number for each page; two vec4 for each cell, see
    # warps/points.comp.
    points: moderngl.Buffer
    pages: moderngl.Buffer
    cells: moderngl.Buffer

    @property
    def count(self) -> int:
        """How many places for points there are to look at."""

    @property
    def sky(self) -> NDArray[np.float64] | None:
        """(3, 3) light of zenith, horizon and ground; None before the first whole picture."""

    def bodies(self, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 4, 4): world from the frame of what stands still, then of each body."""


class LitScene(Protocol):
    """A scene under its own lamps, with indirect light from elsewhere.

    It draws rgba16f colour and r32f inverse depth.
    """

    def draw(self, view: View, into: ShownPicture, time_ns: int, indirect: moderngl.Texture) -> None:
        """Draw the whole picture. indirect: the light atlas, rgba16f."""


class SoftBodies(Protocol):
    """What deforms in a scene, drawn without light into textures; -1 in all of them elsewhere."""

    def reserve(self, size: tuple[int, int]) -> None:
        """Allocate what pictures of that size need."""

    def draw(self, view: View, time_ns: int, into: Sequence[moderngl.Texture]) -> None:
        """Draw albedo (rgba16f) and inverse depth (r32f) at that instant."""

    def draw_with_past(
        self, view: View, time_ns: int, into: Sequence[moderngl.Texture], past: View, past_ns: int
    ) -> None:
        """Draw the same, and what tells where each place was for `past` at an earlier instant.

        into: albedo, inverse depth; colour in its baked light (rgba16f); the place then, in metres
        along the axes of the eye of `past` (rgba32f); the surface's normal there, away from the
        side that is seen now (rgba16f).
        """


class SplattedScene(Protocol):
    """A scene under its own lamps, on which photons are splatted.

    It draws rgba16f and r32f inverse depth.
    """

    def draw_receivers(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw what lamps light: the normal, and the factor for photons; 0 for what they do not."""

    def draw(self, view: View, into: ShownPicture, time_ns: int, splats: Inputs) -> None:
        """Draw the whole picture."""


class ReceivedPhotons(Protocol):
    """The newest photons of each bundle that a client has got, see warps/photons.vert."""

    photons: moderngl.Buffer
    count: int
    cube: Cube
    # The scene's origin.
    origin_m: NDArray[np.float64]

    @property
    def scene(self) -> SplattedScene:
        """Return the whole scene, that they light."""


class ClientGeometry(Protocol):
    """Draws for any view and instant; programs and buffers are made on first use."""

    @property
    def is_still(self) -> bool:
        """Whether the scene is known to look the same at all times and from everywhere."""

    def draw_depth(self, view: View, size: tuple[int, int], into: moderngl.Texture, time_ns: int) -> object:
        """Draw inverse depth alone into an r32f texture, -1 where nothing is."""

    def model(self, share: float, *, lit: bool, texture: float = 1.0) -> ClientModel:
        """Return a model with about `share` of the triangles, owned and cached by the geometry.

        lit: with baked light, else with light of 1 everywhere (albedo). texture: scale of the
        textures' resolution on both axes. Errors: SceneError for a share or scale that is not above
        0 and at most 1.
        """

    def scene(self, share: float, *, lit: bool, texture: float = 1.0) -> DrawnScene:
        """Return the scene with about `share` of the triangles of its plain surfaces.

        With a share and a texture scale of 1, lit, it is drawn as the server draws it, to the last
        bit. Parameters, errors: as of model().
        """

    def under_light(self) -> LitScene:
        """Return the whole scene, whose indirect light comes with each picture.

        Without lamps it is drawn by its baked light.
        """

    def soft_bodies(self) -> SoftBodies:
        """Return what deforms in the scene, owned and cached by the geometry."""

    def arriving(self, delivery: Delivery) -> DrawnScene:
        """Return the scene as it has arrived so far: all holes before anything can be drawn."""

    def points(self, cloud: Cloud) -> PointCloud:
        """Return the points that have arrived."""

    def photons(self, wanted: PhotonMap) -> ReceivedPhotons:
        """Return the photons that have arrived."""
