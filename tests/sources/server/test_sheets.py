"""What one sees through and what is fixed to the head. The server against rays that add up light in
float64, whole and in layers."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from reference.picture import HALF_UNIT
from scipy.spatial.transform import Rotation
from worlds import read

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import SCALAR, allocate
from hmdwarp.headsets import load_headset
from hmdwarp.scenes import Material, Mesh, Quad, Scene, Texture, load_scene

SIZE = (96, 70)
FOV = Fov(-0.7, 0.6, -0.55, 0.6)
NONE, LAYERS = Needs(), Needs(transparent=True, overlay=True)


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


def picture(serve, scene: Scene, view: View, needs: Needs = NONE) -> dict[str, np.ndarray]:
    server = serve(scene)
    eye = server.draw_frame([view], 0, SIZE, needs=needs).eyes[0]
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
    depth = server.draw_depth(view, SIZE, allocate(gpu.gl, SIZE, SCALAR))
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
        frame = server.draw_frame(headset.views(pose), 0, SIZE, 1.3, Needs(overlay=True))
        found.append([read(eye["overlay"]) for eye in frame.eyes])
        assert all(
            eye["overlay"].size == SIZE and eye.size != SIZE for eye in frame.eyes
        )  # no guard band for what does not move
    for first, second in zip(*found, strict=True):
        assert np.array_equal(first, second)
    left, right = found[0]
    # Seen by both eyes at 1 m: shifted by the pupil distance, at the focal length of the picture.
    per_tangent = SIZE[0] / np.ptp(headset.eyes[0].fov.tangents[:2])
    shift = np.flatnonzero(left[..., 3].any(axis=0)).mean() - np.flatnonzero(right[..., 3].any(axis=0)).mean()
    offset = (headset.eyes[1].fov.tangents[0] - headset.eyes[0].fov.tangents[0]) * per_tangent
    assert abs(shift - headset.ipd_m * per_tangent - offset) <= 1
