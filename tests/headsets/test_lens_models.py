"""Lenses: the polynomial and where it folds, tables of angles, SteamVR's configuration."""

from __future__ import annotations

import itertools
import json
import math
import re

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from panels import in_two_passes, panel_of, world_before
from replays import run
from scipy.interpolate import PchipInterpolator
from worlds import read

from hmdwarp.base import InputError
from hmdwarp.client.lens import lenses
from hmdwarp.gpu import Canvas
from hmdwarp.headsets import COLOURS, MAX_COEFFICIENTS, Headset, RadialLens, TableLens, ViveLens, load_headset

from .bad_files import refusal


def lens(*green: float, reach: float = 1.5, per_unit: float = 0.9) -> RadialLens:
    return RadialLens((0.005, 0.0), 0.04, per_unit, {"red": (1.0,), "green": green, "blue": (1.0, 0.1)}, reach)


# Growing polynomials: all coefficients positive, the first one well so.
GROWING = st.builds(
    lambda first, rest: (first, *rest), st.floats(0.3, 2), st.lists(st.floats(0, 0.5), max_size=MAX_COEFFICIENTS - 1)
)


@given(GROWING, st.floats(-1, 1), st.floats(-1, 1))
def test_the_formula(coefficients, x, y):
    r2 = x * x + y * y
    wanted = np.array([x, y]) * 0.9 * sum(k * r2**i for i, k in enumerate(coefficients))
    assert lens(*coefficients).tangents("green", np.array([x, y])) == pytest.approx(wanted, rel=1e-12, abs=1e-300)


def test_a_fold_inside_the_panel_is_refused_with_its_radius():
    """r + k r^3 turns where 1 + 3 k r^2 = 0, and 1 - 3 r^2 + 2 r^4 at 0.7071 and again at 1."""
    for k in (-0.2, -0.5, -1.0, -5.0):
        fold = math.sqrt(-1 / (3 * k))
        with pytest.raises(InputError, match=f"green folds back at r = {fold:.4g}, within"):
            lens(1.0, k, reach=fold * 1.01)
        lens(1.0, k, reach=fold * 0.99)
    with pytest.raises(InputError, match=r"r = 0\.7071,"):
        lens(1.0, -1.0, 0.4, reach=1.5)
    lens(1.0, -0.9, 0.4, reach=1.5)
    for coefficients in ((0.0, 1.0), (-1.0,), (0.0,), (-1e-12, 5.0)):
        with pytest.raises(InputError, match="folds back at r = 0,"):
            lens(*coefficients)


@given(st.lists(st.floats(-1, 1), min_size=1, max_size=5))
@example([1e-13, -1.0, 1e-13])  # a small root beside a large one
@example([1.0, -1.0, 5e-301])
def test_any_polynomial_is_refused_or_grows(coefficients):
    try:
        made = lens(*coefficients)
    except InputError:
        return
    r = np.linspace(0, made.reach, 500)
    tangents = made.tangents("green", np.stack([r, np.zeros_like(r)], axis=-1))[:, 0]
    # A double root of the slope is a point of rest, not a turn. The slope may be 1e-12 of its terms
    # below 0 there (they are below 9 * 1.5^8 = 231 each), over a step of 0.003.
    assert np.diff(tangents).min() >= -1e-12


# --- lenses that are no polynomial in r^2 ---------------------------------------------------------


ANGLES = (0, 10, 20, 30, 35, 40, 45, 48.3073)
DISTANCES = (0, 0.247, 0.48, 0.696, 0.799, 0.8906, 0.963, 1)
TABLE = f"""
name = "pancake"
summary = "a pancake lens by its table"
source = "public default profile of the MeganeX superlight 8K (MIT)"
[panel]
eye_size_px = [72, 60]
eye_size_m = [0.06, 0.05]
refresh_hz = 90
[eyes]
ipd_m = 0.064
[fov_deg]
left = -48
right = 48
down = -44
up = 44
[lens]
model = "table"
axis_from_centre_m = [0.002, -0.001]
unit_m = 0.03
angle_deg = {list(ANGLES)}
red = {[round(0.99 * d, 4) for d in DISTANCES]}
green = {list(DISTANCES)}
blue = {[round(1.01 * d, 4) for d in DISTANCES]}
"""


def colour(name: str, x: float, *k: float) -> dict[str, object]:
    return {name: {"center_x": x, "center_y": 0.01, "coeffs": ([*k] + [0.0] * 8)[:8], "type": "DISTORT_DPOLY3"}}


def vive_json() -> dict[str, object]:
    """Written from the format's description; its numbers are made up."""

    def eye(side: int) -> dict[str, object]:
        c, s = math.cos(math.radians(5)), math.sin(math.radians(5))
        return {
            **colour("distortion_red", side * -0.08, -0.18, -0.08, 0.01, 0.003),
            **colour("distortion", side * -0.081, -0.2, -0.08, 0.01, 0.002),
            **colour("distortion_blue", side * -0.082, -0.23, -0.08, 0.01),
            "eye_to_head": [[c, 0, -side * s], [0, 1, 0], [side * s, 0, c]],
            "grow_for_undistort": 0.6,
            "intrinsics": [[1.2, 0, side * -0.08], [0, 1.08, 0.01], [0, 0, -1]],
            "undistort_r2_cutoff": 1.2,
        }

    return {
        "device": {
            "eye_target_width_in_pixels": 72,
            "eye_target_height_in_pixels": 80,
            "physical_aspect_x_over_y": 0.9,
        },
        "lens_separation": 0.063,
        "tracking_to_eye_transform": [eye(-1), eye(1)],
    }


@pytest.fixture
def pancake(tmp_path) -> Headset:
    (tmp_path / "pancake.toml").write_text(TABLE)
    return load_headset(str(tmp_path / "pancake.toml"))


@pytest.fixture
def vive(tmp_path) -> Headset:
    (tmp_path / "vive.json").write_text(json.dumps(vive_json()))
    return load_headset(str(tmp_path / "vive.json"))


def shown_tangents(headset: Headset, eye: int, size: tuple[int, int], name: str) -> np.ndarray:
    """(h, w, 2) what each panel pixel shows, NaN for nothing: straight from the formulas."""
    lens, panel = headset.eyes[eye].lens, np.array(headset.eyes[eye].panel_m)
    pixels = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in size)), axis=-1)
    from_middle = (pixels / size - 0.5) * panel
    if isinstance(lens, TableLens):
        from_axis = (from_middle - lens.axis_from_centre_m) / 0.03
        r, way = np.hypot(*from_axis.T).T, np.arctan2(from_axis[..., 1], from_axis[..., 0])
        angle = np.radians(PchipInterpolator(lens.distances[name], ANGLES, extrapolate=False)(r))
        return np.tan(angle)[..., None] * np.stack([np.cos(way), np.sin(way)], axis=-1)
    assert isinstance(lens, ViveLens)
    told = vive_json()["tracking_to_eye_transform"][eye]  # type: ignore[index]
    block = told[{"red": "distortion_red", "green": "distortion", "blue": "distortion_blue"}[name]]
    place = from_middle * (1, -1) - (block["center_x"], block["center_y"])  # +y is down there
    r2, (k1, k2, k3, k4, *_) = (place**2).sum(axis=-1, keepdims=True), block["coeffs"]
    tangent = place * (1 / (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) + k4) / told["intrinsics"][0][0] * (1, -1)
    return np.where(r2 <= told["undistort_r2_cutoff"], tangent, np.nan)


@pytest.mark.parametrize("name", ["pancake", "vive"])
def test_the_headset_says_what_the_formulas_say(request, name):
    headset = request.getfixturevalue(name)
    if name == "vive":
        assert headset.cants_deg == pytest.approx((5, 5)) and headset.ipd_m == pytest.approx(0.063)
        assert headset.eye_size_px == (72, 80) and headset.aspect == pytest.approx(0.9)
    places = np.stack(np.meshgrid((np.arange(41) + 0.5) / 41, (np.arange(37) + 0.5) / 37), axis=-1)
    for eye, wanted_colour in itertools.product((0, 1), COLOURS):
        wanted = shown_tangents(headset, eye, (41, 37), wanted_colour)
        seen = ~np.isnan(wanted)  # beyond a cutoff the formula goes on
        assert headset.through_lens(eye, places, wanted_colour)[seen] == pytest.approx(wanted[seen], abs=1e-9)


@pytest.mark.parametrize("name", ["pancake", "vive"])
@pytest.mark.parametrize("eye", [0, 1])
def test_the_pass_shows_what_the_formulas_say(gpu, request, name, eye):
    """Of a picture whose colour is its place: the panel shows where it looked."""
    headset, size, panel_size = request.getfixturevalue(name), (160, 128), (41, 37)
    v, u = np.mgrid[: size[1], : size[0]]
    canvas, panel = Canvas(gpu.gl, size), Canvas(gpu.gl, panel_size)
    for axis, places in enumerate(((u + 0.5) / size[0], (v + 0.5) / size[1])):
        shown = np.dstack([places] * 3 + [np.ones_like(places)])
        canvas.texture.write(shown.astype(np.float16).tobytes(), alignment=1)
        lenses.get(headset.lens.model)(gpu, headset, panel_size).run(canvas, headset.eyes[eye].fov, eye, panel)
        gpu.gl.memory_barrier()
        out = read(panel.texture)
        tangents, low = headset.eyes[eye].fov.tangents, headset.eyes[eye].fov.tangents[2 * axis]
        for channel, wanted_colour in enumerate(COLOURS):
            found = shown_tangents(headset, eye, panel_size, wanted_colour)
            span = tangents[1::2] - tangents[::2]
            place = (found - tangents[::2]) / span
            # Half a pixel inside: the sampler repeats the border, and an edge may fall either way.
            inside = (place > 0.51 / np.array(size)).all(axis=-1) & (place < 1 - 0.51 / np.array(size)).all(axis=-1)
            outside = ~((place > -1e-4) & (place < 1 + 1e-4)).all(axis=-1)
            assert inside.mean() > 0.4 and np.all(out[..., channel][outside] == 0)
            # Half floats: 2^-11 of 1 for the picture and for the result; the table's rows 1e-5.
            wanted = (found[..., axis] - low) / span[axis]
            assert np.abs(out[..., channel] - wanted)[inside].max() <= 2**-10 + 2e-5
    canvas.release()
    panel.release()


@pytest.mark.parametrize("name", ["pancake", "vive"])
@pytest.mark.parametrize("warp", ["rotation", "iterative:resample=bilinear"])
def test_fused_is_the_lens_after_the_warp(gpu, request, name, warp):
    """An unmoved head looks at the same places: one resample is the lens pass of the picture."""
    headset, size = request.getfixturevalue(name), (64, 64)
    world = world_before(gpu, headset, 0, 5, size, moved=False)
    fused = panel_of(gpu, world, warp, headset, 0, (40, 36), lens=headset.lens.model)
    two = in_two_passes(gpu, world, warp, headset, 0, (40, 36), lens=headset.lens.model)
    same = np.abs(fused - two).max(axis=-1) <= 2**-9
    assert same.mean() > 0.5 and (fused[..., 3] > 0).any()


@pytest.mark.parametrize("name", ["pancake.toml", "vive.json"])
def test_a_file_drives_a_replay(gpu, tmp_path, name):
    (tmp_path / name).write_text(TABLE if name.endswith("toml") else json.dumps(vive_json()))
    headset = load_headset(str(tmp_path / name))
    options = {"headset": str(tmp_path / name), "lens": headset.lens.model, "size": (40, 36), "seconds": 0.05}
    made = run(tmp_path / "out", gpu=gpu, **options)
    assert made.summary["lens"] == headset.lens.model
    with pytest.raises(InputError, match=f"has a lens of model {headset.lens.model}: use --lens"):
        run(tmp_path / "other", gpu=gpu, **{**options, "lens": "radial"})


@given(st.lists(st.floats(0.01, 1), min_size=2, max_size=9))
def test_a_table_grows_to_its_last_angle_and_shows_nothing_beyond(steps):
    distances = tuple(np.concatenate([[0], np.cumsum(steps)]).tolist())
    angles = tuple(np.linspace(0, 50, len(distances)).tolist())
    lens = TableLens((0, 0), 0.03, angles, dict.fromkeys(COLOURS, distances))
    r = np.linspace(1e-6, distances[-1], 400)
    shown = r * lens.scales("green", r)
    assert (np.diff(shown) > 0).all() and math.degrees(math.atan(shown[-1])) == pytest.approx(50)
    assert np.isnan(lens.scales("green", np.array([distances[-1] * 1.01]))).all()


VIVE = json.dumps(vive_json())


@pytest.mark.parametrize(
    ("text", "found", "put", "says"),
    [
        (TABLE, "0.48, 0.696", "0.7, 0.696", "lens table green does not grow at 30 degrees"),
        (TABLE, "angle_deg = \\[0, 10", "angle_deg = [0, 30", "lens table angle_deg does not grow at 20 degrees"),
        (TABLE, "green = \\[0, ", "green = [", r"lens table green has 7 values from 0\.247"),
        (TABLE, "48.3073\\]", "91]", "ends at 91: expected less than 89"),
        (TABLE, '"table"', '"tables"', "unknown lens model 'tables': known is radial, table"),
        (VIVE, r', \{"distortion_red": \{"center_x": -0.08,.*\]', "]", "has 1 eyes: expected the left one and the"),
        (VIVE, "-0.23, ", "-2.3, ", "the lens of blue folds back at r = "),
        (VIVE, "DISTORT_DPOLY3", "DISTORT_POLY3", "type is 'DISTORT_POLY3': expected DISTORT_DPOLY3"),
        (VIVE, '"distortion"', '"distorted"', "the key tracking_to_eye_transform.distortion is missing"),
        (VIVE, '"intrinsics": \\[\\[1.2', '"intrinsics": [[0', "focal is 0"),
        (VIVE, "\\{", "[", "this is no JSON"),
        (VIVE, '"tracking_to', '"tracking', "neither SteamVR's configuration"),
    ],
)
def test_a_bad_lens_is_one_line(tmp_path, text, found, put, says):
    changed = re.sub(found, put, text)
    assert changed != text
    assert re.search(says, refusal(tmp_path, changed, "mine.json" if text is VIVE else "mine.toml"))


def hmdq_json() -> dict[str, object]:
    """As hmdq writes it of OpenVR: the left eye's hidden triangle lies in 0..1 of its view."""
    eyes = {"Left": -1, "Right": 1}
    tangents = {"tan_left": -1.2, "tan_right": 1.0, "tan_bottom": -1.1, "tan_top": 0.9}
    geometry = {
        "rec_rts": [64, 60],
        "raw_eye": dict.fromkeys(eyes, tangents),
        "eye2head": {eye: [[1, 0, 0, side * 0.031], [0, 1, 0, 0], [0, 0, 1, 0]] for eye, side in eyes.items()},
        "ham_mesh": {"Left": {"verts_raw": [[0, 1], [0, 0.5], [0.5, 1]]}, "Right": None},
    }
    return {"misc": {"log_ver": 5}, "openvr": {"geometry": geometry}}


def test_an_export_of_hmdq(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(hmdq_json()))
    headset = load_headset(str(path))
    assert headset.eye_size_px == (64, 60) and headset.ipd_m == pytest.approx(0.062) and headset.lens is None
    left, right = headset.eyes
    assert left.fov.tangents == pytest.approx((-1.2, 1.0, -1.1, 0.9))
    assert np.array(left.hidden.polygons) == pytest.approx(np.array([[(-1.2, 0.9), (-1.2, -0.1), (-0.1, 0.9)]]))
    # An eighth of the view, counted in 512 columns.
    assert (left.hidden_share, right.hidden_share) == (pytest.approx(0.125, abs=2e-3), 0)
    path.write_text(path.read_text().replace("tan_top", "top"))
    with pytest.raises(InputError, match=r"mine\.json: the key .*tan_top is missing"):
        load_headset(str(path))
