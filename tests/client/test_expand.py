"""Foveated frames: what the server sends, and what the client makes of it again."""

from __future__ import annotations

import math
from pathlib import Path

import attrs
import numpy as np
import pytest
from eyes import with_eyes
from hypothesis import given
from hypothesis import strategies as st
from reference import foveated as twin
from replays import each_refresh, small
from scipy.spatial.transform import Rotation
from worlds import pixels

from hmdwarp.base import InputError, PlanError
from hmdwarp.client import PassInputs, build_plan, parse_warp
from hmdwarp.client.effects import ExpandPass, Tools
from hmdwarp.client.warps import Output
from hmdwarp.frames import EyeImage, EyeSizes, Needs, frame_bytes
from hmdwarp.frames.layers.pictures import FoveatedPicture
from hmdwarp.geometry import Fov, Fovea, FoveaGrid, Pose, View, WarpMap, grid_of
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate
from hmdwarp.headsets import load_headset
from hmdwarp.link import LinkOptions
from hmdwarp.poses import known_gaze, synthesise, write_synthetic
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

FOVEA = Fovea(30.0, 3)
BOTH = Needs(foveated=FOVEA, foveated_depth=FOVEA)
FOV = Fov.symmetric(1.4, 1.2)
ROUNDING = 2.0**-15  # Sums of up to 16 x 16 numbers in float32, each step rounded by 2^-24, and a quotient
HALF = 2.0**-10 + ROUNDING  # what is stored as a half is off by 2^-10 of it where a driver cuts rather than rounds
# Rim alone at one side or none, one sharp pixel, odd sizes, wider than a work group.
GRIDS = [
    FoveaGrid((rim * (a + c) + w, rim * (b + d) + h), rim, (a, b), (c, d))
    for rim, a, b, c, d, w, h in [
        (2, 0, 0, 0, 1, 1, 1), (3, 5, 0, 0, 4, 1, 9), (4, 3, 2, 4, 6, 13, 7), (5, 0, 0, 0, 0, 9, 5),
        (4, 9, 1, 9, 1, 70, 3),
    ]
]  # fmt: skip
on_grids = pytest.mark.parametrize(("grid", "seed"), [(grid, seed) for seed, grid in enumerate(GRIDS)])


def sent_and_expanded(gpu, colour: np.ndarray, depth: np.ndarray, grid: FoveaGrid) -> list[np.ndarray]:
    """Colour and depth as they are sent, and as the client has them; all bottom row first."""
    found, whole = [], (allocate(gpu.gl, grid.size, COLOUR), allocate(gpu.gl, grid.size, SCALAR))
    whole[0].write(np.ascontiguousarray(colour, np.float16), alignment=1)
    whole[1].write(np.ascontiguousarray(depth, np.float32), alignment=1)
    sent = []
    for number, (texture, kind) in enumerate(zip(whole, (COLOUR, SCALAR), strict=True)):
        into = allocate(gpu.gl, grid.small, kind)
        program = gpu.shaders.compute("server/foveate.comp", DEPTH=number)
        texture.bind_to_image(0, read=True, write=False)
        into.bind_to_image(1, read=False, write=True)
        program.uniforms.set(picture=0, foveated=1, **grid.uniforms)
        program.run(*grid.small)
        sent.append(into)
    gpu.barrier()
    data = {name: FoveatedPicture(texture, grid) for name, texture in zip(BOTH, sent, strict=True)}
    expand = ExpandPass(gpu, frozenset(BOTH), grid.size, (8, 6), Tools(None, 1))
    inputs = PassInputs(EyeImage(View(Pose(), FOV), *whole, data), View(Pose(), FOV))
    rendered = expand.run(inputs).rendered
    found = [pixels(each) for each in (*sent, rendered.colour, rendered.inverse_depth)]
    expand.close()
    for texture in (*whole, *sent):
        texture.release()
    return found


def picture(seed: int, size: tuple[int, int], holes: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """Noise with holes; two planes, of which one is five times as near."""
    rng, (w, h) = np.random.default_rng(seed), size
    x, y = np.meshgrid((np.arange(w) + 0.5) / w, (np.arange(h) + 0.5) / h)
    depth = np.where(x + 0.4 * np.sin(9 * y) > 0.5, 2 + 0.02 * x + 0.01 * y, 0.4 + 0.004 * y).astype(np.float32)
    colour = np.dstack([rng.uniform(0, 2, (h, w, 3)), np.ones((h, w))]).astype(np.float16)
    empty = rng.uniform(size=(h, w)) < holes
    colour[empty], depth[empty] = 0, -1
    return colour.astype(np.float64), depth.astype(np.float64)


@on_grids
def test_shaders_are_their_twins_and_the_sharp_part_is_bit_for_bit(gpu, grid, seed):
    colour, depth = picture(seed, grid.size)
    small_colour, small_depth, again, depth_again = sent_and_expanded(gpu, colour, depth, grid)
    assert np.allclose(small_colour, twin.foveated(colour, grid), rtol=HALF, atol=2.0**-24)
    assert np.allclose(small_depth, twin.foveated_depth(depth, grid), rtol=ROUNDING)
    assert np.allclose(again, twin.expanded(small_colour, grid), rtol=HALF, atol=2.0**-24)
    assert np.allclose(depth_again, twin.expanded_depth(small_depth, grid), rtol=ROUNDING)
    x, y, w, h = grid.sharp
    sharp = np.s_[y : y + h, x : x + w]
    assert np.array_equal(again[sharp], colour[sharp]) and np.array_equal(depth_again[sharp], depth[sharp])


# --- the grid -----------------------------------------------------------------------------------


any_fovea = given(
    st.floats(1, 120), st.integers(2, 16), st.tuples(st.integers(1, 3000), st.integers(1, 3000)),
    st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)),
)  # fmt: skip


@any_fovea
def test_a_grid_holds_each_pixel_once_whatever_the_size_and_gaze(degrees, rim, size, gaze):
    fovea = Fovea(degrees, rim)
    straight, aside = (fovea.grid(View(Pose(), FOV, gaze=each), size) for each in (None, gaze))
    assert straight.small == aside.small == fovea.small(FOV, size, size), "a video has one size"
    for grid in (straight, aside):
        across, up = twin.counts(grid)
        assert (across.sum(), up.sum()) == size and (len(across), len(up)) == grid.small
        assert grid_of(grid.numbers(), grid.small) == grid


def test_the_sharp_part_is_around_the_gaze_in_each_eye_of_a_canted_headset():
    """Within half a rim pixel, and the degrees asked for at the axis."""
    headset, size = load_headset("index"), (1440, 1600)
    direction = np.array([0.2, -0.1, -1.0]) / math.sqrt(1.05)
    for view in headset.views(Pose()):
        grid = FOVEA.grid(attrs.evolve(view, gaze=tuple(direction)), size)
        x, y, w, h = grid.sharp
        seen = view.head_from_eye.rotation_matrix.T @ direction
        pixel = view.fov.pixel_from_tangent(size) @ (seen[0] / -seen[2], seen[1] / -seen[2], 1)
        assert abs(x + w / 2 - pixel[0]) <= 1.5 and abs(y + h / 2 - pixel[1]) <= 1.5
        left, right, down, up = view.fov.tangents
        assert abs(w - 2 * math.tan(math.radians(15)) * size[0] / (right - left)) <= 3
        assert abs(h - 2 * math.tan(math.radians(15)) * size[1] / (up - down)) <= 3


# --- sampled where it lies ----------------------------------------------------------------------


@on_grids
def test_a_turned_head_samples_between_the_same_centres(gpu, grid, seed):
    """As its place among the centres of columns and rows says; bit for bit at the sharp ones."""
    colour, depth = picture(seed, grid.size, holes=0.0)
    texture, into = allocate(gpu.gl, grid.small, COLOUR), Canvas(gpu.gl, grid.size)
    small_colour = sent_and_expanded(gpu, colour, depth, grid)[0]
    texture.write(np.ascontiguousarray(small_colour, np.float16), alignment=1)
    warp = parse_warp("rotation").entry(gpu, grid.size, grid.size, None, Output(foveated=FOVEA))
    rendered = EyeImage(View(Pose(), FOV), texture, texture, {"foveated": FoveatedPicture(texture, grid)})
    for degrees in (0.0, 3.0):
        turned = View(Pose((0, 0, 0), Rotation.from_euler("yxz", [degrees] * 3, degrees=True).as_quat()), FOV)
        warp.run(PassInputs(rendered, turned), into)
        found = pixels(into.texture)
        to_rendered = WarpMap.between(turned, grid.size, rendered.view, grid.size)
        centres = np.stack(np.meshgrid(*(np.arange(side) + 0.5 for side in grid.size)), axis=-1)
        place = to_rendered.apply(centres, np.zeros(centres.shape[:2]))[0]
        covered = ((place >= 0) & (place < grid.size)).all(axis=-1)
        expected = twin.sampled(small_colour, grid, place)
        # The map is off by 3e-7 of a side in float32, over a change of at most 2 from pixel
        # to pixel, on each axis; beside the border either may be.
        sure = np.abs(np.minimum(place, np.array(grid.size) - place)).min(axis=-1) > 1e-4
        assert (found[sure][:, 3] == covered[sure]).all()
        both = sure & covered
        assert np.allclose(found[both], expected[both], rtol=HALF, atol=2 * 2 * 3e-7 * max(grid.size) + 2.0**-24)
        x, y, w, h = grid.sharp
        sharp = np.s_[y : y + h, x : x + w]
        assert degrees or np.array_equal(found[sharp], colour[sharp])
    warp.close()
    into.release()
    texture.release()


# --- frames and runs ----------------------------------------------------------------------------


def test_a_frame_has_it_for_both_eyes_of_a_canted_headset_with_guard_band_and_hidden_area(gpu):
    headset, size = load_headset("index"), (97, 73)
    server = Server(gpu, load_scene("planes"))
    views = headset.views(Pose((0, 1.6, 1.0)))
    frame = server.draw_frame(views, 0, size, 1.2, BOTH)
    for eye in frame.eyes:
        data, depth = eye["foveated"], eye["foveated_depth"]
        assert data.grid == depth.grid == FOVEA.grid(eye.view, eye.size) and data.texture.size == data.grid.small
        assert np.allclose(pixels(data.texture), twin.foveated(pixels(eye.colour), data.grid), rtol=HALF, atol=2e-7)
        found = twin.foveated_depth(pixels(eye.inverse_depth), data.grid)
        assert np.mean(np.isclose(pixels(depth.texture), found, rtol=ROUNDING)) > 0.999, "but at a threshold"
        sizes = EyeSizes(eye.size, size, tuple(view.fov for view in views))
        assert frame_bytes(BOTH, sizes, eyes=1)["rendered.foveated"] == 8 * math.prod(data.grid.small)
    server.recycle(frame)
    assert not any(server.pool(data.grid.small, depth=False).live for data in (data, depth))
    server.close()


def test_the_sharp_part_follows_the_gaze_as_late_as_the_head(tmp_path):
    made = with_eyes(synthesise("look-around", seconds=3))
    with (tmp_path / "looking.csv").open("w", encoding="utf-8") as file:
        write_synthetic(made, file)
    options = {"trace": str(tmp_path / "looking.csv"), "latency_ms": 50.0, "seconds": 1.5, "fovea_deg": 20.0}
    places = set()

    def look(setup, number, refresh):
        eye, head = refresh.frame.eyes[1], refresh.frame.head.pose
        assert eye.view.gaze == pytest.approx(known_gaze(setup.track, refresh.frame.drawn_ns, head), abs=1e-12)
        assert eye["foveated"].grid == Fovea(20.0).grid(eye.view, eye.size)
        places.add(eye["foveated"].grid.before)

    each_refresh(small(**options), look)
    assert len(places) > 5


def test_a_warp_that_reads_no_depth_gets_none_and_one_without_pictures_nothing(gpu):
    known = {"client_geometry": True, "fovea": FOVEA}
    for warp, expands in (("rotation", False), ("rotation:resample=catmull-rom", True)):
        plan = build_plan((), warp, "none", "none", **known)
        assert plan.layers == ("rendered.foveated",) and plan.expands == expands
    assert build_plan((), "rotation", "pyramid", "none", **known).expands, "the fill reads depth"
    model = build_plan((), "model", "none", "none", **known)
    assert not model.foveated and ("expand", "nothing reads the picture that would come foveated") in model.left_out
    with pytest.raises(PlanError, match="expand needs layer 'foveated' from the server"):
        build_plan((), "planar", "none", "none", brings=("rendered.colour",), **known)


def test_frames_that_cannot_be_foveated_are_refused():
    for sets, why in (
        ({"network": LinkOptions(send="changes"), "fovea_deg": 30.0}, "eyes move where nothing else does"),
        (
            {"frames": Path("nowhere"), "trace": "", "fovea_deg": 30.0},
            "recorded frames are one eye's, as its camera took them",
        ),
        ({"rim": 3}, "--rim 3: frames are as sharp everywhere; it is for --fovea"),
    ):
        with pytest.raises(InputError, match=why):
            small(**sets)
