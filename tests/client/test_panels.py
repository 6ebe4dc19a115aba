"""Panels on the client: where rays meet them, as sharp as before, hidden by what is nearer."""

from __future__ import annotations

import itertools

import attrs
import numpy as np
import pytest
from golden_pictures import assert_golden, sheet
from reference._rays import world_directions
from reference.raycast import cast_quads
from scipy.spatial.transform import Rotation
from worlds import read

from hmdwarp.base import SceneError
from hmdwarp.client import PassInputs, ShownPicture
from hmdwarp.client.effects import Tools
from hmdwarp.client.effects.text import HeldPanel, PanelsPass, box_of, panel_from_shown, panel_texture
from hmdwarp.client.lens import lenses
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate
from hmdwarp.headsets import load_headset
from hmdwarp.scenes import Panel, Scene
from hmdwarp.sources.server import Server

FOV = Fov(-0.6, 0.7, -0.5, 0.55)
TOOLS = Tools(carry=None, pictures=0)
BOTH = frozenset({"panels", "occluded_panels"})


def picture(size=(40, 30), channels=4, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (size[1], size[0], channels), dtype=np.uint8)


def turned(yaw=0.0, pitch=0.0, roll=0.0):
    return Rotation.from_euler("yxz", (yaw, pitch, roll)).as_quat()


def behind_of(size, seed=1):
    rng = np.random.default_rng(seed)
    light = np.concatenate([rng.uniform(0, 2, (*size[::-1], 3)), np.ones((*size[::-1], 1))], axis=2)
    light[rng.uniform(size=size[::-1]) < 0.2] = 0
    return light.astype(np.float16).astype(float)


def laid(gpu, panels, view, behind, *, depth=None, last=None, tools=TOOLS):
    """The pass's picture, drawn twice to the same bits."""
    size, gl = behind.shape[1::-1], gpu.gl
    held = [HeldPanel(panel, panel_texture(gpu, panel.pictures[0].image)) for panel in panels]
    canvas, into = Canvas(gl, size), Canvas(gl, size)
    canvas.texture.write(behind.astype(np.float16).tobytes(), alignment=1)
    shown_depth = allocate(gl, size, SCALAR)
    shown_depth.write(
        np.ascontiguousarray(np.broadcast_to(-1.0 if depth is None else depth, size[::-1]), "f4").tobytes()
    )
    empty = allocate(gl, (1, 1), COLOUR)
    inputs = PassInputs(EyeImage(view, empty, empty, {"panels": held}), view, shown_last=last)
    made = PanelsPass(gpu, BOTH, (1, 1), size, tools)
    found = []
    for _ in range(2):
        made.run(inputs, ShownPicture(canvas, shown_depth), into)
        gl.memory_barrier()
        found.append(read(into.texture))
    assert np.array_equal(*found), "two runs differ"
    return found[0]


CASES = {
    "straight on": Panel(picture(), Pose((0.0, 0.0, -1.0)), (0.8, 0.6)),
    "opaque": Panel(picture(channels=3), Pose((0.1, 0.05, -1.0)), (0.5, 0.4)),
    "turned": Panel(picture(), Pose((0.1, -0.05, -1.2), turned(0.9, 0.3, 0.4)), (0.9, 0.7)),
    "grazing": Panel(picture(), Pose((0.1, -0.2, -1.0), turned(0.2, -1.45)), (0.9, 1.7)),
    "small": Panel(picture(), Pose((0.03, 0.02, -9.0)), (0.05, 0.05)),
    "near": Panel(picture((7, 5)), Pose((0.01, 0.0, -0.08)), (0.3, 0.2)),
    "large": Panel(picture((300, 200)), Pose((0.0, 0.0, -2.0), turned(0.3)), (3.0, 2.0)),
    "through the eye's plane": Panel(picture(), Pose((0.3, 0.0, 0.1), turned(-1.4)), (2.0, 0.6)),
}


def test_panels_are_laid_over_as_before(gpu, tmp_path):
    view, size = View(Pose(), FOV), (64, 48)
    for tiny in ((3, 2), (1, 1)):
        assert np.isfinite(laid(gpu, [CASES["turned"]], view, behind_of(tiny))).all()
    pictures = [laid(gpu, [panel], view, behind_of(size)) for panel in CASES.values()]
    assert_golden("effects/panels", sheet(*((picture, None) for picture in pictures)), tmp_path)


def met_by_rays(panel: Panel, view: View, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(h, w) whether the ray of a pixel meets the panel, and (h, w, 2) where, from -1 to 1."""
    half = np.array(panel.size_m) / 2
    right, up = panel.pose.rotation.apply([(half[0], 0, 0), (0, half[1], 0)])
    rays = world_directions(view, size).reshape(-1, 3)
    hits = cast_quads([(panel.pose.position_m, right, up)], view.pose.position_m, rays)
    return (hits.shape >= 0).reshape(size[::-1]), hits.uv.reshape(*size[::-1], 2)


@pytest.mark.parametrize("name", ["straight on", "turned", "large"])
def test_each_quarter_of_a_panel_is_where_rays_meet_it(gpu, name):
    """Red, green, blue and white from below; clear of borders by a tenth of its half side."""
    view, behind = View(Pose((0.02, -0.01, 0.03), turned(0.02)), FOV), np.full((43, 61, 4), 0.25)
    quarters = np.array([[(0, 0, 255), (255, 255, 255)], [(255, 0, 0), (0, 255, 0)]], np.uint8)
    panel = attrs.evolve(CASES[name], pictures=quarters.repeat(32, axis=0).repeat(32, axis=1))
    met, uv = met_by_rays(panel, view, (61, 43))
    wider, _ = met_by_rays(attrs.evolve(panel, size_m=tuple(1.1 * np.array(panel.size_m))), view, (61, 43))
    clear = met & (np.abs(uv) > 0.1).all(axis=-1) & (np.abs(uv) < 0.9).all(axis=-1)
    expected = quarters[(uv[..., 1] < 0).astype(int), (uv[..., 0] > 0).astype(int)] / 255
    found = laid(gpu, [panel], view, behind)
    assert clear.sum() > 100
    assert np.abs(found[..., :3] - expected)[clear].max() < 0.05
    assert np.array_equal(found[~wider], behind[~wider])


def test_panels_are_seen_from_the_front_alone(gpu):
    behind = behind_of((64, 48))
    for pose in (
        Pose((0, 0, -1.0), turned(np.pi)),
        Pose((0, 0, 1.0)),
        Pose((0, 0, 1.0), turned(np.pi)),
        Pose((0.0, 0, 0)),
    ):
        assert np.array_equal(laid(gpu, [Panel(picture(), pose, (0.8, 0.6))], View(Pose(), FOV), behind), behind)
    edge_on = Pose((0.0, 0.0, -1.0), turned(np.pi / 2))
    assert np.array_equal(laid(gpu, [Panel(picture(), edge_on, (0.8, 0.6))], View(Pose(), FOV), behind), behind)


def test_head_locked_panels_ignore_the_head_and_follow_canted_eyes(gpu):
    behind, panel = behind_of((64, 48)), attrs.evolve(CASES["straight on"], head_locked=True)
    head_from_eye = Pose((-0.03, 0.0, 0.0), turned(0.2))
    heads = [Pose(), Pose((0.0, 1.6, 0.0)), Pose((3.0, 1.2, -5.0), turned(1.0, 0.3, -0.2))]
    views = [View(head @ head_from_eye, FOV, head_from_eye) for head in heads]
    found = [laid(gpu, [panel], view, behind) for view in views]
    assert np.array_equal(found[0], found[1]) and np.array_equal(found[0], found[2])
    assert np.array_equal(found[0], laid(gpu, [CASES["straight on"]], views[0], behind))
    assert not np.array_equal(found[0], behind)


def test_what_is_nearer_hides_panels_that_ask_for_it(gpu):
    """Left a thing at 0.9 m, right one at 1.1 m, between them unknown, before and behind 1 m."""
    view, behind = View(Pose(), FOV), np.ones((48, 64, 4))
    depth = np.where(np.arange(64) < 32, 1 / 0.9, 1 / 1.1) * np.ones((48, 1))
    depth[20:24] = -1.0  # unknown hides nothing
    plain, hidden = CASES["straight on"], attrs.evolve(CASES["straight on"], occluded=True)
    bare = laid(gpu, [plain], view, behind)
    assert np.array_equal(laid(gpu, [plain], view, behind, depth=depth), bare)
    found = laid(gpu, [hidden], view, behind, depth=depth)
    assert np.array_equal(found, np.where((depth > 1)[..., None], behind, bare))
    assert np.array_equal(laid(gpu, [hidden], view, behind, depth=1.0), bare), "it hangs on the wall"


def test_what_the_lens_hides_stays_hidden(gpu):
    behind = np.ones((48, 64, 4))
    behind[:, :32] = (0, 0, 0, 2.0**-14)  # as HiddenAreas.hide leaves it
    found = laid(gpu, [CASES["straight on"]], View(Pose(), FOV), behind)
    assert np.array_equal(found[:, :32], behind[:, :32])
    assert not np.array_equal(found[:, 32:], behind[:, 32:])


def test_what_the_display_composes_the_pass_leaves_to_it(gpu):
    behind, hidden = behind_of((64, 48)), attrs.evolve(CASES["turned"], occluded=True)
    handing = attrs.evolve(TOOLS, hands_panels_on=True)
    found = laid(gpu, [CASES["straight on"], hidden], View(Pose(), FOV), behind, tools=handing)
    assert np.array_equal(found, laid(gpu, [hidden], View(Pose(), FOV), behind))
    assert not np.array_equal(found, behind)


def test_the_nearer_of_two_panels_is_in_front(gpu):
    white, black = (np.full((4, 4, 3), light, np.uint8) for light in (255, 0))
    near, far = Panel(white, Pose((0, 0, -1.0)), (0.2, 0.2)), Panel(black, Pose((0, 0, -2.0)), (2.0, 2.0))
    for panels in ([near, far], [far, near]):
        server = Server(gpu, Scene("panels", "", (), panels=panels))
        drawn = read(server.draw(View(Pose(), FOV), (64, 48)).colour)
        server.close()
        for found in (laid(gpu, panels, View(Pose(), FOV), np.full((48, 64, 4), 0.5)), drawn):
            assert found[21, 29, 0] == pytest.approx(1, abs=1e-3)
            assert found[21, 12, 0] < 1e-6


def test_each_row_of_a_scan_out_has_the_pose_of_its_instant(gpu):
    """Each row is that of a whole picture with the view of its instant."""
    size, behind = (64, 48), np.ones((48, 64, 4))
    first, last = View(Pose(), FOV), View(Pose((0, 0, 0), turned(0.05)), FOV)
    found = laid(gpu, [CASES["straight on"]], first, behind, last=last)
    for row in (1, 23, 46):
        share = 1 - (row + 0.5) / size[1]
        view = attrs.evolve(first, pose=first.pose.towards(last.pose, share))
        alone = laid(gpu, [CASES["straight on"]], view, behind)
        # The parabola is off by 0.05^3 / (72 sqrt 3) rad, 1e-6: 5e-5 pixels, so texels.
        assert np.abs(found[row] - alone[row]).max() < 2e-3


@pytest.mark.parametrize("name", [name for name in CASES if name != "small"])  # than a pixel
def test_the_box_holds_all_that_is_seen(name):
    size, view = (64, 48), View(Pose(), FOV)
    rows, columns = np.nonzero(met_by_rays(CASES[name], view, size)[0])
    box = box_of([panel_from_shown(CASES[name], view, size)], size)
    assert len(rows)
    assert box[0] <= columns.min() and box[1] <= rows.min()
    assert columns.max() < box[2] and rows.max() < box[3]


def test_panels_that_cannot_be_are_refused_in_one_line():
    for arguments, message in (
        ({"size_m": (0.0, 1.0)}, "a panel is 0 x 1 m: expected finite lengths above 0"),
        ({"size_m": 3}, "a panel's size is 3: expected width and height in metres"),
        ({"pictures": np.zeros((4, 4), np.uint8)}, "expected .h, w, 3 or 4. uint8, found"),
        ({"pictures": np.zeros((4, 4, 3))}, "expected .h, w, 3 or 4. uint8, found"),
        ({"pictures": ()}, "a panel of 0 pictures for 1 s each"),
        ({"seconds": 0.0}, "a panel of 1 pictures for 0 s each"),
    ):
        with pytest.raises(SceneError, match=message) as caught:
            Panel(**{"pictures": picture(), "pose": Pose(), "size_m": (1, 1), **arguments})
        assert "\n" not in str(caught.value)


def test_through_the_lens_it_is_as_before(gpu, tmp_path):
    """A panel that fills the view, magnified: each colour is one bilinear sample of its place."""
    pictures = []
    for name, eye in itertools.product(("rift-dk1", "cardboard-v2"), (0, 1)):
        chosen = load_headset(name)
        view = chosen.views(Pose((0.0, 1.6, 0.0)))[eye]
        panel = Panel(picture((24, 20), 3), Pose(view.pose.position_m + (0.0, 0.0, -0.5)), (2.4, 2.0))
        pictures.append(through_lens(gpu, panel, view, chosen, eye, (67, 53), (61, 83)))
    left, right = pictures[0], pictures[1][:, ::-1]
    assert ((left[..., 1] != 1) == (right[..., 1] != 1)).mean() > 0.9, "the right eye mirrors the left"
    assert_golden("effects/panels-through-a-lens", sheet(*((each, None) for each in pictures)), tmp_path)


def test_each_row_of_a_display_with_a_lens_has_the_pose_of_its_instant(gpu):
    """As without one: each row is that of a whole picture with the view of its instant."""
    chosen, shown_size, size = load_headset("rift-dk1"), (67, 53), (61, 83)
    first = chosen.views(Pose())[0]
    last = attrs.evolve(first, pose=first.pose @ Pose((0, 0, 0), turned(0.05)))
    panel = Panel(picture((24, 20), 3), Pose(first.pose.position_m + (0.0, 0.0, -0.5)), (2.4, 2.0))
    found = through_lens(gpu, panel, first, chosen, 0, shown_size, size, last)
    for row in (8, 40, 74):
        share = 1 - (row + 0.5) / size[1]
        view = attrs.evolve(first, pose=first.pose.towards(last.pose, share))
        alone = through_lens(gpu, panel, view, chosen, 0, shown_size, size)
        assert np.abs(found[row] - alone[row]).max() < 5e-3, row


def through_lens(gpu, panel, view, headset, eye, shown_size, size, last=None):
    """The pass's picture over a grey display."""
    gl, lens = gpu.gl, lenses.get(headset.lens.model)(gpu, headset, size)
    made = PanelsPass(gpu, frozenset({"panels"}), (1, 1), shown_size, attrs.evolve(TOOLS, lens=lens))
    canvas, empty = Canvas(gl, size), allocate(gl, (1, 1), COLOUR)
    canvas.texture.write(np.full((*size[::-1], 4), 1, np.float16).tobytes(), alignment=1)
    held = HeldPanel(panel, panel_texture(gpu, panel.pictures[0].image))
    inputs = PassInputs(EyeImage(view, empty, empty, {"panels": [held]}), view, eye, shown_last=last)
    made.run_through_lens(inputs, canvas)
    gl.memory_barrier()
    return read(canvas.texture)
