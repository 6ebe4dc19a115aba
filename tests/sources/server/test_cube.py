"""The cube that the server draws.

Each face is what it would draw for that view alone, and the textures come back.
"""

from __future__ import annotations

import numpy as np
import pytest
from worlds import pixels

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View, cube_size, face_views
from hmdwarp.geometry.cube import FACES

VIEW = View(Pose((0.3, 1.5, -0.2), (0.1, 0.2, -0.05, 0.9)), Fov(-0.7, 0.8, -0.6, 0.75))
SIZE = (61, 47)


@pytest.fixture
def server(serve):
    made = serve("room")
    yield made


def test_each_face_is_the_picture_of_its_view(server):
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


def test_a_guard_band_does_not_change_the_cube(server):
    """It is as dense with it as without, and all around anyway."""
    sizes = {
        server.draw_frame([VIEW], 0, SIZE, guard, Needs(cube=True)).eyes[0]["cube"].size for guard in (1.0, (1.3, 1.1))
    }
    assert len(sizes) == 1
