"""What a mesh may be besides static, opaque and matt: its material, the body it belongs to, how it deforms."""

from __future__ import annotations

from typing import Protocol

import attrs
from numpy.typing import NDArray

from ..errors import SceneError
from ..geometry import RigidState


@attrs.frozen
class Material:
    """What a surface does besides throwing back baked light.

    reflectivity: share of the light it mirrors when looked at straight on, 0 for matt; it rises to 1 at grazing angles (Schlick 1994).
    curved: a mirror that is no plane. normal_map: index of a linear texture of tangent-space normals that disturb the reflection, -1 for
    none; normal_scale: its x and y times this (as glTF's normalTexture.scale). see_through: drawn by its opacity times its texture's
    alpha over what lies behind, whose light passes the rest of it by `tint` (the share of each linear colour; coloured glass).
    head_locked: fixed to the head, positions in metres from between the eyes (head axes), seen by both eyes, drawn over everything by the
    same opacity and never warped.
    Errors: SceneError for shares outside 0..1 and for contradictions.
    """

    reflectivity: float = 0.0
    curved: bool = False
    normal_map: int = -1
    normal_scale: float = 1.0
    see_through: bool = False
    opacity: float = 1.0
    head_locked: bool = False
    tint: tuple[float, float, float] = attrs.field(
        default=(1.0, 1.0, 1.0), converter=lambda value: tuple(map(float, value))
    )

    def __attrs_post_init__(self) -> None:
        for name in ("reflectivity", "opacity"):
            if not 0 <= getattr(self, name) <= 1:
                raise SceneError(f"material with {name} {getattr(self, name):g}: wanted 0 to 1")
        if not self.reflectivity and (self.curved or self.normal_map >= 0):
            raise SceneError(
                "material with a normal map or a curved mirror, but reflectivity 0: give it a reflectivity or leave them out"
            )
        if len(self.tint) != 3 or not all(0 <= share <= 1 for share in self.tint):
            raise SceneError(f"material with tint {self.tint}: wanted three shares, each 0 to 1")
        if self.tint != (1.0, 1.0, 1.0) and not self.see_through:
            raise SceneError("material with a tint that nothing passes: make it see_through or leave the tint out")
        if self.see_through and self.head_locked:
            raise SceneError(
                "material that is see-through and head-locked: what is head-locked lets through by its opacity anyway"
            )
        if self.reflectivity and (self.see_through or self.head_locked):
            raise SceneError("material that mirrors and is see-through or head-locked: wanted one of these")


class Motion(Protocol):
    """How a rigid body moves: a pure function of the scene's clock."""

    def state(self, time_ns: int) -> RigidState:
        """Where it is then, and how it moves."""


@attrs.frozen(eq=False)
class Body:
    """Something that moves as a whole; meshes belong to it by number."""

    name: str
    motion: Motion


class Deformation(Protocol):
    """How the vertices of one mesh move by themselves (a flag, a skinned figure): a pure function of the scene's clock."""

    def positions(self, time_ns: int) -> NDArray:
        """(n, 3) metres relative to the scene's origin."""

    def velocities(self, time_ns: int) -> NDArray:
        """(n, 3) m/s in world axes."""
