"""Plain rooms with places in the light atlas, for tests of indirect light."""

from __future__ import annotations

from collections.abc import Iterable

import attrs
import numpy as np
from scipy.spatial.transform import Rotation

from hmdwarp.geometry import Pose, RigidState
from hmdwarp.scenes import ATLAS, Background, Body, Lamp, Pendulum, Quad, Scene, Waving, load_scene

BORDER = 1  # texels around each chart, so that light never blends with another's


def wall(centre: tuple, right: tuple, up: tuple, albedo: tuple, texture: int = 0) -> Quad:
    """Return a wall with half edges right and up, its texture 2 m wide."""
    sides = (float(np.linalg.norm(right)), float(np.linalg.norm(up)))
    return Quad(centre, right, up, texture, albedo, sides)


def box(low: tuple, high: tuple, albedo: tuple, texture: int = 0) -> list[Quad]:
    """Return the sides of a box and its top; it stands on the floor."""
    middle, half = (np.array(low) + high) / 2, (np.array(high) - low) / 2
    x, y, z = np.diag(half)
    outwards = ((x, -z, y), (-x, z, y), (z, x, y), (-z, -x, y), (y, x, -z))  # side, right, up
    return [wall(tuple(middle + side), tuple(right), tuple(up), albedo, texture) for side, right, up in outwards]


def in_atlas(quads: Iterable[Quad], texel_m: float) -> list:
    """Return the quads as meshes placed in the light atlas, tallest first; texel_m: about wide."""
    quads = list(quads)
    counts = [
        [max(1, round(2 * float(np.linalg.norm(half)) / texel_m)) for half in (quad.right, quad.up)] for quad in quads
    ]
    meshes: dict = {}
    column = row = tallest = 0
    for index in sorted(range(len(quads)), key=lambda i: -counts[i][1]):
        wide, high = counts[index]
        if column + wide + 2 * BORDER > ATLAS[0]:
            column, row, tallest = 0, row + tallest, 0
        low = np.array([column, row]) + BORDER
        corners = low + np.array([(0, 0), (wide, 0), (wide, high), (0, high)])
        meshes[index] = attrs.evolve(quads[index].mesh(f"surface-{index}"), light_uv=corners)
        column, tallest = column + wide + 2 * BORDER, max(tallest, high + 2 * BORDER)
    return [meshes[index] for index in range(len(quads))]


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
    textures = load_scene("lantern").textures
    return Scene("moving", "for tests", [*meshes, flag], textures, DARK, [swing], walk_bounds_m=bounds, lamps=[lamp])
