"""What a mesh may have beyond static, opaque, matt triangles: a material, a body, a deformation."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..geometry import RigidState

NO_TINT = (1.0, 1.0, 1.0)


def _rgb(value: Iterable[float]) -> tuple[float, ...]:
    return tuple(map(float, value))


@attrs.frozen
class Material:
    """Surface properties besides baked light.

    Errors: SceneError for shares outside 0..1 and for contradictions.
    """

    # Share of the light mirrored at normal incidence, 0 for matt. It rises to 1 at grazing angles
    # (Schlick 1994).
    reflectivity: float = 0.0
    # A mirror that is not a plane.
    curved: bool = False
    # Index of a linear texture of tangent-space normals that disturb the reflection, -1 for none.
    normal_map: int = -1
    # Factor on the x and y of the normals, as glTF's normalTexture.scale.
    normal_scale: float = 1.0
    # Covers what lies behind by opacity times the texture's alpha.
    see_through: bool = False
    opacity: float = 1.0
    # Fixed to the head: positions in metres from between the eyes, in head axes. Both eyes see it;
    # it is drawn over everything by its opacity and never warped.
    head_locked: bool = False
    # Share of the light that passes where a see-through surface covers, coloured by its texture and
    # the mesh's albedo as by coloured glass; the rest is scattered or stopped.
    transmission: float = 0.0
    # Share of each linear colour that passes where a see-through surface does not cover.
    tint: tuple[float, ...] = attrs.field(default=NO_TINT, converter=_rgb)

    def __attrs_post_init__(self) -> None:
        for name in ("reflectivity", "opacity", "transmission"):
            if not 0 <= getattr(self, name) <= 1:
                raise SceneError(f"material with {name} {getattr(self, name):g}: expected 0 to 1")
        if not self.reflectivity and (self.curved or self.normal_map >= 0):
            raise SceneError(
                "material with a normal map or a curved mirror, but reflectivity 0: set a reflectivity or remove them"
            )
        if len(self.tint) != 3 or not all(0 <= share <= 1 for share in self.tint):
            raise SceneError(f"material with tint {self.tint}: expected three shares, each 0 to 1")
        if (self.tint != NO_TINT or self.transmission) and not self.see_through:
            raise SceneError(
                "material with a tint or transmission but no light passing through: make it see_through or omit them"
            )
        if self.see_through and self.head_locked:
            raise SceneError("material both see-through and head-locked: head-locked surfaces already use the opacity")
        if self.reflectivity and (self.see_through or self.head_locked):
            raise SceneError("material that mirrors and is see-through or head-locked: expected one of these")


class Motion(Protocol):
    """Motion of a rigid body: a pure function of the scene's clock."""

    def state(self, time_ns: int) -> RigidState:
        """Return the pose and its derivatives at `time_ns`."""


@attrs.frozen(eq=False)
class Body:
    """A rigid body; meshes belong to it by number."""

    name: str
    motion: Motion


class Deformation(Protocol):
    """Motion of each vertex of one mesh, such as a flag: a pure function of the scene's clock."""

    def positions(self, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 3) metres relative to the scene's origin."""

    def velocities(self, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 3) m/s in world axes."""
