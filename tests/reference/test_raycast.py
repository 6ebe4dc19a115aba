"""The ray-caster against points put on the shapes beforehand."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reference.raycast import cast_quads, cast_spheres, cast_triangles, nearest

seeds = st.integers(0, 2**32 - 1)
EYE = np.array([0.1, 0.2, 0.3])


def ray_to(point: np.ndarray) -> np.ndarray:
    """Of length 1 along -z, as the rays of a view."""
    return (point - EYE) / -(point - EYE)[2]


@given(seeds)
def test_a_triangle_is_met_where_the_point_lies_and_missed_beside_it(seed):
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(3, 3)) + (0, 0, -6)
    weights = rng.dirichlet((2, 2, 2))
    inside, outside = weights @ corners, np.array([1.2, -0.1, -0.1]) @ corners
    hits = cast_triangles(corners[None], EYE, np.array([ray_to(inside), ray_to(outside)]))
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    if hits.cosine[0] < 1e-3 or area < 1e-2:
        return  # seen edge-on: the crossing is lost in rounding
    assert np.isclose(hits.inverse_depth[0], -1 / (inside - EYE)[2], rtol=1e-9)
    assert np.allclose(hits.uv[0], weights[1:], atol=1e-8)
    assert hits.shape.tolist() == [0, -1]
    assert hits.inverse_depth[1] == 0


@given(seeds)
def test_a_quad_is_two_triangles(seed):
    rng = np.random.default_rng(seed)
    centre, right, up = rng.normal(size=3) + (0, 0, -6), *rng.normal(size=(2, 3))
    a, b, c, d = (centre + s * right + t * up for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
    rays = np.concatenate([rng.normal(0, 0.3, (40, 2)), -np.ones((40, 1))], axis=1)
    quad, triangles = cast_quads([(centre, right, up)], EYE, rays), cast_triangles([(a, b, c), (a, c, d)], EYE, rays)
    wide = cast_quads([(centre, right * 1.001, up * 1.001)], EYE, rays)
    clear = (np.abs(wide.uv).max(axis=1) < 0.999 - 1e-6) | (
        wide.shape < 0
    )  # a ray on the very border may round to either side
    clear &= (wide.cosine > 1e-3) & (
        np.linalg.norm(np.cross(right, up)) > 1e-2
    )  # seen edge-on, the crossing is lost in rounding
    # The diagonal belongs to both triangles; a seam between them would be a miss here.
    assert ((quad.shape >= 0) == (triangles.shape >= 0))[clear].all()
    assert np.allclose(quad.inverse_depth[clear], triangles.inverse_depth[clear], rtol=1e-8, atol=1e-12)


@given(seeds)
def test_a_ball_is_met_on_its_near_side(seed):
    rng = np.random.default_rng(seed)
    centre, radius = rng.normal(size=3) + (0, 0, -8), rng.uniform(0.1, 2)
    way = rng.normal(size=3)
    point = centre + radius * way / np.linalg.norm(way)
    hits = cast_spheres([(*centre, radius)], EYE, ray_to(point)[None])
    facing = (point - centre) @ (EYE - point) / (radius * np.linalg.norm(EYE - point))
    if facing > 1e-3:
        assert np.isclose(hits.inverse_depth[0], -1 / (point - EYE)[2], rtol=1e-9)
        assert np.isclose(hits.cosine[0], facing, rtol=1e-6)
    elif facing < -1e-3:
        assert hits.inverse_depth[0] > -1 / (point - EYE)[2]


def test_the_nearer_of_two_shapes_wins_and_nothing_is_infinitely_far():
    rays = np.array([(0, 0, -1.0), (5, 5, -1.0)])
    far = cast_quads([((0, 0, -4), (1, 0, 0), (0, 1, 0))], EYE, rays)
    near = cast_spheres([(0.1, 0.2, -2, 0.5)], EYE, rays)
    hits = nearest(far, near)
    assert hits.shape.tolist() == [1, -1]
    assert np.allclose(hits.inverse_depth, [1 / 1.8, 0])
