"""What one sees through and what is fixed to the head. The server against rays that add up light in
float64, whole and in layers."""

from __future__ import annotations

import attrs
import moderngl
import numpy as np
import pytest
from reference._rays import world_directions
from reference.picture import HALF_UNIT
from reference.sheets import Sheet, look_through
from scipy.spatial.transform import Rotation
from worlds import read

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, RigidState, View
from hmdwarp.gpu import SCALAR, allocate
from hmdwarp.headsets import load_headset
from hmdwarp.scenes import Body, Material, Mesh, Quad, Scene, Texture, load_scene

SIZE = (96, 70)
FOV = Fov(-0.7, 0.6, -0.55, 0.6)
NONE, LAYERS = Needs(), Needs(transparent=True, overlay=True)


def pane(name: str, quad: Quad, **material: object) -> Mesh:
    return attrs.evolve(quad.mesh(name), material=Material(**({"see_through": True} | material)))


def sheet(mesh: Mesh) -> Sheet:
    """The twin of a pane without a texture."""
    made = mesh.material
    own, coloured = (1 - made.transmission) * mesh.light[0], made.transmission * mesh.albedo[0]
    return Sheet(corners_of(mesh), own, made.opacity, made.tint, coloured)


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


def corners_of(mesh: Mesh) -> np.ndarray:
    return mesh.positions[mesh.triangles].astype(np.float64)


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


def away_from_changes(value: np.ndarray) -> np.ndarray:
    """Pixels whose neighbours all have the same value."""
    same = np.zeros(value.shape, bool)
    same[1:-1, 1:-1] = True
    for axis in (0, 1):
        for step in (-1, 1):
            same &= np.roll(value, step, axis) == value
    return same


def many_panes(rng: np.random.Generator, count: int, textures: int) -> tuple[list[Mesh], list[Sheet], list[Texture]]:
    """Panes one behind the other, each on one of the textures, which are of one colour each. Every
    third shows its back; every second of those is one-sided and not seen. 2 cm apart, and so much
    in a row that the distance of a triangle's middle is off by less than that."""
    base = len(load_scene("planes").textures)
    colours = rng.integers(0, 256, (textures, 3), dtype=np.uint8)
    made, sheets = [], []
    for k in rng.permutation(count):
        centre = (rng.uniform(-0.02, 0.02), 1.6 + rng.uniform(-0.02, 0.02), -0.8 - 0.02 * k)
        quad = Quad(
            centre, (rng.uniform(0.1, 0.3), 0, 0), (0, rng.uniform(0.1, 0.3), 0), -1, tuple(rng.uniform(0, 1, 3))
        )
        opacity, tint = rng.uniform(0.1, 0.9), tuple(rng.uniform(0.3, 1, 3))
        one = pane(f"pane-{k}", quad, opacity=opacity, tint=tint)
        away = k % 3 == 0
        triangles = one.triangles[:, ::-1] if away else one.triangles
        one = attrs.evolve(one, triangles=triangles, texture=base + k % textures, double_sided=k % 6 != 0)
        made.append(one)
        if one.double_sided or not away:
            sheets.append(Sheet(corners_of(one), one.light[0] * (colours[k % textures] / 255), opacity, tint))
    images = [Texture(f"t{k}", np.broadcast_to(colour, (1, 1, 3)), srgb=False) for k, colour in enumerate(colours)]
    return made, sheets, images


def panes_of(kind: str, seed: int) -> tuple[list[Mesh], list[Sheet], list[Texture]]:
    """Either of them; the seed of many is their number of textures."""
    if kind == "many":
        return many_panes(np.random.default_rng(seed), 60, seed)
    panes = random_panes(seed)
    return panes, [sheet(pane) for pane in panes], []


CASES = [*(("tilted", seed) for seed in range(6)), *(("many", textures) for textures in (1, 5, 13, 14, 40))]


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_panes_blend_as_rays_meet_them(serve, kind, seed):
    """In their order, with their textures and sides; in the whole picture, and in its layers."""
    panes, sheets, images = panes_of(kind, seed)
    turn = Rotation.from_euler("YX", np.random.default_rng(seed).uniform(-8, 8, 2) * (kind == "tilted"), degrees=True)
    view, scene = View(Pose((0.05, 1.6, 0.1), turn.as_quat()), FOV), with_meshes(*panes, textures=tuple(images))
    plain, whole, parts = (
        picture(serve, *drawn) for drawn in ((with_meshes(), view), (scene, view), (scene, view, LAYERS))
    )
    rays, behind = world_directions(view, SIZE).reshape(-1, 3), plain["inverse_depth"].ravel()
    seen, shape = look_through(sheets, view.pose.position_m, rays, behind), whole["colour"][..., :3].shape
    count, nearest = seen.count.reshape(SIZE[::-1]), seen.inverse_depth.reshape(SIZE[::-1])
    # The depth of a tilted pane changes from pixel to pixel.
    safe = away_from_changes(nearest if kind == "many" else nearest < 0) & away_from_changes(count)
    assert safe.mean() > 0.3 and count[safe].max() >= (11 if kind == "many" else 2)
    # Every sheet is a product and a sum stored in half floats, on top of the picture that was one
    # before; light is at most 1.
    tolerance = 2 * HALF_UNIT * (1 + count)[..., None]
    for name, expected, where in (
        ("colour", seen.over(plain["colour"][..., :3].reshape(-1, 3)), safe),
        ("veil", seen.veil, safe & (count > 0)),
        ("passing", seen.passing, safe & (count > 0)),
    ):
        found = (whole if name == "colour" else parts)[name][..., :3]
        assert (np.abs(found - expected.reshape(shape)) <= tolerance)[where].all(), name
    assert (whole["colour"][..., 3] == 1).all()
    assert np.array_equal(whole["inverse_depth"], plain["inverse_depth"])  # that of what lies behind


@pytest.mark.parametrize(("textures", "most"), [(1, 1), (13, 1), (26, 30)])
def test_a_draw_call_is_not_made_for_every_pane(serve, monkeypatch, textures, most):
    panes, _, images = many_panes(np.random.default_rng(7), 300, textures)
    servers = [serve(with_meshes(*meshes, textures=tuple(images))) for meshes in (panes, ())]
    calls, render = [], moderngl.VertexArray.render
    monkeypatch.setattr(
        moderngl.VertexArray, "render", lambda self, *how, **more: calls.append(render(self, *how, **more))
    )
    found = []
    for server in servers:
        calls.clear()
        server.draw(View(Pose((0.05, 1.6, 0.1)), FOV), SIZE)
        found.append(len(calls))
    assert 1 <= found[0] - found[1] <= most


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


def test_the_veil_has_the_depth_of_the_nearest_sheet(serve):
    panes, view = random_panes(3), View(Pose((0, 1.6, 0)), FOV)
    parts = picture(serve, attrs.evolve(with_meshes(), meshes=tuple(panes)), view, LAYERS)
    sheets = [sheet(pane) for pane in panes]
    seen = look_through(sheets, view.pose.position_m, world_directions(view, SIZE).reshape(-1, 3))
    nearest = seen.inverse_depth.reshape(SIZE[::-1])
    safe = away_from_changes(seen.count.reshape(SIZE[::-1]))
    assert np.abs(parts["depth"] - nearest)[safe].max() <= 1e-4


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


class Standing:
    """A motion that stays where it is."""

    def __init__(self, pose: Pose) -> None:
        self._pose = pose

    def state(self, time_ns: int) -> RigidState:
        return RigidState(self._pose)


class Bent:
    def __init__(self, mesh: Mesh, step: tuple[float, float, float]) -> None:
        self._rest, self._step = mesh.positions, np.array(step)

    def positions(self, time_ns: int) -> np.ndarray:
        return self._rest + self._step * (time_ns * 1e-9)

    def velocities(self, time_ns: int) -> np.ndarray:
        return np.broadcast_to(self._step, self._rest.shape)


def test_panes_of_bodies_and_panes_that_deform_are_drawn_where_they_are(serve):
    view, quad = View(Pose((0, 1.6, 0)), FOV), Quad((0, 1.6, -1), (0.3, 0, 0), (0, 0.3, 0), -1, (0.2, 0.9, 0.4))
    still = pane("pane", attrs.evolve(quad, centre=(0.25, 1.6, -1)), opacity=0.5)
    moved = pane("pane", quad, opacity=0.5)
    bodies = (Body("b", Standing(Pose((0.25, 0, 0)))),)
    on_body = attrs.evolve(with_meshes(), bodies=bodies, meshes=(*with_meshes().meshes, attrs.evolve(moved, body=1)))
    bent = with_meshes(attrs.evolve(moved, deformation=Bent(moved, (0.25, 0, 0))))
    expected = picture(serve, with_meshes(still), view)["colour"]
    for scene in (on_body, bent):
        server = serve(scene)
        image = server.draw(view, SIZE, time_ns=1_000_000_000)
        differs = np.abs(read(image.colour) - expected).max(axis=-1) > 4 * HALF_UNIT
        assert differs.mean() < 0.02  # a last bit of the place decides at its edges


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
