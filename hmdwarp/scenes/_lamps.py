"""Lamps that move, and the light atlas of the surfaces that they light."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from ._content import Motion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ._mesh import Mesh

MOST_LAMPS = 4
ATLAS = (64, 64)  # (w, h) texels of every scene's light atlas
NEAREST_M = 0.01  # a surface nearer than this to a lamp gets no more light


@attrs.frozen(eq=False)
class Lamp:
    """A light that may move: a point, or a sun.

    colour: linear RGB that a white, matt surface shows which faces it: 1 m away from a point, at
    any distance from a sun. A point shines from its motion's place, a sun from infinitely far along
    the -z of its motion's pose.
    """

    motion: Motion
    colour: tuple[float, float, float]
    is_sun: bool = False

    def place(self, time_ns: int) -> NDArray[np.float64]:
        """Return (x, y, z, 1) of a point in the world, or (x, y, z, 0) towards a sun."""
        pose = self.motion.state(time_ns).pose
        if self.is_sun:
            return np.append(pose.rotation.apply((0.0, 0.0, 1.0)), 0.0)
        return np.append(pose.position_m, 1.0)


def problem_with(meshes: Sequence[Mesh], lamps: Sequence[Lamp]) -> str:
    """Return why the lamps cannot light the meshes, "" if they can."""
    if len(lamps) > MOST_LAMPS:
        return f"{len(lamps)} lamps: expected at most {MOST_LAMPS}"
    for mesh in meshes:
        if mesh.light_uv is not None and mesh.deformation is not None:
            return f"mesh '{mesh.name}' has a place in the light atlas and deforms: expected one that is rigid"
        if lamps and mesh.material.reflectivity:
            return f"mesh '{mesh.name}' mirrors: in a scene with lamps, expected matt surfaces"
    return ""
