"""warp_image on one's own RGB-D frame. Bits where bits can be had, derived pixels where something
moves, clear refusals."""

from __future__ import annotations

import io
import math
import threading

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

import hmdwarp
from hmdwarp import Fov, InputError, Pose, View
from hmdwarp.base import PlanError, UnknownNameError, linear_from_srgb, srgb8_from_linear
from hmdwarp.gpu import Gpu
from hmdwarp.image import usable_warps

CONTEXT: dict[str, Gpu | None] = {}
SHARED = {"gpu": None}  # the context of calls that bring none


@pytest.fixture(scope="module", autouse=True)
def session_context(gpu):
    """Let calls draw in the session's context, whose shaders are compiled already."""
    CONTEXT["gpu"] = gpu


def warp_image(colour, depth_m, rendered, shown, warp="forward", fill="none", **more) -> hmdwarp.WarpedImage:
    """The warp alone, unless a test names a fill."""
    return hmdwarp.warp_image(colour, depth_m, rendered, shown, warp, fill, **{**CONTEXT, **more})


@pytest.mark.parametrize("colour", ["uint8", "float32"])
def test_a_notebook_shows_a_result_as_a_picture(colour):
    """Its PNG has the colours of an sRGB input seen from where it was rendered, row 0 on top."""
    levels = np.random.default_rng(0).integers(0, 256, (6, 8, 3), dtype=np.uint8)
    given = levels if colour == "uint8" else linear_from_srgb(levels / 255).astype(np.float32)
    result = warp_image(given, np.full((6, 8), 2.0, np.float32), view(), view())
    assert len(repr(result)) < 120 and "holes" in repr(result)
    shown = np.asarray(Image.open(io.BytesIO(result._repr_png_())))
    assert np.abs(shown.astype(int) - levels).max() <= 1  # one rounding of half floats


def halves(rng: np.random.Generator, size: tuple[int, int]) -> np.ndarray:
    """A linear picture whose values rgba16f holds exactly."""
    return rng.random((size[1], size[0], 3)).astype(np.float16).astype(np.float32)


def view(tangents=(-1.0, 1.0, -0.75, 0.75), position=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0)) -> View:
    """Tangents left, right, down, up; turn is a rotation vector in degrees."""
    return View(Pose(position, Rotation.from_rotvec(np.radians(turn)).as_quat()), Fov.from_tangents(tangents))


@pytest.mark.parametrize("warp", usable_warps())
def test_bytes_are_srgb_and_floats_linear(warp):
    rng = np.random.default_rng(1)
    picture = rng.integers(0, 256, (9, 11, 3), dtype=np.uint8)
    depth = rng.uniform(0.5, 5, (9, 11))
    there = view(position=(0.1, 0, 0))
    as_bytes = warp_image(picture, depth, view(), there, warp)
    as_floats = warp_image(linear_from_srgb(picture).astype(np.float64), depth, view(), there, warp)
    assert (as_bytes.encoding, as_floats.encoding) == ("srgb8", "linear")
    assert as_bytes.colour.dtype == np.uint8 and as_floats.colour.dtype == np.float32
    assert np.array_equal(as_bytes.colour, srgb8_from_linear(as_floats.colour))
    still = warp_image(picture, depth, view(), view(), warp)
    assert np.array_equal(still.colour, picture) and (still.coverage == 1).all() and still.hole_share == 0
    assert set(still.time_ms) == {"upload", "warp", "download", "host"} and still.time_ms["warp"] > 0


@pytest.mark.parametrize("warp", ["forward", "planar"])
@pytest.mark.parametrize(("right", "up"), [(3, 0), (0, -3), (-2, 1)])
def test_a_plane_lands_where_it_must(warp, right, up):
    """A picture 2 wide and 1.5 high at z = -1 in 40x30 pixels: a pixel is 0.05 of depth.

    The eye moves by whole pixels of the plane 4 m away, so the picture moves by as many the other
    way, and what comes in from outside is a hole.
    """
    rng = np.random.default_rng(2)
    colour, depth_m = halves(rng, (40, 30)), 4.0
    there = view(position=(right * 0.05 * depth_m, up * 0.05 * depth_m, 0))
    out = warp_image(colour, np.full((30, 40), depth_m), view(), there, warp)
    wanted, covered = np.zeros_like(colour), np.zeros((30, 40))
    # Row 0 is the top: an eye that went up sees the picture farther down, at larger rows.
    to_rows, from_rows = slice(max(up, 0), 30 + min(up, 0)), slice(max(-up, 0), 30 - max(up, 0))
    to_columns, from_columns = slice(max(-right, 0), 40 - max(right, 0)), slice(max(right, 0), 40 + min(right, 0))
    wanted[to_rows, to_columns], covered[to_rows, to_columns] = colour[from_rows, from_columns], 1
    assert np.array_equal(out.coverage, covered)
    # planar looks up between pixels: the place is right to 1e-4 pixel in float32, times at most 1
    # between two neighbours.
    assert np.abs(out.colour - wanted).max() <= (0 if warp == "forward" else 2e-3)
    assert out.hole_share == (covered == 0).mean()


@pytest.mark.parametrize("warp", ["rotation", "planar", "forward"])
@pytest.mark.parametrize(("yaw", "pitch"), [(10, 0), (0, -12), (-9, 7)])
def test_a_turn_moves_a_spot_by_its_tangent(warp, yaw, pitch):
    """A spot straight ahead, infinitely far. Turned left by yaw it is seen to the right, turned up
    by pitch it is seen lower."""
    size = (101, 81)
    colour = np.zeros((81, 101, 3), np.float32)
    colour[39:42, 49:52] = 1
    turn = Rotation.from_euler("YX", [yaw, pitch], degrees=True)
    there = View(Pose((0, 0, 0), turn.as_quat()), view().fov)
    out = warp_image(colour, np.full((81, 101), np.inf), view(), there, warp)
    seen = turn.inv().apply([0, 0, -1])
    x, y = seen[0] / -seen[2], seen[1] / -seen[2]
    column, row = (x + 1) / 2 * size[0] - 0.5, (0.75 - y) / 1.5 * size[1] - 0.5
    weight = out.colour[..., 0]
    rows, columns = np.indices(weight.shape)
    found = (weight * columns).sum() / weight.sum(), (weight * rows).sum() / weight.sum()
    # Nine pixels, each right to half a pixel at worst: their mean is right to half a pixel too.
    assert found == pytest.approx((column, row), abs=0.5)
    assert (column > 50) == (yaw > 0) or yaw == 0
    assert (row > 40) == (pitch > 0) or pitch == 0


@pytest.mark.parametrize("warp", usable_warps())
def test_row_0_is_the_top(warp):
    """A red top row stays at the top, and the view that looks at the upper half sees it."""
    colour = np.zeros((12, 16, 3), np.uint8)
    colour[0] = (255, 0, 0)
    colour[-1] = (0, 0, 255)
    depth = np.full((12, 16), 3.0)
    out = warp_image(colour, depth, view(), view(), warp).colour
    assert (out[0] == (255, 0, 0)).all() and (out[-1] == (0, 0, 255)).all()
    if warp != "none":
        upper = warp_image(colour, depth, view(), view((-1, 1, 0, 0.75)), warp, size=(16, 6)).colour
        assert (upper[0] == (255, 0, 0)).all() and (upper[1:] == 0).all()


NO_DEPTHS = [0.0, -0.0, -1.0, -np.inf, np.nan]


@pytest.mark.parametrize("warp", usable_warps())
def test_pixels_without_depth_are_holes_that_are_counted_and_never_spread(warp):
    rng = np.random.default_rng(9)
    colour, depth = halves(rng, (22, 16)), np.full((16, 22), 3.0)
    places = [(2, 3), (2, 4), (8, 0), (15, 21), (7, 10)]
    for place, nothing in zip(places, NO_DEPTHS, strict=True):
        depth[place] = nothing
    holes = ~(depth > 0)
    out = warp_image(colour, depth, view(), view(), warp)
    assert np.array_equal(out.coverage == 0, holes)
    assert np.array_equal(out.colour, np.where(holes[..., None], 0, colour))
    assert out.hole_share == 5 / 352


def test_the_picture_is_warped_and_complete_by_default():
    colour = np.random.default_rng(3).integers(0, 256, (24, 32, 3), dtype=np.uint8)
    aside = view(position=(0.4, 0, 0))
    given_ = (colour, np.full((24, 32), 2.0), view(), aside)
    found, named = hmdwarp.warp_image(*given_), hmdwarp.warp_image(*given_, "iterative", "pyramid")
    assert found.hole_share > 0 and (found.coverage == 1).all() and np.array_equal(found.colour, named.colour)


@pytest.mark.parametrize("depth", [0.0, np.nan])
def test_a_picture_that_a_fill_makes_up_is_warned_of(depth):
    colour, depth_m = np.full((6, 8, 3), 0.5), np.full((6, 8), depth)
    depth_m[3, 4] = 2.0
    with pytest.warns(UserWarning, match="97.9 % of the picture is empty before the fill: the frame has no depth"):
        made_up = warp_image(colour, depth_m, view(), view(), fill="pyramid")
    half_turn = view(position=(0, 0, 0.5), turn=(0, 180, 0))
    with pytest.warns(UserWarning, match="look 180 degrees apart from places 0.5 m apart"):
        warp_image(colour, np.full((6, 8), 2.0), view(), half_turn, fill="pyramid")
    assert made_up.hole_share == 47 / 48 and (made_up.coverage == 1).all()
    assert warp_image(colour, depth_m, view(), view()).coverage.sum() == 1  # which says it: no warning


def test_eight_bits_as_floats_are_refused_not_taken_as_light():
    """Whole numbers of a dark picture, and the fractions that resizing makes of a bright one."""
    rng = np.random.default_rng(23)
    dark = np.where(rng.random((4, 6, 3)) < 0.9, 0, 200).astype(np.float32)
    bright = rng.uniform(0, 255, (4, 6, 3))
    for colour in (dark, bright, bright / 255 * 65535):
        with pytest.raises(InputError, match="linear light has 1 for white.*encoding="):
            warp_image(colour, DEPTH, view(), view())
    # A bright spot in a picture lit as usual, and any light that is said to be light.
    lit = rng.random((4, 6, 3)).astype(np.float16).astype(np.float32)
    lit[1, 2] = 5000
    for colour, said in ((lit, None), (rng.integers(0, 255, (4, 6, 3)).astype(np.float32), "linear")):
        assert np.array_equal(warp_image(colour, DEPTH, view(), view(), encoding=said).colour, colour)


@pytest.mark.parametrize("result", [None, "srgb8", "srgb", "linear"])
@pytest.mark.parametrize("given", ["srgb8", "srgb", "linear"])
def test_colour_comes_back_as_it_went_in_or_as_requested(given, result):
    """Each of the nine ways gives the same bytes: halves hold a byte's light to 2**-11 of it."""
    picture = np.random.default_rng(24).integers(0, 256, (4, 6, 3), dtype=np.uint8)
    said = None
    if given == "srgb8":
        colour = picture
    elif given == "srgb":
        colour, said = (picture / 255).astype(np.float32), "srgb"
    else:
        colour = linear_from_srgb(picture)
    out = warp_image(colour, DEPTH, view(), view(), encoding=said, result=result)
    assert out.encoding == (result or given)
    assert out.colour.dtype == (np.uint8 if out.encoding == "srgb8" else np.float32)
    as_bytes = {
        "srgb8": out.colour,
        "srgb": np.rint(out.colour * 255).astype(np.uint8),
        "linear": srgb8_from_linear(out.colour),
    }
    assert np.array_equal(as_bytes[out.encoding], picture)


def test_a_hidden_area_with_alpha_0_brings_no_black_into_view():
    """Corners that a headset's lens never shows, which the engine left black, far away or near."""
    y, x = np.mgrid[-1:1:48j, -1:1:64j]
    seen = x**2 + y**2 < 1.1
    colour = np.where(seen[..., None], np.uint8(200), np.uint8(0)) * np.ones(3, np.uint8)
    fov = Fov.symmetric(1.2, 1.0)
    turned = View(Pose((0.05, 0, 0), Rotation.from_euler("y", 12, degrees=True).as_quat()), fov)
    for corner_m in (math.inf, 0.1):
        depth = np.where(seen, 2.0, corner_m)
        black = warp_image(colour, depth, View(Pose(), fov), turned, "iterative", "pyramid").colour
        masked = np.dstack([colour, np.where(seen, np.uint8(255), np.uint8(0))])
        right = warp_image(masked, depth, View(Pose(), fov), turned, "iterative", "pyramid").colour
        # All that was drawn is one grey, so that a fill can only give that grey.
        assert black.min() < 20 and right.min() > 195


def test_alpha_is_coverage():
    """0 is a hole, as depth of 0 is; anything else is seen, and no colour is blended."""
    colour = np.random.default_rng(3).integers(0, 256, (4, 6, 4), dtype=np.uint8)
    colour[..., 3] = 255
    colour[1, 2, 3], colour[2, 4, 3] = 0, 1
    out = warp_image(colour, DEPTH, view(), view())
    gone = np.zeros((4, 6), bool)
    gone[1, 2] = True
    assert np.array_equal(out.coverage == 0, gone) and out.hole_share == 1 / 24
    assert np.array_equal(out.colour[~gone], colour[..., :3][~gone])
    depth = np.array(DEPTH, dtype=float)
    depth[1, 2] = 0
    same = warp_image(colour[..., :3], depth, view(), view())
    assert np.array_equal(same.colour, out.colour) and np.array_equal(same.coverage, out.coverage)
    with pytest.raises(InputError, match="alpha of colour at row 0, column 1 is -1"):
        warp_image(np.where(np.arange(24).reshape(4, 6, 1) == 1, -1.0, 0.5) * np.ones(4), DEPTH, view(), view())


def test_arrays_may_be_read_only_of_any_strides_or_lists():
    rng = np.random.default_rng(7)
    large, deep = halves(rng, (12, 8)), rng.uniform(1, 4, (8, 12))
    wanted = warp_image(large[::-2, ::2].copy(), deep[::-2, ::2].copy(), view(), view(position=(0.1, 0, 0)))
    large.flags.writeable = deep.flags.writeable = False
    found = warp_image(large[::-2, ::2], deep[::-2, ::2], view(), view(position=(0.1, 0, 0)))
    turned = warp_image(
        np.asfortranarray(large[::-2, ::2]), deep[::-2, ::2].tolist(), view(), view(position=(0.1, 0, 0))
    )
    assert np.array_equal(found.colour, wanted.colour) and np.array_equal(turned.colour, wanted.colour)


@pytest.mark.parametrize(("unit", "dtype"), [(0.001, np.uint16), (1 / 5000, np.uint16), (0.5, np.float32)])
def test_depth_in_other_units_is_the_same_in_metres(unit, dtype):
    """2 m is a whole number of each unit, so the inverse depths differ by their last bits only."""
    metres = np.full((12, 16), 2.0)
    metres[3:7, 5:9] = 1.0
    metres[0, 0] = 0
    colour, there = halves(np.random.default_rng(21), (16, 12)), view(position=(0.25, 0, 0))
    wanted = warp_image(colour, metres, view(), there)
    found = warp_image(colour, np.rint(metres / unit).astype(dtype), view(), there, depth_scale=unit)
    assert np.array_equal(found.coverage, wanted.coverage) and np.array_equal(found.colour, wanted.colour)


@pytest.mark.parametrize("dtype", [np.uint16, np.int16, np.int32])
def test_the_largest_integer_is_a_hole_and_said(dtype):
    depth = np.full((12, 16), 2000, dtype)
    depth[3:5, 6:9] = np.iinfo(dtype).max
    colour = halves(np.random.default_rng(23), (16, 12))
    with pytest.warns(UserWarning, match=f"6 pixels .3.1 %. of its depth are {np.iinfo(dtype).max}.* no depth") as told:
        found = warp_image(colour, depth, view(), view(), depth_scale=0.001)
        warp_image(colour, depth, view(), view(), depth_scale=0.001, repair="edges")
    assert len(told) == 2
    assert (found.coverage[3:5, 6:9] == 0).all() and (found.coverage == 0).sum() == 6
    masked = np.ma.masked_array(depth, depth == np.iinfo(dtype).max)  # the caller knows
    assert np.array_equal(warp_image(colour, masked, view(), view(), depth_scale=0.001).coverage, found.coverage)


@pytest.mark.parametrize(("unit", "name"), [(1000, "millimetres"), (100, "centimetres")])
def test_depth_that_is_hardly_in_metres_is_said(unit, name):
    """Far everywhere, while the eye moves by 8 cm; not where it only turns, nor where it flies."""
    colour, metres = halves(np.random.default_rng(24), (16, 12)), np.full((12, 16), 2.0)
    metres[0] = np.inf
    near = view(position=(0.08, 0, 0))
    with pytest.warns(
        UserWarning, match=f"{2 * unit} m away.*0.08 m.*depth_scale={1 / unit:g} takes it as {name}: 2 m"
    ):
        warp_image(colour, metres * unit, view(), near)
    drawn = np.dstack([colour, np.ones((12, 16))])
    drawn[5, 6, 3], nearest = 0, metres * unit
    nearest[5, 6] = 0.5
    with pytest.warns(UserWarning, match="depth_scale="):
        warp_image(drawn, nearest, view(), near)  # what is nearer was not drawn
    warp_image(colour, metres, view(), near)
    warp_image(colour, metres * unit, view(), near, depth_scale=1 / unit)
    warp_image(colour, metres * unit, view(), view())
    warp_image(colour, metres * unit, view(), view(position=(0.2 * unit, 0, 0)))


@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_masked_pixels_are_holes(dtype):
    """In depth as in one channel of the colour, whatever value lies below the mask."""
    rng = np.random.default_rng(22)
    colour = rng.integers(0, 256, (12, 16, 3), np.uint8) if dtype == np.uint8 else halves(rng, (16, 12))
    depth, holes = np.full((12, 16), 2.0), np.zeros((12, 16), bool)
    holes[2, 3] = holes[8:10, 11] = True
    bare, bad = depth.copy(), colour.copy()
    bare[holes] = 0
    bad[holes] = 255 if dtype == np.uint8 else np.nan
    there = view(position=(0.1, 0.05, 0))
    wanted = warp_image(colour, bare, view(), there)
    assert (wanted.coverage == 0).sum() >= 3
    channel = np.zeros_like(colour, bool)
    channel[..., 1] = holes
    some = holes & (np.arange(12) < 5)[:, None]
    both = np.ma.masked_array(colour, channel & some[..., None]), np.ma.masked_array(depth, holes & ~some)
    for masked in (
        warp_image(colour, np.ma.masked_array(depth, holes), view(), there),
        warp_image(np.ma.masked_array(colour, channel), depth, view(), there),
        warp_image(np.ma.masked_array(bad, np.repeat(holes[..., None], 3, axis=2)), depth, view(), there),
        warp_image(*both, view(), there),
    ):
        assert np.array_equal(masked.coverage, wanted.coverage) and np.array_equal(masked.colour, wanted.colour)


COLOUR, DEPTH = np.zeros((4, 6, 3)), np.ones((4, 6))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"colour": np.zeros((4, 6))}, r"colour has shape \(4, 6\)"),
        ({"colour": np.zeros((4, 6, 2))}, r"\(4, 6, 2\): expected \(h, w, 3\), or \(h, w, 4\)"),
        ({"colour": np.zeros((0, 6, 3)), "depth_m": np.zeros((0, 6))}, r"\(0, 6, 3\)"),
        ({"colour": np.zeros((4, 6, 3), int)}, "colour is int64: expected uint8"),
        ({"colour": np.zeros((4, 6, 3), np.uint16)}, "uint16"),
        ({"colour": np.zeros((4, 6, 3), bool)}, "bool"),
        ({"colour": np.zeros((4, 6, 3), complex)}, "complex"),
        ({"colour": [[1, 2], [3]]}, "colour is no array"),
        ({"colour": None}, "colour has shape"),
        ({"colour": np.where(np.indices((4, 6, 3))[1] == 5, np.nan, 0.0)}, "row 0, column 5 is not a finite number"),
        ({"colour": np.full((4, 6, 3), np.inf)}, "not a finite number"),
        ({"encoding": "sRGB"}, "encoding is 'sRGB': expected srgb or linear"),
        ({"colour": COLOUR.astype(np.uint8), "encoding": "linear"}, "uint8, which is sRGB, and encoding is linear"),
        ({"colour": COLOUR + 1.5, "encoding": "srgb"}, "goes up to 1.5: expected sRGB as floats of 0 to 1"),
        ({"depth_m": DEPTH.T}, r"depth_m is float64 \(6, 4\): expected numbers of shape \(4, 6\)"),
        ({"depth_m": DEPTH[..., None]}, "depth_m"),
        ({"depth_m": DEPTH > 0}, "depth_m is bool"),
        ({"depth_m": [["a"] * 6] * 4}, "depth_m is <U1"),
        ({"rendered": None}, "rendered is a NoneType: expected a hmdwarp.View"),
        ({"shown": Pose()}, "shown is a Pose"),
        *(
            ({each: View(Pose((0, 0, 1e20)), view().fov)}, rf"{each}: position .* at most 1e\+09 m")
            for each in ("rendered", "shown")
        ),
        ({"depth_m": -DEPTH}, "metres along -z, which are above 0: negate it"),
        *(({"depth_m": np.where(np.eye(4, 6) > 0, sky, -2.0)}, "negate it") for sky in (0.0, np.nan, np.inf)),
        *(
            ({"depth_m": DEPTH.astype(kind)}, "of unknown unit: give depth_scale")
            for kind in (np.uint8, np.uint16, np.int32, np.int64)
        ),
        *(
            ({"depth_scale": scale}, "depth_scale is .*: expected metres per unit")
            for scale in (0, -1, 5000, math.nan, math.inf, True, "0.001", (1,))
        ),
        ({"result": "rgb"}, "result is 'rgb': expected srgb8, srgb, linear"),
        ({"budget_ms": 9.0}, "for warp 'auto': .* takes what it takes"),
        ({"warp": "auto", "budget_ms": -1.0}, "budget_ms -1 ms: expected a time above 0"),
        ({"warp": "auto", "budget_ms": 1e-6}, "budget_ms 1e-06 ms: nothing is that fast here"),
        ({"size": (0, 4)}, "0x4"),
        ({"size": (4, -4)}, "4x-4"),
        ({"size": (4.5, 4)}, "whole pixels"),
        ({"size": 4}, "whole pixels"),
        ({"size": (1, 2, 3)}, "whole pixels"),
        ({"size": (10**6, 4)}, "1000000x4"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    given_ = {"colour": COLOUR, "depth_m": DEPTH, "rendered": view(), "shown": view(), **arguments}
    with pytest.raises(InputError, match=message):
        warp_image(**given_)


def test_names_are_checked():
    given_ = COLOUR, DEPTH, view(), view()
    for names, error, told in (
        (("foreward",), UnknownNameError, "did you mean 'forward'"),
        (("forward", "interpolation"), UnknownNameError, "did you mean 'interpolate'"),
        (("auto",), InputError, "'auto' keeps to a budget: give budget_ms"),
        (("backward",), PlanError, "backward.*single picture has none"),
        (("environment",), PlanError, "warp environment needs layer 'cube' from the server.*single picture has none"),
        (("layered",), PlanError, "layer 'peeled'.*single picture has none"),
        *(((wrong,), InputError, "warp is .*: expected a name: forward, ") for wrong in (None, 3, ["forward"])),
        (("forward", None), InputError, "fill is .*: expected a name: constant, "),
    ):
        with pytest.raises(error, match=told):
            warp_image(*given_, *names)


def test_threads_take_turns():
    colours = [halves(np.random.default_rng(seed), (9, 7)) for seed in range(4)]
    wrong: list[object] = []

    def work(colour: np.ndarray) -> None:
        try:
            for _ in range(10):
                if not np.array_equal(warp_image(colour, np.ones((7, 9)), view(), view(), **SHARED).colour, colour):
                    wrong.append("another picture")
        except Exception as error:
            wrong.append(error)

    threads = [threading.Thread(target=work, args=(colour,)) for colour in colours]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
