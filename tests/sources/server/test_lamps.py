"""Pictures of a scene with lamps, against rays in float64 by another route."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from lit_rooms import placed, plain
from scipy.ndimage import map_coordinates
from worlds import read

from hmdwarp.cloudlight.radiosity import transport_of
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import lamps_at, load_scene, with_lamps_stopped
from hmdwarp.scenes._viewpoint import Triangles

SIZE = (48, 40)
FOV = Fov(-0.8, 0.75, -0.7, 0.65)
VIEW = View(Pose((0.1, 1.5, 0.4), (0.02, 0.1, 0.0, 0.99)), FOV)


def twin(scene, inverse_depth, time_ns):
    """Colour of each pixel, and how near the nearest edge of a shadow is, by Moeller-Trumbore rays
    from the seen place, SciPy's interpolation and the quads' own corners."""
    high, wide = inverse_depth.shape
    across = np.tan(FOV.left) + (np.arange(wide) + 0.5) / wide * (np.tan(FOV.right) - np.tan(FOV.left))
    up = np.tan(FOV.down) + (np.arange(high) + 0.5) / high * (np.tan(FOV.up) - np.tan(FOV.down))
    seen = np.stack([*np.meshgrid(across, up), np.full((high, wide), -1.0)], axis=-1)
    places = VIEW.pose.transform((seen / np.maximum(inverse_depth, 1e-9)[..., None]).reshape(-1, 3)).reshape(seen.shape)
    transport = transport_of(scene)
    atlas = transport.atlas(transport.indirect(transport.direct(lamps_at(scene, time_ns))))[..., :3].astype(float)
    every = Triangles.of([(mesh.positions.astype(float), mesh.triangles) for mesh in scene.meshes])
    colour, sure = np.full(seen.shape, np.nan), np.zeros(inverse_depth.shape, bool)
    for row, column in np.ndindex(inverse_depth.shape):
        if row % 4 or column % 4:
            continue
        if inverse_depth[row, column] <= 0:
            continue
        place = places[row, column]
        mesh, at = _on(scene, place)
        if mesh is None:
            continue
        normal = mesh.normals[0].astype(float)
        light = np.zeros(3)
        edges = []
        for lamp, shines in lamps_at(scene, time_ns):
            way = lamp[:3] - place * lamp[3]
            far = np.linalg.norm(way)
            cosine = normal @ way / far
            nudges = 4e-3 * np.array([(0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
            clear = []
            for nudge in nudges - np.outer(nudges @ normal, normal):
                from_here = place + nudge + 1e-3 * normal
                distance, _ = every.first_hits(from_here, (way / far)[None])
                clear.append(distance[0] > (far if lamp[3] else np.inf) or np.isinf(distance[0]))
            edges.append(len(set(clear)) == 1 or cosine < 0)
            light += max(cosine, 0) / (far**2 if lamp[3] else 1) * np.array(shines) * clear[0]
        late = [map_coordinates(atlas[..., k], [[at[1] - 0.5], [at[0] - 0.5]], order=1)[0] for k in range(3)]
        colour[row, column], sure[row, column] = mesh.albedo[0] * (light + late), all(edges)
    return colour, sure


def _on(scene, place):
    """The quad that a place lies on, and where in the atlas."""
    for mesh in scene.meshes:
        corner, right, up = mesh.positions[0], mesh.positions[1], mesh.positions[3]
        sides = np.stack([right - corner, up - corner], axis=1).astype(float)
        share, *_ = np.linalg.lstsq(sides, place - corner, rcond=None)
        off = np.linalg.norm(sides @ share - (place - corner))
        if off < 2e-4 and (share > 1e-3).all() and (share < 0.999).all():
            places = mesh.light_uv
            return mesh, places[0] + share @ np.stack([places[1] - places[0], places[3] - places[0]])
    return None, None


@pytest.mark.parametrize(
    ("name", "time_ns"), [("lantern", 700_000_000), ("sunroom", 1_000_000_000), ("doorway", 1_300_000_000)]
)
def test_every_pixel_has_the_light_of_its_place(serve, name, time_ns):
    """Half floats round by 2^-11; the place from float32 inverse depth is good to micrometres, the
    half of a texel's step of indirect light to much less. Pixels within 4 mm of a shadow's edge may
    be on either side of it and are left out: few."""
    scene = plain(load_scene(name))
    server = serve(scene)
    eye = server.draw(VIEW, SIZE, time_ns=time_ns)
    got, depth = read(eye.colour)[..., :3].astype(float), read(eye.inverse_depth)[..., 0].astype(float)
    wanted, sure = twin(placed(scene, time_ns), depth, time_ns)
    assert sure[::4, ::4].mean() > 0.7
    assert np.allclose(got[sure], wanted[sure], rtol=2e-3, atol=1e-3)
    lit = wanted[sure].mean(axis=1)
    assert lit.std() > 0.05, "it shows light and shadow"


def test_a_door_is_lit_and_casts_its_shadow_wherever_it_has_been(serve):
    """As where it stands still there. Places turned by a float32 matrix err by 1e-6 m: the light of
    a pixel by no more than a half float rounds, but at an edge of shadow, in few."""
    scene = load_scene("doorway")
    server = serve(scene)
    for time_ns in (2_500_000_000, 1_000_000_000):
        got = read(server.draw(VIEW, SIZE, time_ns=time_ns).colour)
        there = serve(placed(scene, time_ns))
        wanted = read(there.draw(VIEW, SIZE, time_ns=9).colour)
        assert np.isclose(got, wanted, rtol=2e-3, atol=1e-4).all(axis=2).mean() > 0.99


def test_a_shut_door_keeps_the_light_out_and_an_open_one_lets_it_in(serve):
    """With the bright room's lamp alone, to the last bit: no ray passes beside a shut door."""
    scene = load_scene("doorway")
    scene = attrs.evolve(scene, lamps=scene.lamps[:1])
    server = serve(scene)
    shut, open_ = (read(server.draw(VIEW, SIZE, time_ns=ms * 1_000_000).colour)[..., :3] for ms in (200, 2500))
    assert (shut == 0).all()
    assert (open_ > 0).mean() > 0.95, "hardly a place has no light at all"


def test_baked_light_stays_where_a_door_moves(serve):
    """At the instant of the light it is the truth; later surfaces keep their light, bit for bit."""
    scene = load_scene("doorway")
    server, baked = serve(scene), serve(with_lamps_stopped(scene, 500_000_000))
    first, later = ([each.draw(VIEW, SIZE, time_ns=ms * 1_000_000) for each in (server, baked)] for ms in (500, 2500))
    truth, same, moved, stayed = (read(eye.colour)[..., :3] for eye in (*first, *later))
    seen = [read(eye.inverse_depth) for eye in (first[1], later[1])]
    assert np.array_equal(truth, same)
    rest = np.equal(*seen)[..., 0]
    assert 0.3 < rest.mean() < 1
    assert np.array_equal(stayed[rest], same[rest])
    assert moved[rest].mean() > 1.5 * stayed[rest].mean()
