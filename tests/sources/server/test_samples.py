"""Pictures with several samples a pixel: mixed colours, and one surface's depth."""

from __future__ import annotations

import attrs
import numpy as np
from worlds import pixels

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import Background, Quad, Scene, load_scene

SIZE = (64, 48)
FRONT, BACK = np.array([0.75, 0.25, 0.5]), np.array([0.125, 0.5, 1.0])
VIEW = View(Pose(), Fov.from_tangents((-1, 1, -0.75, 0.75)))  # 1/32 of tangent a pixel
SLOPE = 0.3  # tangents that the silhouette moves aside for each it goes up
HALF = 2.0**-11  # relative rounding of a colour in 16 bits


def before_a_wall() -> Scene:
    """A sheet at 1 m left of a slanted silhouette, before a wall at 4 m."""
    corners = [(-3.0, -1.0, -1.0), (-SLOPE, -1.0, -1.0), (SLOPE, 1.0, -1.0), (-3.0, 1.0, -1.0)]
    near, far = (Quad((0, 0, -4), (9, 0, 0), (0, 9, 0), -1, light).mesh("sheet") for light in (FRONT, BACK))
    meshes = (attrs.evolve(near, positions=corners), far)
    return Scene("two", "", meshes, background=Background.uniform((9,) * 3))


def covered_by_the_sheet() -> np.ndarray:
    """The share of each pixel left of the silhouette, bottom row first, from 32x32 points of it."""
    fine = 32
    x = (np.arange(SIZE[0] * fine) + 0.5) / (SIZE[0] * fine) * 2 - 1
    y = ((np.arange(SIZE[1] * fine) + 0.5) / (SIZE[1] * fine) * 2 - 1) * 0.75
    left = x[None, :] < SLOPE * y[:, None]
    return left.reshape(SIZE[1], fine, SIZE[0], fine).mean(axis=(1, 3))


def test_a_silhouette_mixes_colours_by_coverage_and_has_the_depth_of_one_surface(serve):
    server = serve(before_a_wall(), samples=4)
    eye = server.draw(VIEW, SIZE)
    colour, depth = pixels(eye.colour)[..., :3], pixels(eye.inverse_depth)
    share = covered_by_the_sheet()
    mixed = (share > 0) & (share < 1)

    weight = (colour - BACK) @ (FRONT - BACK) / ((FRONT - BACK) ** 2).sum()
    assert np.abs(colour - (BACK + weight[..., None] * (FRONT - BACK))).max() < 2 * HALF
    # Four samples: the mixture is of quarters.
    assert np.abs(weight - np.round(4 * weight) / 4).max() < 8 * HALF
    assert np.abs(weight - share).max() < 0.5  # one of four samples at the very edge, and its area
    assert abs((weight - share)[mixed].mean()) < 0.05
    assert (weight[mixed] > 0.1).sum() > 20 and (weight[mixed] < 0.9).sum() > 20

    assert ((np.abs(depth - 1) < 1e-6) | (np.abs(depth - 0.25) < 1e-6)).all()  # never a mean of 1 and 1/4
    alone = serve(before_a_wall())
    assert np.array_equal(depth, pixels(alone.draw(VIEW, SIZE).inverse_depth))


def test_a_body_has_its_number_at_each_pixel_that_has_its_depth(serve):
    scene, needs = load_scene("workshop"), Needs(ids=True)
    view, found = View(Pose((0, 1.6, 0)), Fov.symmetric(0.8, 0.85)), []
    for samples in (1, 4):
        server = serve(scene, samples=samples)
        (eye,) = server.draw_frame([view], 10**9, (160, 200), needs=needs).eyes
        found.append((pixels(eye.get("ids").numbers), pixels(eye.inverse_depth)))
    (plain, depth), (centre, centre_depth) = found
    assert (plain > 0).any()
    assert np.array_equal(plain, centre) and np.array_equal(depth, centre_depth)
