"""The cube and the layers behind the picture that the server draws."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from reference._rays import world_directions
from worlds import pixels

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View, cube_size, face_views
from hmdwarp.geometry.cube import FACES
from hmdwarp.scenes import Background, Quad, Scene

VIEW = View(Pose((0.3, 1.5, -0.2), (0.1, 0.2, -0.05, 0.9)), Fov(-0.7, 0.8, -0.6, 0.75))
SIZE = (61, 47)


def test_each_face_is_the_picture_of_its_view(serve):
    server = serve("room")
    frame = server.draw_frame([VIEW], 0, SIZE, needs=Needs(cube=True))
    eye = frame.eyes[0]
    assert eye["cube"].size == cube_size(VIEW.fov, SIZE)
    side, cube = eye["cube"].size[0] // 3, pixels(eye["cube"])
    assert (cube[..., 3] == 1).all()
    for face, view in zip(FACES, face_views(VIEW, side), strict=True):
        alone = server.draw(view, (side, side))
        drawn = cube[face.row * side : (face.row + 1) * side, face.column * side : (face.column + 1) * side]
        # The same triangles in another place of the framebuffer: a rasteriser may round an edge
        # otherwise, and mipmaps with it.
        same = np.abs(drawn.astype(float) - pixels(alone.colour)).max(axis=-1) <= 2**-9
        assert same.mean() > 0.99, face.name
        server.pool((side, side)).release(alone.colour)


FOV = Fov(-0.6, 0.7, -0.5, 0.55)
SKY = (0.25, 0.5, 1.0)
AHEAD = View(Pose(), FOV)


def walls(*depths_m: float, half: float = 0.3, double_sided: bool = False, facing: float = 1) -> Scene:
    """Squares of half edge `half` times their distance, one behind the other before the origin,
    number k of brightness k + 1."""
    meshes = [
        Quad((0, 0, -z), (half * z * facing, 0, 0), (0, half * z, 0), -1, (k + 1.0,) * 3).mesh(f"wall {k}")
        for k, z in enumerate(depths_m)
    ]
    meshes = [attrs.evolve(mesh, double_sided=double_sided) for mesh in meshes]
    return Scene("walls", "", meshes, background=Background.uniform(SKY))


def peeled(serve, scene: Scene, count: int, view: View = AHEAD) -> list[tuple[np.ndarray, np.ndarray]]:
    """(colour, inverse depth) of the visible layer and `count` behind it."""
    server = serve(scene)
    eye = server.draw_frame([view], 0, SIZE, needs=Needs(peeled=count)).eyes[0]
    assert len(eye["peeled"]) == count
    return [(pixels(each.colour), pixels(each.inverse_depth)) for each in (eye, *eye["peeled"])]


def middle() -> np.ndarray:
    """Pixels whose rays pass well within the squares."""
    rays = world_directions(AHEAD, SIZE)
    return (np.abs(rays[..., :2] / rays[..., 2:]) < 0.27).all(axis=-1)


def test_walls_one_behind_the_other_then_the_sky_then_nothing(serve):
    layers = peeled(serve, walls(1, 2, 5), 4)
    for k, (colour, depth) in enumerate(layers[:3]):
        assert depth[middle()] == pytest.approx(1 / (1, 2, 5)[k], rel=1e-6)
        assert (colour[middle()] == (k + 1, k + 1, k + 1, 1)).all()
    sky_colour, sky_depth = layers[3]
    assert (sky_depth[middle()] == 0).all()
    assert np.abs(sky_colour[middle()] - (*SKY, 1)).max() < 1e-3
    nothing_colour, nothing_depth = layers[4]
    assert (nothing_depth == -1).all()
    assert (nothing_colour == 0).all()


def test_close_behind_is_behind_and_a_surface_is_not_behind_itself(serve):
    """1 mm at 2 m: a picture on a wall."""
    layers = peeled(serve, walls(2, 2.001), 2)
    assert layers[1][1][middle()] == pytest.approx(1 / 2.001, rel=1e-6)
    assert (layers[2][1][middle()] == 0).all()


@pytest.mark.parametrize("double_sided", [False, True])
def test_backs_are_left_out_as_in_the_picture_itself(serve, double_sided):
    layers = peeled(serve, walls(1, 2, double_sided=double_sided, facing=-1), 1)
    assert layers[0][1][middle()] == pytest.approx(1.0 if double_sided else 0)
    assert layers[1][1][middle()] == pytest.approx(0.5 if double_sided else -1)
