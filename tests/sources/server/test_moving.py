"""The server draws moving things at the requested instant, with their ids, velocity and shadows."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from lit_rooms import placed
from reference._rays import world_directions
from reference.raycast import away_from_edges, cast_triangles
from scipy.spatial.transform import Rotation
from worlds import pixels as read
from worlds import read as picture_of

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import SCALAR, allocate
from hmdwarp.scenes import Body, Mesh, Quad, Scene, Spinning, Track, load_scene, with_lamps_stopped
from hmdwarp.sources.server import Server

MS = 1_000_000
SIZE = (90, 70)
EYE = View(Pose((0.1, 1.5, 0.3), Rotation.from_euler("y", 0.1).as_quat()), Fov(-0.8, 0.7, -0.6, 0.65))
ALL = Needs(ids=True, velocity=True)


def quad(name: str, z: float, half: float, colour: tuple, **settings) -> Mesh:
    mesh = Quad((0, 0, z), (half, 0, 0), (0, half, 0), -1, colour).mesh(name)
    return attrs.evolve(mesh, **{"double_sided": False} | settings)


class Breathing:
    """A deformation that counts how often it is asked."""

    def __init__(self, rest: np.ndarray) -> None:
        self.rest, self.asked = rest, 0

    def positions(self, time_ns: int) -> np.ndarray:
        self.asked += 1
        return self.rest * (1 + (seconds := time_ns * 1e-9) + seconds**2 / 2)

    def velocities(self, time_ns: int) -> np.ndarray:
        return self.rest * (1 + time_ns * 1e-9)


DOOR = Spinning(Pose((0.5, 1.5, -2.0)), (0, 1, 0), 1.0)
RUNNER = Track([0, 1], [(-30, 1.4, -3), (30, 1.4, -3)], loops=False)


def moving_scene() -> Scene:
    soft = quad("soft", 0, 0.4, (0, 0, 1))
    soft = attrs.evolve(soft, positions=soft.positions + np.float32((-0.6, 1.4, -2.5)))
    return Scene(
        "moving",
        "",
        [
            quad("wall", -4, 9, (0.5, 0.5, 0.5)),
            quad("door", 0, 0.3, (1, 0, 0), body=1, double_sided=True),
            quad("runner", 0, 0.3, (0, 1, 0), body=2),
            attrs.evolve(soft, deformation=Breathing(soft.positions.astype(np.float64))),
        ],
        bodies=[Body("door", DOOR), Body("runner", RUNNER)],
        origin_m=(0.0, 0.0, 0.0),
    )


@pytest.fixture(scope="module")
def server(gpu):
    made = Server(gpu, moving_scene())
    yield made
    made.close()


def corners_at(scene: Scene, time_ns: int) -> tuple[np.ndarray, np.ndarray]:
    """(m, 3, 3) triangles of the scene in the world then, and which mesh each is of."""
    found, of = [], []
    for index, mesh in enumerate(scene.meshes):
        points = mesh.positions.astype(np.float64)
        if mesh.deformation is not None:
            points = mesh.deformation.positions(time_ns)
        if mesh.body:
            points = scene.bodies[mesh.body - 1].motion.state(time_ns).pose.transform(points)
        found.append(points[mesh.triangles])
        of += [index] * len(mesh.triangles)
    return np.concatenate(found), np.array(of)


@pytest.mark.parametrize("time_ns", [0, 400 * MS, 500 * MS, 570 * MS])
def test_everything_is_drawn_where_it_is_then(gpu, server, time_ns):
    """Against rays. The runner is in sight around 0.5 s alone, 30 m from where its positions at
    time 0 would have it culled."""
    corners, of = corners_at(server.scene, time_ns)
    hits = cast_triangles(corners, EYE.pose.position_m, world_directions(EYE, SIZE).reshape(-1, 3))
    exact, mesh = hits.inverse_depth.reshape(SIZE[::-1]), np.append(of, -1)[hits.shape].reshape(SIZE[::-1])
    frame = server.draw_frame([EYE], time_ns, SIZE, needs=ALL)
    (eye,), sure = frame.eyes, away_from_edges(mesh)
    drawn = read(eye.inverse_depth)
    assert sure.mean() > 0.6
    assert np.abs(drawn - exact)[sure].max() < 1e-5  # 1/m, float32: 16 roundings of 2^-24
    ids, velocity = read(eye["ids"].numbers), read(eye["velocity"]).astype(np.float64)
    assert np.array_equal(ids[sure], np.array([0, 1, 2, 0, 0])[mesh][sure])
    assert np.array_equal(velocity[..., 3][sure] == 1, (mesh == 3)[sure])
    assert (2 in ids) == (time_ns == 500 * MS)
    assert 1 in ids
    for state, body in zip(eye["ids"].bodies, server.scene.bodies, strict=True):
        assert state.pose.isclose(body.motion.state(time_ns).pose)
    assert eye.drawn_ns == time_ns
    server.recycle(frame)


def test_velocities_are_those_of_the_surface_along_the_axes_of_the_eye(server):
    server.recycle(server.draw_frame([EYE], 0, SIZE, needs=ALL))
    frame = server.draw_frame([EYE], 200 * MS, SIZE, needs=ALL)
    eye = frame.eyes[0]
    velocity, depth = read(eye["velocity"]).astype(np.float64), read(eye.inverse_depth).astype(np.float64)
    soft = velocity[..., 3] == 1
    points = world_directions(EYE, SIZE)[soft] / depth[soft][:, None] + EYE.pose.position_m
    exact = points / 1.22 * 1.2 @ EYE.pose.rotation.as_matrix()  # of its rest place it is 1.22, and 1.2 more a second
    assert np.abs(velocity[soft][:, :3] - exact).max() < 2.0**-10 * np.abs(exact).max() + 1e-5
    assert (velocity[~soft] == 0).all()
    server.recycle(frame)


def test_depth_alone_is_that_of_the_picture(gpu, server):
    depth = allocate(gpu.gl, SIZE, SCALAR)
    for time_ns in (500 * MS, 0, 250 * MS):
        picture = server.draw(EYE, SIZE, time_ns=time_ns)
        server.draw_depth(EYE, SIZE, depth, time_ns)
        assert np.array_equal(read(depth), read(picture.inverse_depth))
        server.pool(SIZE).release(picture.colour)
    depth.release()


def test_a_mesh_is_written_once_for_each_instant(serve):
    scene = moving_scene()
    counts, server = scene.meshes[3].deformation, serve(scene)
    for time_ns, asked in ((0, 1), (0, 1), (100 * MS, 2), (0, 3)):
        frame = server.draw_frame([EYE, EYE], time_ns, SIZE, needs=ALL)
        server.recycle(frame)
        assert counts.asked == asked


def test_layers_behind_leave_out_what_the_client_moves(server):
    """Behind the door is the wall. Where nobody compensates, the door is behind what hides it as
    everything else."""
    for needs in (Needs(peeled=1), Needs(peeled=1, ids=True), Needs(peeled=2, ids=True, velocity=True)):
        frame = server.draw_frame([EYE], 0, SIZE, needs=needs)
        eye = frame.eyes[0]
        red = read(eye.colour)[..., 0] == 1
        behind = read(eye["peeled"][0].colour).astype(np.float64)
        assert red.sum() > 50
        assert np.abs(behind[red][:, :3] - 0.5).max() < 2.0**-10
        if "ids" in needs:
            assert not ((behind[..., 0] == 1) | ((behind[..., 1] == 1) & (behind[..., 0] == 0))).any()
        server.recycle(frame)


SMALL = (48, 40)
FOV = Fov(-0.8, 0.75, -0.7, 0.65)
VIEW = View(Pose((0.1, 1.5, 0.4), (0.02, 0.1, 0.0, 0.99)), FOV)


def test_a_door_is_lit_and_casts_its_shadow_wherever_it_has_been(serve):
    """As where it stands still there. Places turned by a float32 matrix err by 1e-6 m: the light of
    a pixel by no more than a half float rounds, but at an edge of shadow, in few."""
    scene = load_scene("doorway")
    server = serve(scene)
    for time_ns in (2_500_000_000, 1_000_000_000):
        got = picture_of(server.draw(VIEW, SMALL, time_ns=time_ns).colour)
        there = serve(placed(scene, time_ns))
        wanted = picture_of(there.draw(VIEW, SMALL, time_ns=9).colour)
        assert np.isclose(got, wanted, rtol=2e-3, atol=1e-4).all(axis=2).mean() > 0.99


def test_a_shut_door_keeps_the_light_out_and_an_open_one_lets_it_in(serve):
    """With the bright room's lamp alone, to the last bit: no ray passes beside a shut door."""
    scene = load_scene("doorway")
    scene = attrs.evolve(scene, lamps=scene.lamps[:1])
    server = serve(scene)
    shut, open_ = (picture_of(server.draw(VIEW, SMALL, time_ns=ms * 1_000_000).colour)[..., :3] for ms in (200, 2500))
    assert (shut == 0).all()
    assert (open_ > 0).mean() > 0.95, "hardly a place has no light at all"


def test_baked_light_stays_where_a_door_moves(serve):
    """At the instant of the light it is the truth; later surfaces keep their light, bit for bit."""
    scene = load_scene("doorway")
    server, baked = serve(scene), serve(with_lamps_stopped(scene, 500_000_000))
    first, later = ([each.draw(VIEW, SMALL, time_ns=ms * 1_000_000) for each in (server, baked)] for ms in (500, 2500))
    truth, same, moved, stayed = (picture_of(eye.colour)[..., :3] for eye in (*first, *later))
    seen = [picture_of(eye.inverse_depth) for eye in (first[1], later[1])]
    assert np.array_equal(truth, same)
    rest = np.equal(*seen)[..., 0]
    assert 0.3 < rest.mean() < 1
    assert np.array_equal(stayed[rest], same[rest])
    assert moved[rest].mean() > 1.5 * stayed[rest].mean()
