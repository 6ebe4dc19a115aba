"""Repairs: what every one keeps to, what complete and edges do by their definitions, and what they
gain on the frames of a depth camera in a rendered scene."""

from __future__ import annotations

import functools
import itertools

import attrs
import numpy as np
import pytest
from depth_camera import CameraFrame, DepthCamera
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp import Pose, warp_image
from hmdwarp.base import InputError, UnknownNameError
from hmdwarp.metrics import psnr
from hmdwarp.scenes import load_scene
from hmdwarp.sources.repairs import parse_repairs, repairs
from hmdwarp.sources.repairs.edges import depth_offset
from hmdwarp.sources.server import Server

CHAINS = [*repairs.names(), "edges+complete", "complete+edges", "complete:least=0.5"]
SIZES = [(1, 1), (2, 1), (1, 9), (7, 5), (33, 17), (40, 64)]


def two_surfaces(size=(96, 72), near=1.0, far=0.25, rng=None) -> tuple[np.ndarray, np.ndarray]:
    """A disc before a wall, each of one colour with some noise: sRGB colour, inverse depth."""
    rng = np.random.default_rng(0) if rng is None else rng
    wide, high = size
    rows, columns = np.indices((high, wide))
    disc = (rows - 0.45 * high) ** 2 + (columns - 0.55 * wide) ** 2 < (0.3 * high) ** 2
    colour = np.where(disc[..., None], (0.8, 0.3, 0.2), (0.2, 0.4, 0.6)) + 0.02 * rng.standard_normal((high, wide, 3))
    return np.clip(colour, 0, 1).astype(np.float32), np.where(disc, near, far).astype(np.float32)


def moved(values: np.ndarray, down: int, right: int) -> np.ndarray:
    """The picture moved by whole pixels, NaN where nothing comes in."""
    padded = np.pad(values, 16, constant_values=np.nan)
    high, wide = values.shape
    return padded[16 - down : 16 - down + high, 16 - right : 16 - right + wide]


def same(one: np.ndarray, other: np.ndarray) -> bool:
    """Bit for bit, NaN included."""
    return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True)


@st.composite
def frames(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Any colour; depth in steps and at random, with infinity, huge values and gaps, or none."""
    wide, high = draw(st.sampled_from(SIZES))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    colour = rng.random((high, wide, 3)).astype(np.float32)
    if draw(st.booleans()):
        colour = np.zeros_like(colour)
    kinds = np.array([0.0, 0.2, 0.21, 1.0, 5.0, 1e30, np.nan], np.float32)
    inverse = kinds[rng.integers(0, len(kinds), (high, wide))]
    inverse[rng.random((high, wide)) < draw(st.sampled_from([0, 0.3, 0.95, 1]))] = np.nan
    return colour, inverse


@pytest.mark.parametrize("text", CHAINS)
@given(frame=frames())
@settings(max_examples=60)
def test_no_depth_is_invented_outside_what_was_measured(text, frame):
    """A guess is a weighted mean of measured depths: within their range, but for rounding. Eight
    products and sums in float32 round by at most 16 * 2^-24 of the largest. Read-only arrays are
    taken and stay as they are; twice gives the same bits; without depth there is none."""
    colour, inverse = frame
    before, known = inverse.copy(), inverse[~np.isnan(inverse)]
    for array in frame:
        array.setflags(write=False)
    found, again = (parse_repairs(text).run(colour, inverse) for _ in range(2))
    depth, confidence = found.inverse_depth, found.confidence
    assert depth.shape == confidence.shape == inverse.shape and depth.dtype == confidence.dtype == np.float32
    assert ((confidence >= 0) & (confidence <= 1)).all() and np.array_equal(confidence == 0, np.isnan(depth))
    assert same(inverse, before) and same(depth, again.inverse_depth) and same(confidence, again.confidence)
    assert len(known) or np.isnan(depth).all()
    if "edges" not in text:  # which takes away what flies
        assert np.array_equal(depth[~np.isnan(inverse)], known)
        assert (confidence[~np.isnan(inverse)] == 1).all() and (confidence[np.isnan(inverse)] < 1).all()
    depth = depth[~np.isnan(depth)]
    if len(depth):
        slack = 16 * 2.0**-24 * known.max()
        assert depth.min() >= max(known.min() - slack, 0) and depth.max() <= known.max() + slack


def plane(slope: float) -> tuple[np.ndarray, np.ndarray]:
    rows, columns = np.indices((60, 80))
    colour = np.random.default_rng(1).random((60, 80, 3)).astype(np.float32)
    return colour, (0.5 + slope * (rows + columns)).astype(np.float32)


@pytest.mark.parametrize("text", CHAINS)
@pytest.mark.parametrize("slope", [0.0, 0.0005, 0.004, None])
def test_perfect_depth_stays_as_it_is(text, slope):
    """Bit for bit: nothing is missing, and 0.004 /m a pixel is no jump from 0.5 /m on. Nor between
    two surfaces, which meet their colours where they are."""
    colour, inverse = two_surfaces() if slope is None else plane(slope)
    found = parse_repairs(text).run(colour, inverse)
    assert same(found.inverse_depth, inverse) and (found.confidence == 1).all()


@pytest.mark.parametrize("name", repairs.names())
def test_it_says_what_it_is_and_what_it_needs(name):
    entry = repairs.get(name)
    assert entry.summary and entry.needs and entry.source
    assert all(field.default is not attrs.NOTHING for field in attrs.fields(entry.Settings))
    assert str(parse_repairs(name).text) == name


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("complete+none", InputError, "leave it out"),
        ("complete:lest=1", InputError, "its settings and their defaults: tolerance"),
        ("complete:least=2", InputError, "least is 2: expected 0 to 1"),
        ("complete:reach=0", InputError, "expected more than 0"),
        ("complete:tolerance=-1", InputError, "expected 0 or more"),
        ("edges:most=100", InputError, "expected 0 to 64 pixels"),
        ("edges:evidence=-1", InputError, "evidence is -1"),
        ("complet", UnknownNameError, "did you mean 'complete'"),
        (None, InputError, "repair is None: expected a name"),
    ],
)
def test_texts_that_cannot_be_meant_are_refused(text, error, message):
    with pytest.raises(error, match=message):
        parse_repairs(text)


def complete(colour, inverse, text="complete"):
    return parse_repairs(text).run(colour, inverse)


def guessed(colour: np.ndarray, inverse: np.ndarray, row: int, column: int) -> tuple[float, float]:
    """By its definition, in float64, walking from the pixel: the guess and its confidence."""
    high, wide = inverse.shape
    proposals = []
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            y, x, steps = row + down, column + right, 1
            while (down or right) and 0 <= y < high and 0 <= x < wide:
                if not np.isnan(inverse[y, x]):
                    distance = steps * np.hypot(down, right)
                    unlike = ((colour[y, x].astype(float) - colour[row, column]) ** 2).sum()
                    weight = (np.exp(-unlike / (2 * 0.08**2)) + 1e-3) / distance**2
                    proposals.append((float(inverse[y, x]), weight, distance))
                    break
                y, x, steps = y + down, x + right, steps + 1
    if not proposals:
        return np.nan, 0.0

    def belong(a: float, b: float) -> bool:
        return max(a, b) <= min(a, b) + 0.15 * (min(a, b) + 0.05)

    groups = [[p for p in proposals if belong(p[0], proposal[0])] for proposal in proposals]
    best = max(groups, key=lambda group: sum(weight for _, weight, _ in group))
    share = sum(weight for _, weight, _ in best)
    nearest = min(distance for _, _, distance in best) / max(high, wide) / 0.075
    confidence = share / sum(weight for _, weight, _ in proposals) * 2 ** -(nearest**2)
    return sum(value * weight for value, weight, _ in best) / share, min(max(confidence, 2**-10), 1 - 2**-10)


@pytest.mark.parametrize("seed", range(4))
def test_each_guess_is_what_the_definition_says(seed):
    """Pixel by pixel, by another route; float32 rounds eight products and sums by 2^-24 each."""
    rng = np.random.default_rng(seed)
    inverse = np.repeat(np.repeat(rng.uniform(0.1, 2, (4, 5)), 6, axis=0), 6, axis=1).astype(np.float32)[:22, :29]
    colour = rng.random((22, 29, 3)).astype(np.float32)
    inverse[rng.random(inverse.shape) < 0.7] = np.nan
    found = complete(colour, inverse)
    for row, column in np.argwhere(np.isnan(inverse)):
        value, confidence = guessed(colour, inverse, row, column)
        assert found.inverse_depth[row, column] == pytest.approx(value, rel=2e-5)
        assert found.confidence[row, column] == pytest.approx(confidence, rel=2e-4)


@pytest.mark.parametrize("size", [(96, 72), (641, 479)])
def test_a_gap_at_a_silhouette_goes_to_each_side_by_its_colour(size):
    """A ring around the disc's outline has no depth. Where gaps are closed on blocks, those that
    the outline crosses have one depth: at most a block on either side of it, along its 2 pi 0.3
    high pixels."""
    colour, inverse = two_surfaces(size)
    rows, columns = np.indices(inverse.shape)
    radius = np.hypot(rows - 0.45 * size[1], columns - 0.55 * size[0])
    gap = np.abs(radius - 0.3 * size[1]) < 0.06 * size[1]
    found = complete(colour, np.where(gap, np.float32(np.nan), inverse))
    wrong = found.inverse_depth != inverse
    block = -(-max(size) // 320)
    assert wrong.sum() <= (block > 1) * 2 * block * 2 * np.pi * 0.3 * size[1]
    assert set(np.unique(found.inverse_depth)) == {np.float32(1), np.float32(0.25)}  # never between them


def test_below_the_least_confidence_holes_are_left():
    """At the reach, 0.075 of the longer side, it is a half."""
    inverse, colour = np.full((40, 200), np.nan, np.float32), np.full((40, 200, 3), 0.5, np.float32)
    inverse[:, :50] = 0.5
    whole, parted = (complete(colour, inverse, text) for text in ("complete", "complete:least=0.5"))
    assert (np.diff(whole.confidence[20, 50:]) <= 0).all()
    assert whole.confidence[20, 49 + 15] == pytest.approx(0.5, rel=1e-6)
    assert not np.isnan(whole.inverse_depth).any()
    assert np.array_equal(np.isnan(parted.inverse_depth), whole.confidence < 0.5)


SETTINGS = repairs.get("edges").Settings()


def edges(colour, inverse, text="edges"):
    return parse_repairs(text).run(colour, inverse)


@pytest.mark.parametrize(("down", "right"), [(0, 0), (1, 0), (0, -1), (2, 3), (-5, 4), (-1, -5)])
def test_moved_depth_is_moved_back(down, right):
    """Whole pixels are found exactly; every depth that stayed in the picture is the true one."""
    colour, inverse = two_surfaces()
    given = moved(inverse, down, right)
    assert depth_offset(colour, given, SETTINGS) == (-down, -right)
    found = edges(colour, given)
    known = ~np.isnan(found.inverse_depth)
    assert np.array_equal(found.inverse_depth[known], inverse[known])
    assert np.array_equal(known, ~np.isnan(moved(given, -down, -right)))


def test_nothing_is_moved_without_evidence():
    """Too far off, a best offset at the very end of the search may not be the best there is. Of
    noise alone, or one colour, no offset stands out; and a setting may ask for more, or none."""
    colour, inverse = two_surfaces()
    for right in (6, 8):
        assert depth_offset(colour, moved(inverse, 0, right), SETTINGS) == (0, 0)
    noise = np.random.default_rng(3).random((*inverse.shape, 3)).astype(np.float32)
    for plain in (noise, np.full_like(noise, 0.5), 0.01 * noise):
        assert depth_offset(plain, inverse, SETTINGS) == (0, 0)
    given = moved(inverse, 0, 3)
    for text in ("edges:most=0", "edges:evidence=1000"):
        assert same(edges(colour, given, text).inverse_depth, given)


def is_between(inverse: np.ndarray, row: int, column: int) -> bool:
    """By its definition: two pixels opposite each other, one nearer and one farther than it."""

    def at(y, x):
        return inverse[y, x] if 0 <= y < len(inverse) and 0 <= x < inverse.shape[1] else np.nan

    def limit(r):
        return r + np.float32(0.15) * (r + np.float32(0.05))

    here = inverse[row, column]
    for reach, (down, right) in itertools.product((1, 2), itertools.product((-1, 0, 1), repeat=2)):
        near, far = at(row + reach * down, column + reach * right), at(row - reach * down, column - reach * right)
        if near > limit(here) and here > limit(far):
            return True
    return False


@pytest.mark.parametrize("seed", range(4))
def test_removed_depth_is_that_of_the_definition(seed):
    """On random steps, pixel by pixel: the arrays take only pixels near a jump, and miss none."""
    rng = np.random.default_rng(seed)
    inverse = rng.choice(np.array([0, 0.2, 0.22, 0.5, 1, 3, np.nan], np.float32), (17, 23))
    inverse[:8] = np.repeat(inverse[:8, ::4], 4, axis=1)[:, :23]  # broader surfaces above
    found = edges(np.zeros((17, 23, 3), np.float32), inverse, "edges:most=0")
    with np.errstate(invalid="ignore"):
        wanted = np.array([[is_between(inverse, y, x) for x in range(23)] for y in range(17)])
    assert np.array_equal(np.isnan(found.inverse_depth), wanted | np.isnan(inverse))


CAMERA_SIZE = (160, 120)
LATER_NS = 500_000_000  # 6 cm and 0.6 degrees
FAULTS = {
    "none": {}, "gaps": {"edge_gaps": 0.7}, "noise": {"noise": 0.0025}, "shift": {"shift": (-3.0, 2.0)},
    "all": {"shift": (2.0, 1.0), "edge_gaps": 0.5, "noise": 0.0025, "far_m": 6.0, "readout_ns": 10**7},
}  # fmt: skip


def head_at(time_ns: int) -> Pose:
    seconds, half = time_ns / 1e9, 0.1 + 0.01 * time_ns / 1e9
    return Pose((0.12 * seconds, 1.6, 0.02 * seconds), (0, np.sin(half), 0, np.cos(half)))


@pytest.fixture(scope="module", params=["room", "spheres"])
def frame_of(request, gpu):
    """frame_of(fault) is a frame of the camera; frame_of(None) the truth that is shown later."""
    server = Server(gpu, load_scene(request.param))

    @functools.cache
    def record(fault: str | None) -> CameraFrame:
        camera, time_ns = DepthCamera(CAMERA_SIZE, **FAULTS[fault or "none"]), 0 if fault else LATER_NS
        return camera.record(server, head_at, [time_ns], np.random.default_rng(0))[0]

    yield record
    server.close()


# Does to silhouettes nothing of its own: by default it does to mixed depth what `edges` does.
WARP = "iterative:sheet=0,fringe=own"


@pytest.mark.parametrize("fault", FAULTS)
def test_complete_gains_what_it_was_measured_to(frame_of, fault):
    """Measured: 1.4 to 9.9 dB, with the sky of both scenes among what has no depth."""
    frame, truth = frame_of(fault), frame_of(None)
    plain, mended = (
        warp_image(frame.colour, frame.depth_m, frame.view, truth.view, warp=WARP, repair=repair).colour
        for repair in ("none", "edges+complete")
    )
    assert psnr(mended, truth.colour) > psnr(plain, truth.colour) + 1
