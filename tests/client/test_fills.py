"""Fills: golden pictures of random holes, and what each must do whatever the picture."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from golden_pictures import assert_golden, name_of, names_in, sheet
from holed import Holed
from scipy.spatial.transform import Rotation
from worlds import read

from hmdwarp.client import Compensator, PassInputs, build_plan, every_fill
from hmdwarp.client.fills import fills
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, allocate

from .modelled import SIZE, VIEW, Shown
from .rendered_pictures import FOV, square_before_a_wall

FROM_A_MODEL = [
    "composite:average=mean,radius=0.1,seed=7",
    "composite:average=median",
    "relight",
    "relight:light=baked",
]
ELSEWHERE = {"none": "fills nothing", "memory": "test_memory.py", "model": "test_relight.py"}
# Every other fill, with its variants and these.
MORE = ["pyramid:floor=0", "pyramid:holes=0.2", "stretch:spread=0"]
APART = {*(text.partition(":")[0] for text in FROM_A_MODEL), *ELSEWHERE}
FROM_PICTURES = [text for text in [*every_fill(), *MORE] if text.partition(":")[0] not in APART]
STORED = 2.0**-10  # a half float is truncated: 2^-10 of it, of colours below 2
TWO_STORED = 2 * 2 * STORED


def with_a_wide_hole(gpu, size: tuple[int, int], empty: float, unknown: int) -> Holed:
    """Noise with cracks and a wide hole; each `unknown`-th row without depth, 0: none."""
    holed = Holed(gpu, 8, size, empty)
    wide = np.zeros(size[::-1], bool)
    wide[8:24, 6:30] = True
    holed.empty(wide)
    if unknown:
        holed.inverse_depth[::unknown] = -1
    holed.keep_one()
    return holed


@pytest.mark.parametrize("text", FROM_PICTURES)
def test_random_holes_are_filled_as_before(gpu, tmp_path, text):
    cases = [((45, 37), 0.3, 0), ((45, 37), 0.7, 3), ((45, 3), 0.5, 0), ((2, 45), 0.5, 1), ((31, 17), 0.99, 0)]
    pictures = (with_a_wide_hole(gpu, *case).fill(gpu, text) for case in cases)
    assert_golden(f"fills/{name_of(text)}", sheet(*pictures), tmp_path)


def holes_like(size, seed: int = 3) -> np.ndarray:
    """Cracks everywhere and a wide hole in the middle."""
    y, x = np.mgrid[: size[1], : size[0]]
    wide = (np.abs(x - size[0] / 2) < size[0] / 6) & (np.abs(y - size[1] / 2) < size[1] / 5)
    return wide | (np.random.default_rng(seed).uniform(size=size[::-1]) < 0.2)


def seen_from(metres: float, degrees: float = 0.0) -> View:
    """VIEW's eye farther left, by a little over half as much down, and turned left."""
    position = VIEW.pose.position_m - (metres, 0.6180339 * metres, 0)
    return View(Pose(position, Rotation.from_rotvec((0, np.deg2rad(degrees), 0)).as_quat()), VIEW.fov)


@pytest.mark.parametrize("text", FROM_A_MODEL)
def test_holes_take_the_light_of_a_model_as_before(gpu, tmp_path, text):
    """Seen from where it was drawn, from beside, and from where a move has no direction."""
    size, pictures = (75, 56), []
    for scene, rendered in (("spheres", VIEW), ("planes", seen_from(0.25, 3)), ("planes", seen_from(0, 180))):
        shown = Shown(gpu, scene, (0.6, 0.9, 1.4), size, holes_like(size), share=0.2, rendered=rendered)
        found = shown.fill(text, shown_ns=123)
        assert np.isfinite(found[0]).all()
        assert np.array_equal(found[0][~shown.holes], shown.colour[~shown.holes])
        pictures.append(found)
    assert_golden(f"fills/{name_of(text)}", sheet(*pictures), tmp_path)


def test_every_golden_picture_is_of_a_fill_and_what_has_none_is_one():
    assert names_in("fills") == {name_of(text) for text in [*FROM_PICTURES, *FROM_A_MODEL]}
    assert set(fills.names()) >= APART


# --- constant and pyramid -----------------------------------------------------------------------


@pytest.mark.parametrize("fill", ["constant", "pyramid"])
def test_bright_and_negative_colours_do_not_overflow(gpu, fill):
    holed = Holed(gpu, 3, (300, 211), empty=0.3)
    covered = holed.colour[..., 3] > 0
    holed.colour[covered] = (60000, -60000, 10000, 1)
    got = holed.fill(gpu, fill)[0]
    assert np.abs(got[~covered] - (60000, -60000, 10000, 1)).max() <= 60000 * 16 * STORED  # 8 levels, there and back


def test_a_constant_is_the_mean_and_black_where_nothing_is_covered(gpu):
    holed = Holed(gpu, 3, (67, 53), 0.5)
    got, covered = holed.fill(gpu, "constant")[0], holed.colour[..., 3] > 0
    mean = holed.colour[covered].mean(axis=0)
    assert np.abs(got[~covered] - mean).max() <= STORED * mean.max() + holed.colour.size * 2.0**-24
    nothing = Holed(gpu, 3, (31, 17), empty=1.0).fill(gpu, "constant")[0]
    assert np.array_equal(nothing, np.broadcast_to([0.0, 0, 0, 1], nothing.shape))


def test_a_crack_in_what_is_near_stays_near(gpu):
    """One pixel wide, beside a far surface: what shows through a crack is no hole's background."""
    holed = Holed(gpu, 1, (64, 64), empty=0)
    holed.colour[:], holed.inverse_depth[:] = (1, 0, 0, 1), 1.0
    holed.colour[:, 40:], holed.inverse_depth[:, 40:] = (0, 1, 0, 1), 0.25
    crack = np.zeros((64, 64), bool)
    crack[:, 8:30:3] = True
    holed.empty(crack)
    got, depth = holed.fill(gpu, "pyramid")
    assert np.abs(got[crack] - (1, 0, 0, 1)).max() <= 2.0**-8
    assert np.abs(depth[crack] - 1).max() <= 1e-3


def test_a_glimpse_of_the_sky_is_no_background_for_a_wide_hole_elsewhere(gpu):
    """A wall at 4 m, half the picture a hole; far to the right a window, its sky full of cracks."""
    holed = Holed(gpu, 1, (512, 256), empty=0)
    holed.colour[:], holed.inverse_depth[:] = (0, 1, 0, 1), 0.25
    sky, lost, hole = np.s_[20:240, 360:500], np.s_[30:230, 370:490:3], np.s_[:, :256]
    holed.colour[sky], holed.inverse_depth[sky] = (0, 0, 1, 1), 0.0
    for part in (lost, hole):
        holed.colour[part], holed.inverse_depth[part] = 0, -1
    got, depth = holed.fill(gpu, "pyramid")
    assert got[hole][..., 2].max() < 0.05
    assert np.abs(depth[hole] - 0.25).max() < 0.01
    assert got[lost][..., 2].min() > 0.95


# --- stretch ------------------------------------------------------------------------------------


def filled(
    gpu, warp: str, fill: str, colour: np.ndarray, depth: np.ndarray, pose: Pose
) -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 4) after the warp and after the fills, for an eye at `pose` through FOV. The rendered
    eye stands at the origin."""
    size = depth.shape[::-1]
    textures = [allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)]
    for texture, picture, dtype in zip(textures, (colour, depth), (np.float16, np.float32), strict=True):
        texture.write(np.ascontiguousarray(picture, dtype).tobytes(), alignment=1)
    compensator = Compensator(gpu, build_plan((), warp, fill, "none", client_geometry=False), None, size, size)
    result = compensator.run(PassInputs(EyeImage(View(Pose(), FOV), *textures), View(pose, FOV)))
    gpu.timer.collect()
    found = read(result.warped.texture), read(result.shown.texture)
    compensator.close()
    for texture in textures:
        texture.release()
    return found


@pytest.mark.parametrize("step", [(0.4, 0, 0), (-0.4, 0, 0), (0, 0.4, 0), (0.3, -0.3, 0), (0.25, 0.1, 0.3)], ids=str)
def test_foreground_is_never_smeared(gpu, step):
    """Red is the rendered inverse depth, 1 of the square; of that no trace in holes."""
    colour, depth = square_before_a_wall(np.s_[22:38, 22:38])
    before, after = filled(gpu, "splat", "stretch", colour, depth, Pose(step))
    guessed = (before[..., 3] == 0) & (after[..., 3] == 1)
    assert guessed.sum() > 60
    assert np.abs(after[guessed][:, 0] - 0.25).max() <= TWO_STORED
    assert (after[12:48, 12:48, 3] == 1).all()


def test_a_head_that_only_turned_hid_nothing(gpu):
    holed = Holed(gpu, 8, (67, 53), empty=0.3)
    rendered, shown = holed.inputs.rendered.view, holed.inputs.shown
    turned = View(Pose(rendered.pose.position_m, shown.pose.orientation_xyzw), shown.fov)
    holed.inputs = attrs.evolve(holed.inputs, shown=turned)
    got, depth = holed.fill(gpu, "stretch")
    assert np.array_equal(got, holed.colour) and np.array_equal(depth, holed.inverse_depth)


# --- composite, as the thesis has it; `relight` is the better one ---------------------------------


def test_every_frame_draws_other_places_and_every_run_the_same(gpu):
    shown = Shown(gpu, "spheres", holes=holes_like(SIZE))
    first, again, next_frame = (shown.fill("composite", shown_ns=ns)[0] for ns in (0, 0, 16_666_667))
    assert np.array_equal(first, again)
    both = shown.holes & (first[..., 3] > 0) & (next_frame[..., 3] > 0)
    assert (first != next_frame)[both].any(axis=-1).mean() > 0.5
    assert not np.array_equal(first, shown.fill("composite:seed=1")[0])
