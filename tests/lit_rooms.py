"""Plain rooms with places in the light atlas, for tests of indirect light."""

from __future__ import annotations

import attrs
import numpy as np

from hmdwarp.geometry import Pose, RigidState
from hmdwarp.scenes import Background, Scene
from hmdwarp.scenes.library._lit_room import in_atlas, wall

GREY = (0.6, 0.6, 0.6)
DARK = Background()


class Fixed:
    def __init__(self, place):
        self.place = place

    def state(self, time_ns):
        return RigidState(Pose(self.place))


def scene_of(quads, texel_m: float, lamps=(), background=DARK) -> Scene:
    meshes = [attrs.evolve(mesh, texture=-1) for mesh in in_atlas(quads, texel_m)]
    return Scene("trial", "for tests", meshes, background=background, lamps=lamps)


def cube(albedo=GREY):
    """The inside of a cube of 2 m."""
    sides = (((1, 0, 0), (0, 0, -1), (0, 1, 0)), ((0, 1, 0), (1, 0, 0), (0, 0, 1)), ((0, 0, 1), (-1, 0, 0), (0, 1, 0)))
    quads = []
    for out, _, up in map(np.array, sides):
        for sign in (1, -1):
            across = -sign * np.cross(up, out)  # right x up points inwards
            quads.append(wall(tuple(sign * out), tuple(across), tuple(up), albedo))
    for quad in quads:
        assert quad.normal @ quad.centre < 0
    return quads
