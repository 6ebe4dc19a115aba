"""What a lens hides: which pixels that is, and that they are not drawn, warped or counted."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from replays import run
from worlds import read

from hmdwarp import Warper, warp_image
from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.geometry import Fov, Hidden, Pose, View
from hmdwarp.headsets import headset_toml, load_headset, reported_headset
from hmdwarp.metrics import Alike, Compared, PairPass, QualityJob, measure
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

SIZE = (61, 67)
SQUARE = Fov.from_tangents((-1, 1, -1, 1))
CORNER = ((-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0))  # half of the lower left quarter


def test_a_late_frame_sees_as_far_beyond_the_edge_as_beyond_the_border():
    hidden = Hidden((CORNER,), SQUARE)
    seen = hidden.seen(SQUARE, (40, 40))
    wide, size = SQUARE.guarded((1.25, 1.5), (40, 40))
    grown = hidden.within(wide).seen(wide, size)
    assert grown.shape == (60, 50)  # 5 pixels more to the sides, 10 above and below
    # By its definition: a pixel is needed if the head, turned by up to the guard band, sees it.
    wanted = np.zeros_like(grown)
    for y in range(21):
        for x in range(11):
            wanted[y : y + 40, x : x + 40] |= seen
    np.testing.assert_array_equal(grown, wanted)
    assert not grown[0, 0] and grown[-1].all()


def test_cracks_between_the_triangles_of_a_mesh_are_no_seen_pixels():
    # A fan whose triangles part by a thousandth of the view.
    ends = [(-1.0, -0.999 + 0.1 * k) for k in range(10)]
    fan = tuple(((-0.4, -1.0), (x, y), (x, y + 0.098)) for x, y in ends)
    rows = Hidden(fan, SQUARE).rows(SQUARE, (400, 400))
    assert (rows[:100, 0] > 0).all() and (rows[130:] == (0, 400)).all()


@pytest.mark.parametrize("guard", [1.0, 1.5])
def test_the_server_draws_what_can_be_seen_and_little_else(gpu, guard):
    headset, drawn = load_headset("index"), load_headset("index:hidden=drawn")
    server = Server(gpu, load_scene("room"))
    frames = [server.draw_frame(one.views(Pose((0, 1.6, 0))), 0, SIZE, guard) for one in (headset, drawn)]
    for eye in (0, 1):
        (found, whole), seen = (
            (frame.eyes[eye] for frame in frames),
            frames[0].eyes[eye].view.seen(frames[0].eyes[eye].size),
        )
        np.testing.assert_array_equal(read(found.colour)[seen], read(whole.colour)[seen])
        np.testing.assert_array_equal(read(found.inverse_depth)[seen], read(whole.inverse_depth)[seen])
        empty = read(found.colour)[..., 3] == 0
        # So small a picture has rectangles of one column.
        np.testing.assert_array_equal(empty, ~seen)
        assert (read(found.inverse_depth)[empty] == -1).all()
    server.close()


def test_figures_are_of_the_seen_pixels(tmp_path, gpu):
    common = {"gpu": gpu, "warp": "none", "fill": "none", "size": SIZE, "seconds": 0.1, "lens": "none"}
    found, whole = (run(tmp_path / name, headset=name, **common).summary for name in ("index", "index:hidden=drawn"))
    share = found["hidden"]["share"]
    assert share == pytest.approx(0.2488, abs=0.01) and "hidden" not in whole
    assert any("neither drawn, warped nor counted" in note for note in found["notes"])


def alike_of(gpu, shown: np.ndarray, truth: np.ndarray) -> Alike:
    measuring = PairPass(gpu, truth.shape[1::-1], 10.0)
    found = measuring.run(shown, truth)
    measuring.close()
    return found


def test_what_is_hidden_changes_no_figure(gpu):
    rng = np.random.default_rng(3)
    truth = rng.integers(0, 255, (67, 61, 3), dtype=np.uint8)
    shown = np.clip(truth.astype(int) + rng.integers(-20, 20, truth.shape), 0, 255).astype(np.uint8)
    view = View(Pose(), SQUARE, hidden=Hidden((((-1, -1), (1, -1), (1, 0), (-1, 0)),), SQUARE))
    seen = view.seen((61, 67))
    pair = [np.where(seen[..., None], picture, np.uint8(0)) for picture in (shown, truth)]
    late = {"covered": seen, "truth_inverse_depth": seen, "rendered": view, "rendered_size": (61, 67), "regions": True}
    found = measure(QualityJob(Compared(*pair, view), alike=alike_of(gpu, *pair), **late))
    half, counted = found.values, found.regions[:, 0]
    assert counted.sum() == seen.sum() and counted[-1] > 0.9 * seen.sum()
    upper = [picture[seen.all(axis=1)] for picture in (shown, truth)]
    alone = measure(QualityJob(Compared(*upper, View(Pose(), SQUARE)), alike=alike_of(gpu, *upper))).values
    assert half["psnr_db"] == pytest.approx(alone["psnr_db"], abs=1e-9)
    # Both compare pixels with those around them, at the outline with hidden ones too.
    assert half["flip"] == pytest.approx(alone["flip"], rel=0.1)
    assert half["ssim"] == pytest.approx(alone["ssim"], abs=0.02)


@pytest.mark.parametrize(
    "chain", ["iterative/pyramid", "iterative/memory+pyramid", "forward/interpolate", "mesh/stretch"]
)
def test_hidden_pixels_are_black_and_fill_no_hole_with_black(gpu, tmp_path, chain):
    warp, fill = chain.split("/")
    common = {"gpu": gpu, "size": (122, 134), "seconds": 0.1, "warp": warp, "fill": fill, "latency_ms": 100}
    found, whole = (run(tmp_path / name, headset=name, **common).summary for name in ("index", "index:hidden=drawn"))
    assert found["quality"]["hole_share"]["mean"] <= 2 * whole["quality"]["hole_share"]["mean"] + 0.001
    # Over another part of the scene: holes filled with black would cost several dB.
    assert found["quality"]["psnr_db"]["mean"] > whole["quality"]["psnr_db"]["mean"] - 1.5


@pytest.mark.parametrize("by", [warp_image, Warper])
def test_what_a_view_hides_is_a_hole_as_rendered_and_black_as_shown(gpu, by):
    """Another corner of each view, in which the late picture may hold anything."""
    other = tuple((-x, -y) for x, y in CORNER)
    late, shown = (
        View(Pose((x, 0, 0)), SQUARE, hidden=Hidden((corner,), SQUARE)) for x, corner in ((0, CORNER), (0.05, other))
    )
    colour = np.where(late.seen((64, 64))[..., None], np.uint8(180), np.array((255, 0, 90), np.uint8))
    arguments = colour, np.full((64, 64), 2.0), late, shown
    with Warper((64, 64), gpu=gpu) as warper:
        out = warper.warp(*arguments) if by is Warper else warp_image(*arguments, gpu=gpu)
    seen = shown.seen((64, 64))
    assert not out.colour[~seen].any() and 0.05 < 1 - seen.mean() < 0.2
    # A wall of one colour, from which 0.05 / 2 of a tangent of the right edge had been hidden.
    np.testing.assert_allclose(out.colour[seen], 180, atol=1)


def test_what_is_hidden_anew_turns_black(gpu):
    """Where the picture before showed light: a runtime may change its mask."""
    server, plan = Server(gpu, load_scene("room")), build_plan((), "iterative", "pyramid", "none", client_geometry=True)
    client = Compensator(gpu, plan, None, SIZE, SIZE, hides=True)
    for corner in (CORNER, tuple((-x, -y) for x, y in CORNER)):
        view = View(Pose((0, 1.6, 0)), SQUARE, hidden=Hidden((corner,), SQUARE))
        shown = read(client.run(PassInputs(server.draw(view, SIZE), view)).shown.texture)[::-1, :, :3]
        assert not shown[~view.seen(SIZE)].any() and shown[view.seen(SIZE)].any()
    client.close()
    server.close()


def test_the_mesh_of_a_runtime_is_kept_in_a_file(tmp_path):
    triangles_of = pytest.importorskip("hmdwarp.display.openxr.runtime").triangles_of
    # As XR_KHR_visibility_mask has it: on the plane z = -1, three indices a triangle.
    corner = triangles_of([(-1.0, -1.0), (-0.5, -1.0), (-1.0, -0.5), (1.0, 1.0)], [0, 1, 2])
    assert corner == (((-1.0, -1.0), (-0.5, -1.0), (-1.0, -0.5)),)
    assert triangles_of([(0.0, 0.0)], [0, 0, 1]) == triangles_of([(0.0, 0.0)], [0, 0]) == ()

    class Reported:
        def views(self, world_from_head):
            places = ((-0.032, corner), (0.032, ()))
            return tuple(
                View(world_from_head @ Pose((x, 0, 0)), SQUARE, Pose((x, 0, 0)), Hidden(mesh, SQUARE) if mesh else None)
                for x, mesh in places
            )

    found = reported_headset("mine", "HMD by a runtime", (300, 320), 72.0, Reported())
    (tmp_path / "mine.toml").write_text(headset_toml(found))
    again = load_headset(str(tmp_path / "mine.toml"))
    assert (again.eye_size_px, again.refresh_hz, again.ipd_m) == ((300, 320), 72.0, 0.064)
    assert [eye.hidden and eye.hidden.polygons for eye in again.eyes] == [corner, None]
    assert again.eyes[0].hidden_share == pytest.approx(1 / 32, abs=0.002)


@pytest.mark.parametrize("chain", ["iterative/none", "iterative/constant"])  # fused with the lens, and before it
def test_a_panel_shows_what_is_seen_as_ever_and_is_black_elsewhere(gpu, chain):
    """Both eyes by turns: what is left out is each one's own."""
    corners = tuple(((x, y), (x, 0.3 * y), (0.3 * x, y)) for x in (-1.2, 1.2) for y in (-1.4, 1.4))
    whole = load_headset("rift-dk1")
    headset = attrs.evolve(whole, eyes=tuple(attrs.evolve(eye, hidden=Hidden(corners, eye.fov)) for eye in whole.eyes))
    size, panels = (80, 100), []
    server = Server(gpu, load_scene("room"))
    for worn in (headset, whole):
        plan = build_plan((), *chain.split("/"), "radial", client_geometry=True)
        client = Compensator(gpu, plan, worn, size, size, hides=worn is headset)
        for _ in range(2):
            for eye in (0, 1):
                view = worn.views(Pose())[eye]
                panels.append(read(client.run(PassInputs(server.draw(view, size), view, eye=eye)).panel.texture))
        client.close()
    server.close()
    places = np.stack(np.meshgrid(*((np.arange(n) + 0.5) / n for n in size)), axis=-1)
    for number, (found, wanted) in enumerate(zip(panels[:4], panels[4:], strict=True)):
        x, y = np.moveaxis(np.abs(headset.through_lens(number % 2, places, "green")), -1, 0)
        # Along the edge of a corner x / 1.2 + y / 1.4 = 1.3; one shown pixel is 0.025 of that.
        beyond = x / 1.2 + y / 1.4 - 1.3
        light, as_ever = found[..., :3], wanted[..., :3]
        assert np.array_equal(light[beyond < -0.1], as_ever[beyond < -0.1])
        assert not light[beyond > 0.1].any() and as_ever[beyond > 0.1].any()
