"""Plain rooms with places in the light atlas, for tests of indirect light."""

from __future__ import annotations

import attrs
import numpy as np
from scipy.spatial.transform import Rotation

from hmdwarp.geometry import Pose, RigidState
from hmdwarp.scenes import Background, Body, Lamp, Pendulum, Scene, Waving
from hmdwarp.scenes.library._models import box, in_atlas, textures, wall

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


def moving_room() -> Scene:
    """A small room in which a lamp, a lit box and a flag move fast, each by itself."""
    walls = [
        wall((0, 0, 0), (2, 0, 0), (0, 0, -2), GREY, 1),
        wall((0, 2.6, 0), (2, 0, 0), (0, 0, 2), GREY),
        wall((0, 1.3, -2), (2, 0, 0), (0, 1.3, 0), (0.8, 0.7, 0.5)),
        wall((0, 1.3, 2), (-2, 0, 0), (0, 1.3, 0), GREY),
        wall((-2, 1.3, 0), (0, 0, -2), (0, 1.3, 0), (0.8, 0.2, 0.1)),
        wall((2, 1.3, 0), (0, 0, 2), (0, 1.3, 0), (0.1, 0.2, 0.8)),
    ]
    meshes = in_atlas([*walls, *box((-0.3, -0.3, -0.2), (0.3, 0.3, 0.2), GREY, 1)], 1.1)
    meshes = [attrs.evolve(mesh, body=int(number >= len(walls))) for number, mesh in enumerate(meshes)]
    flag = wall((0.55, 1.9, -1.3), (0.35, 0, 0), (0, 0.3, 0), GREY, 1).mesh("flag")
    flag = attrs.evolve(
        flag,
        deformation=Waving(
            flag.positions, flag.positions[:, 0] - 0.2, (0, 0.4, 1), height_m=0.5, period_s=0.7, lag=0.2
        ),
    )
    lamp = Lamp(Pendulum((0.2, 2.5, -0.4), 0.6, 0.9, 0.9), (1.6, 1.4, 1.2))
    swing = Body("box", Pendulum((-0.3, 3.2, -1.0), 1.9, 0.35, 0.8))
    bounds = ((-1.0, 0.8, -0.2), (1.0, 2.2, 1.2))
    return Scene("moving", "for tests", [*meshes, flag], textures(), DARK, [swing], walk_bounds_m=bounds, lamps=[lamp])
