"""What mirrors show, against rays mirrored in the world; what one sees through and what is fixed to
the head, against light added up in float64, whole and in layers."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from mirrored import BALLS, CHROME, FLOOR, VIEW, WALL, mirrored_scene, moved
from reference._rays import world_directions
from reference.picture import HALF_UNIT
from reference.raycast import Hits, cast_quads, cast_spheres
from scipy.spatial.transform import Rotation
from worlds import read

from hmdwarp.frames import Mirrored, Needs
from hmdwarp.frames.layers import layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import SCALAR, allocate
from hmdwarp.headsets import load_headset
from hmdwarp.scenes import Material, Mesh, Quad, Scene, Texture, load_scene
from hmdwarp.sources.server import Server

SIZE = (97, 83)
EVERY = Needs(reflection=Mirrored.PLANE | Mirrored.CURVED)


@pytest.fixture(scope="module")
def server(gpu):
    made = Server(gpu, mirrored_scene())
    yield made
    made.close()


def layered(server: Server, view=VIEW, needs: Needs = EVERY):
    return server.draw_frame([view], 0, SIZE, needs=needs).eyes[0]


def first(things, place: np.ndarray, rays: np.ndarray) -> Hits:
    """What rays meet first of some quads or balls."""
    if isinstance(things[0], Quad):
        return cast_quads([(quad.centre, quad.right, quad.up) for quad in things], place, rays)
    return cast_spheres([(*ball.centre, ball.radius) for ball in things], place, rays)


def test_the_surface_tells_reflectivity_where_the_picture_shows_a_mirror(server):
    """A mirror is drawn behind what stands before it, and its surface is not."""
    eye = layered(server)
    surface, rays = read(eye["reflection"].surface), world_directions(VIEW, SIZE).reshape(-1, 3)
    told = [(mirror.is_curved, mirror.reflectivity) for mirror in eye["reflection"].mirrors]
    assert told == [(False, 0.3), (False, 0.9), (True, 0.85)], "plane ones first"
    balls, quads = (first(things, VIEW.pose.position_m, rays) for things in ((*BALLS, CHROME), (FLOOR, WALL)))
    for index, reflectivity in ((0, 0.3), (1, 0.9)):
        here = ((quads.shape == index) & (quads.inverse_depth > balls.inverse_depth)).reshape(SIZE[::-1])
        # one pixel at each silhouette may go the other way
        assert (np.abs(surface[here, 0] - reflectivity) < 1e-3).mean() > 0.97
    hidden = ((balls.shape == 0) & (balls.cosine > 0.3) & (quads.shape == 1)).reshape(SIZE[::-1])
    assert hidden.sum() > 20 and (surface[hidden] == (0, 0, 0, 1)).all() and (surface[..., 3] == 1).all()
    assert (read(eye["reflection"].seen.colour)[hidden, 3] == 1).all()
    assert (read(eye.inverse_depth)[..., 0] == read(server.draw(VIEW, SIZE).inverse_depth)[..., 0]).all()


@pytest.mark.parametrize(
    "needs",
    [Needs(), Needs(reflection=Mirrored.PLANE), Needs(reflection=Mirrored.CURVED), EVERY],
    ids=["-", "plane", "ball", "both"],
)
def test_mirrors_needed_as_a_layer_alone_are_left_out_of_the_picture(server, needs):
    eye, whole = layered(server, needs=needs), read(server.draw(VIEW, SIZE).colour)
    changed = np.abs(read(eye.colour) - whole).max(axis=-1) > 0
    surface = read(eye["reflection"].surface)[..., 0] if "reflection" in eye else np.zeros(SIZE[::-1])
    # An uneven floor is looked into beside the pixel, which beside the ball may hold the ball, if
    # that is in the same layers.
    assert (changed & (surface == 0)).mean() <= (0.01 if needs == Needs(reflection=Mirrored.CURVED) else 0)
    assert ("reflection" in eye) == ("reflection" in needs)
    if "reflection" in eye:
        assert changed[surface > 0].mean() > 0.9
        assert sum(mirror.is_curved for mirror in eye["reflection"].mirrors) == (Mirrored.CURVED in needs["reflection"])


@pytest.mark.parametrize(
    "view",
    [
        VIEW,
        moved((0.2, -0.1, 0.3), 0.15),
        moved((0, 0.3, -1.2), 0.4),
        moved((0, 0.5, -1), 2.6),
        moved((-0.7, -0.3, -2.4)),
    ],
    ids=["ahead", "turned", "near the wall", "turned away", "beside the ball"],
)
@pytest.mark.parametrize("kinds", [Mirrored.PLANE, Mirrored.CURVED, Mirrored.PLANE | Mirrored.CURVED])
def test_the_layer_is_empty_beyond_its_bounds_and_not_sent(server, view, kinds):
    layer = layered(server, view, Needs(reflection=kinds))["reflection"]
    low_x, low_y, high_x, high_y = layer.bounds
    beyond = np.ones(SIZE[::-1], bool)
    beyond[low_y:high_y, low_x:high_x] = False
    colour, inverse_depth, surface = (read(texture) for texture in (*layer.seen.textures(), layer.surface))
    assert (colour[beyond] == 0).all() and (inverse_depth[beyond] == -1).all()
    assert (surface[beyond] == (0, 0, 0, 1)).all()
    assert layers.get("reflection").sent_bytes(layer) == 20 * (~beyond).sum()


def test_no_mirror_shows_what_stands_behind_it(serve):
    """A ball behind the wall mirror, which the mirrored eye would see first, is not in it."""
    scene = mirrored_scene(curved=False)
    behind = attrs.evolve(scene.meshes[0], positions=scene.meshes[0].positions + np.float32([0.2, 0.6, -2.6]))
    more = attrs.evolve(scene, meshes=(*scene.meshes, behind))
    pictures = []
    for each in (scene, more):
        server = serve(each)
        eye = layered(server, needs=Needs(reflection=Mirrored.PLANE))
        wall = np.abs(read(eye["reflection"].surface)[..., 0] - 0.9) < 1e-2
        pictures.append(read(eye["reflection"].seen.colour)[wall])
    assert len(pictures[0]) > 100
    assert np.array_equal(*pictures)


def test_a_marched_mirror_shows_what_the_picture_shows_and_nothing_else(serve, server):
    marched = serve(mirrored_scene(), mirrors="screen")
    exact, found = layered(server)["reflection"], layered(marched)["reflection"]
    depth, marched_depth = (read(each.seen.inverse_depth)[..., 0] for each in (exact, found))
    floor = np.abs(read(exact.surface)[..., 0] - 0.3) < 1e-2
    hit = floor & (marched_depth >= 0) & (depth >= 0)
    assert 0.2 < hit.sum() / floor.sum() < 1
    # The late picture's own pixels and the thickness allowed limit it; silhouettes go either way.
    assert (np.abs(marched_depth - depth)[hit] <= 0.03 * depth[hit] + 1e-3).mean() > 0.85
    missed = marched_depth < 0
    assert (read(found.seen.colour)[missed & floor] == 0).all()
    assert np.array_equal(read(marched.draw(VIEW, SIZE).colour), read(server.draw(VIEW, SIZE).colour)), (
        "the truth is never marched"
    )


PANES = (96, 70)
FOV = Fov(-0.7, 0.6, -0.55, 0.6)
NOTHING, LAYERS = Needs(), Needs(transparent=True, overlay=True)


def pane(name: str, quad: Quad, **material: object) -> Mesh:
    return attrs.evolve(quad.mesh(name), material=Material(**({"see_through": True} | material)))


def random_panes(seed: int, count: int = 4) -> list[Mesh]:
    """Tilted panes one behind the other, none through another. 25 cm apart, tilted by less than
    that over their size."""
    rng = np.random.default_rng(seed)
    made = []
    for k in rng.permutation(count):
        centre = (rng.uniform(-0.4, 0.4), 1.6 + rng.uniform(-0.3, 0.3), -0.8 - 0.25 * k)
        tilt = rng.uniform(-0.05, 0.05, 2)
        quad = Quad(
            centre,
            (rng.uniform(0.2, 0.5), 0, tilt[0]),
            (0, rng.uniform(0.2, 0.5), tilt[1]),
            -1,
            tuple(rng.uniform(0, 1, 3)),
        )
        shares = {"opacity": rng.uniform(0.1, 0.9), "transmission": rng.uniform() if k % 2 else 0.0}
        made.append(pane(f"pane-{k}", quad, tint=tuple(rng.uniform(0.3, 1, 3)), **shares))
    return made


def with_meshes(*meshes: Mesh, textures: tuple[Texture, ...] = ()) -> Scene:
    base = load_scene("planes")
    return attrs.evolve(base, meshes=(*base.meshes, *meshes), textures=(*base.textures, *textures))


def picture(serve, scene: Scene, view: View, needs: Needs = NOTHING) -> dict[str, np.ndarray]:
    server = serve(scene)
    eye = server.draw_frame([view], 0, PANES, needs=needs).eyes[0]
    found = {"colour": read(eye.colour), "inverse_depth": read(eye.inverse_depth)[..., 0]}
    if "transparent" in eye:
        layer = eye["transparent"]
        found |= {
            "veil": read(layer.veil.colour),
            "depth": read(layer.veil.inverse_depth)[..., 0],
            "passing": read(layer.passing),
        }
    if "overlay" in eye:
        found["overlay"] = read(eye["overlay"])
    return found


@pytest.mark.parametrize("seed", range(6))
def test_the_layers_put_together_are_the_whole_picture(serve, seed):
    hud = pane(
        "hud",
        Quad((0.1, 0.05, -1), (0.2, 0, 0), (0, 0.1, 0), -1, (0.2, 1, 0.3)),
        see_through=False,
        head_locked=True,
        opacity=0.6,
    )
    scene, view = with_meshes(*random_panes(seed), hud), View(Pose((0, 1.6, 0)), FOV, Pose((0.03, 0, 0)))
    whole, parts = picture(serve, scene, view), picture(serve, scene, view, LAYERS)
    hides = parts["depth"] < parts["inverse_depth"]  # all sheets of these pixels lie behind what is seen
    decided = (
        np.abs(parts["depth"] - parts["inverse_depth"]) > 2**-10 * parts["inverse_depth"]
    )  # not where one cuts through a surface
    shown = parts["colour"][..., :3]
    shown = np.where(hides[..., None], shown, parts["passing"][..., :3] * shown + parts["veil"][..., :3])
    shown = (1 - parts["overlay"][..., 3:]) * shown + parts["overlay"][..., :3]
    # Both ways round to half floats once for each of up to five sheets, in another order.
    assert decided.mean() > 0.99 and (np.abs(shown - whole["colour"][..., :3]) <= 12 * HALF_UNIT)[decided].all()
    nothing = parts["depth"] < 0
    assert nothing.any() and (parts["veil"][nothing] == 0).all() and (parts["passing"][nothing] == (1, 1, 1, 0)).all()
    assert (parts["veil"][~nothing][:, 3] == 1).all()


def wall_between(front_m: float, back_m: float) -> tuple[Mesh, Mesh, Mesh]:
    """A pane in front of an opaque wall, the wall at 1 m, and a pane behind it."""
    wall = Quad((0, 1.6, -1), (0.3, 0, 0), (0, 0.3, 0), -1, (0.5, 0.5, 0.5)).mesh("wall")
    front = pane("front", Quad((0.15, 1.6, -front_m), (0.1, 0, 0), (0, 0.1, 0), -1, (1, 0, 0)), opacity=0.5)
    back = pane("back", Quad((0, 1.6, -back_m), (2, 0, 0), (0, 2, 0), -1, (0, 0, 1)), opacity=0.5)
    return front, wall, back


def test_a_hidden_pane_is_known_where_no_other_is_seen_and_only_there(serve):
    front, wall, back = wall_between(0.6, 1.5)
    scene = Scene("wall", "", (wall, front, back))
    parts = picture(serve, scene, View(Pose((0, 1.6, 0)), FOV), LAYERS)
    behind_wall = parts["inverse_depth"] > 0.9
    at_front = parts["depth"] > 1.5
    assert at_front.sum() > 20 and (behind_wall & ~at_front).sum() > 200
    hidden = behind_wall & ~at_front
    assert np.abs(parts["depth"][hidden] - 1 / 1.5).max() < 1e-4
    assert (parts["veil"][hidden][:, 2] > 0.45).all()
    assert (parts["veil"][at_front & behind_wall][:, 2] == 0).all()  # nothing of the one behind the wall shines through


@pytest.mark.parametrize("channel", range(3))
def test_a_sheet_is_absent_that_takes_less_than_1_of_256_of_every_colour(serve, channel):
    for share, there in ((1 / 200, True), (1 / 300, False)):
        tint = [1.0, 1.0, 1.0]
        tint[channel] -= share
        clear = pane("clear", Quad((0, 1.6, -1), (2, 0, 0), (0, 2, 0), -1, (1, 1, 1)), opacity=0.0, tint=tuple(tint))
        parts = picture(serve, Scene("clear", "", (clear,)), View(Pose((0, 1.6, 0)), FOV), LAYERS)
        assert ((parts["depth"] > 0) == there).all()


def test_a_fence_of_alpha_is_a_surface_with_holes(gpu, serve):
    image = np.zeros((8, 8, 4), np.uint8)
    image[:, 4:] = (255, 200, 100, 255)
    fence = attrs.evolve(pane("fence", Quad((0, 1.6, -1), (0.3, 0, 0), (0, 0.3, 0), 0, (1, 1, 1))), texture=2)
    scene = with_meshes(fence, textures=(Texture("laths", image, repeat=False),))
    view = View(Pose((0, 1.6, 0)), FOV)
    plain, whole, parts = (
        picture(serve, with_meshes(), view),
        picture(serve, scene, view),
        picture(serve, scene, view, LAYERS),
    )
    at_fence = np.abs(whole["inverse_depth"] - 1) < 1e-5
    assert at_fence.sum() > 100
    assert np.array_equal(whole["inverse_depth"][~at_fence], plain["inverse_depth"][~at_fence])
    assert (
        np.array_equal(whole["colour"], parts["colour"]) and (parts["depth"] == -1).all()
    )  # none of it is in the veil
    server = serve(scene)
    depth = server.draw_depth(view, PANES, allocate(gpu.gl, PANES, SCALAR))
    assert np.array_equal(read(depth)[..., 0], whole["inverse_depth"])  # the client's own knows it too


def test_head_locked_content_does_not_depend_on_the_head(serve):
    hud = pane(
        "hud", Quad((0.1, 0.05, -1), (0.2, 0, 0), (0, 0.1, 0), -1, (0.2, 1, 0.3)), see_through=False, head_locked=True
    )
    server, headset = serve(with_meshes(hud)), load_headset("rift-dk1")
    found = []
    for pose in (
        Pose((0, 1.6, 0)),
        Pose((3, -1, 7), Rotation.from_euler("YXZ", (140, 30, 10), degrees=True).as_quat()),
    ):
        frame = server.draw_frame(headset.views(pose), 0, PANES, 1.3, Needs(overlay=True))
        found.append([read(eye["overlay"]) for eye in frame.eyes])
        assert all(
            eye["overlay"].size == PANES and eye.size != PANES for eye in frame.eyes
        )  # no guard band for what does not move
    for first, second in zip(*found, strict=True):
        assert np.array_equal(first, second)
    left, right = found[0]
    # Seen by both eyes at 1 m: shifted by the pupil distance, at the focal length of the picture.
    per_tangent = PANES[0] / np.ptp(headset.eyes[0].fov.tangents[:2])
    shift = np.flatnonzero(left[..., 3].any(axis=0)).mean() - np.flatnonzero(right[..., 3].any(axis=0)).mean()
    offset = (headset.eyes[1].fov.tangents[0] - headset.eyes[0].fov.tangents[0]) * per_tangent
    assert abs(shift - headset.ipd_m * per_tangent - offset) <= 1
