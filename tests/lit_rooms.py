"""Plain rooms with places in the light atlas, for tests of indirect light."""

from __future__ import annotations

import attrs
import numpy as np
from scipy.spatial.transform import Rotation

from hmdwarp.geometry import Pose, RigidState
from hmdwarp.scenes import Background, Scene
from hmdwarp.scenes.library._models import in_atlas, wall

GREY = (0.6, 0.6, 0.6)
DARK = Background()


class Fixed:
    def __init__(self, place):
        self.place = place

    def state(self, time_ns):
        return RigidState(Pose(self.place))


def placed(scene: Scene, time_ns: int) -> Scene:
    """The scene as it is at an instant, of which nothing moves any more."""

    def there(mesh):
        if not mesh.body:
            return mesh
        pose = scene.bodies[mesh.body - 1].motion.state(time_ns).pose
        turn = Rotation.from_quat(pose.orientation_xyzw)
        positions = turn.apply(mesh.positions) + (pose.position_m - scene.origin_m)
        return attrs.evolve(mesh, positions=positions, normals=turn.apply(mesh.normals), body=0)

    return attrs.evolve(scene, meshes=map(there, scene.meshes), bodies=(), light_ns=time_ns)


def plain(scene: Scene) -> Scene:
    """The scene without textures, and without what lamps do not light."""
    meshes = [attrs.evolve(mesh, texture=-1) for mesh in scene.meshes if mesh.light_uv is not None]
    return attrs.evolve(scene, meshes=meshes)


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
