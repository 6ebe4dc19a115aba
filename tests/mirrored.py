"""A small scene with every kind of mirror, for tests.

An uneven floor, a wall mirror, a chrome ball, and plain things before them.
"""

from __future__ import annotations

import tomllib
from importlib.resources import files

import attrs
import numpy as np

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import Background, Ball, Material, Quad, Scene, Texture
from hmdwarp.scenes.library import textures_named

# Plain by themselves, so that what is wrong in them is wrong in what they show.
FLOOR = Quad((0.0, 0.0, -3.0), (3.0, 0, 0), (0, 0, -3.0), -1, (0.3, 0.3, 0.32), (4, 4))
WALL = Quad((0.6, 1.4, -4.0), (0.9, 0, 0), (0, 0.8, 0), -1, (0.03, 0.03, 0.03))
CHROME = Ball((-0.7, 1.1, -2.2), 0.4, 0, (0.4, 0.4, 0.4))
BALLS = (Ball((0.4, 0.8, -2.6), 0.35, 0, (1.0, 0.55, 0.45)), Ball((-0.4, 1.5, 2.0), 0.6, 1, (0.5, 0.8, 1.0)))
BACK = Quad((0.0, 1.5, 4.0), (-4.0, 0, 0), (0, 1.5, 0), 1, (0.8, 0.9, 0.5), (4, 2))
SKY = Background((0.16, 0.28, 0.60), (0.62, 0.70, 0.82), (0.20, 0.19, 0.17))
PLAIN_SHAPES = (*BALLS, BACK)
VIEW = View(Pose((0.05, 1.5, 0.3)), Fov(-0.7, 0.75, -0.75, 0.6))


def shapes_of(scene: str, kind: type) -> list:
    """The Quads or Balls of an analytic scene of the library."""
    table = tomllib.loads(files("hmdwarp.scenes.library").joinpath(f"{scene}.toml").read_text("utf-8"))
    return [kind(**said) for said in table[f"{kind.__name__.lower()}s"].values()]


def mirrored_scene(*, uneven: bool = True, curved: bool = True) -> Scene:
    """uneven: the floor has a normal map. curved: the ball is chrome, else not there."""
    textures = (
        *textures_named("grey-checker", "sand-checker"),
        Texture("ripples", textures_named("floor-normals")[0].image[::4, ::4], srgb=False),
    )
    floor = Material(reflectivity=0.3, normal_map=2, normal_scale=0.08) if uneven else Material(reflectivity=0.3)
    meshes = [attrs.evolve(one.mesh(f"plain-{i}"), double_sided=False) for i, one in enumerate(PLAIN_SHAPES)]
    meshes += [
        attrs.evolve(FLOOR.mesh("floor"), material=floor),
        attrs.evolve(WALL.mesh("wall"), material=Material(reflectivity=0.9)),
    ]
    if curved:
        meshes.append(attrs.evolve(CHROME.mesh("chrome"), material=Material(reflectivity=0.85, curved=True)))
    return Scene("mirrored", "", meshes, textures, SKY, viewpoint=VIEW.pose)


def moved(by: tuple[float, float, float], turn_y_rad: float = 0.0) -> View:
    """VIEW from somewhere else, turned about its y."""
    turn = Pose(by, (0, np.sin(turn_y_rad / 2), 0, np.cos(turn_y_rad / 2)))
    return View(VIEW.pose @ turn, VIEW.fov)
