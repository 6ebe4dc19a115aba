"""Warper: many pictures, arrays or textures, on one set of programs and textures."""

from __future__ import annotations

import copy
import gc
import pickle
import subprocess
import sys
import threading

import moderngl
import numpy as np
import pytest
from made import counting_made
from scipy.spatial.transform import Rotation

from hmdwarp import Fov, InputError, Pose, View, Warper, warp_image
from hmdwarp.base import PlanError
from hmdwarp.client.warps import warps
from hmdwarp.gpu import COLOUR, SCALAR, Gpu, allocate, download, upload
from hmdwarp.image import usable_warps
from hmdwarp.image.picture_arrays import raw_picture
from hmdwarp.image.usable import AVAILABLE
from hmdwarp.sources.array_passes import PixelBuffers, TakeIn

SIZE = (40, 30)
STAGES = {"upload", "warp", "download", "host"}  # of each call with arrays


def view(position=(0.0, 0.0, 0.0), yaw=0.0) -> View:
    turn = Rotation.from_euler("Y", yaw, degrees=True).as_quat()
    return View(Pose(position, turn), Fov.from_tangents((-1.0, 1.0, -0.75, 0.75)))


def picture(seed: int, size=SIZE) -> tuple[np.ndarray, np.ndarray]:
    """Linear light that halves hold, and two planes of depth with a hole and infinity."""
    rng = np.random.default_rng(seed)
    colour = rng.random((size[1], size[0], 3)).astype(np.float16).astype(np.float32)
    depth = np.full((size[1], size[0]), 4.0)
    depth[:, size[0] // 2 :] = 1.5
    depth[0, 0], depth[1, 1] = 0, np.inf
    return colour, depth


@pytest.mark.parametrize("warp", usable_warps())
def test_many_pictures_are_each_what_warp_image_makes(warp, gpu):
    with Warper(SIZE, warp=warp, fill="pyramid", gpu=gpu) as warper:
        for number in range(3):
            colour, depth = picture(number)
            shown = view((0.05 * number, 0, 0), yaw=2.0 * number)
            one = warper.warp(colour, depth, view(), shown)
            alone = warp_image(colour, depth, view(), shown, warp, "pyramid", gpu=gpu)
            assert np.array_equal(one.colour, alone.colour) and np.array_equal(one.coverage, alone.coverage)
            assert one.hole_share == alone.hole_share and set(one.time_ms) == {*STAGES, "fill"}


def test_later_pictures_allocate_nothing_and_closing_frees_everything(gpu):
    before = living()
    with Warper(SIZE, fill="memory+pyramid", depth=True, gpu=gpu) as warper:
        warper.warp(*picture(0), view(), view((0.1, 0, 0)))
        with counting_made() as made:
            for number in range(1, 4):
                warper.warp(*picture(number), view(), view((0.1, 0, 0)))
        assert not made
    del warper
    assert living() <= before


def numbers(kind: type, channels: int, rng: np.random.Generator) -> np.ndarray:
    """(30, 41, channels) over the whole range of the type, also beyond what a half holds."""
    shape = (30, 41, channels)
    if kind is np.uint8:
        return rng.integers(0, 256, shape, np.uint8)
    values = rng.normal(size=shape) * 10.0 ** rng.integers(-9, 4, shape)
    values[0, :5] = [[0.0], [-0.0], [6e-8], [65504.0], [1e5 if kind is not np.float16 else 3.0]]
    if channels == 4:
        values[..., 3] = np.abs(values[..., 3]) + 1e-4
        values[5:9, 5:9, 3] = 0
    return values.astype(kind)


KINDS = [(np.uint8, None), *((kind, "linear") for kind in (np.float16, np.float32, np.float64)), (np.float32, "srgb")]
FORMS = ("metres", "float64", "float16", "millimetres", "int32", "masked")
# Every pair of kind, channels and form.
OF_ARRAYS = [(*kind, 3 + (k + n) % 2, form) for k, kind in enumerate(KINDS) for n, form in enumerate(FORMS)]


@pytest.mark.parametrize(("kind", "encoding", "channels", "form"), OF_ARRAYS)
def test_arrays_are_taken_over_as_in_float64(kind, encoding, channels, form, gpu):
    """The same arrays by NumPy in float64, then rounded to what textures hold.

    Light is the same half where NumPy's float32 gives it: a table of bytes, rounding to even; a
    power in float32 is good to 1e-5, and half's step is 2**-10. Inverse depth: the scale, the
    product and the division are each rounded in float32, the division to 2.5 units.
    """
    rng = np.random.default_rng(channels)
    colour = np.clip(numbers(kind, channels, rng), 0, 1) if encoding == "srgb" else numbers(kind, channels, rng)
    metres = rng.uniform(0.2, 60, (30, 41))
    metres[3, :6] = [0, -1, np.nan, np.inf, 1e-30, 1e30]
    depth, scale = metres.astype(np.float64 if form == "float64" else np.float32), None
    if form in ("float16", "masked"):
        depth = np.minimum(depth, 6e4).astype(np.float16)
    if form in ("millimetres", "int32"):
        depth, scale = (
            np.nan_to_num(np.clip(1000 * metres, 0, 65535)).astype("uint16" if form == "millimetres" else "int32"),
            0.001,
        )
    if form == "masked":
        depth = np.ma.masked_less(depth, 20)
    checked = raw_picture(colour, depth, scale, encoding).checked()
    covered = ~np.isnan(checked.depth)
    light = np.clip(checked.light, -65504, 65504) * covered[..., None]
    rgba = np.concatenate([light, covered[..., None]], axis=2).astype(np.float32)
    inverse = np.where(covered, checked.depth, -1).astype(np.float32)
    pair = allocate(gpu.gl, (41, 30), COLOUR), allocate(gpu.gl, (41, 30), SCALAR)
    taking, buffers = TakeIn(gpu, (41, 30)), PixelBuffers(gpu, 1)
    found = buffers.found
    found.clear()
    raw = raw_picture(colour, depth, scale, encoding)
    taking.run(raw, taking.send(raw, buffers), pair, found, 0)
    found.read()
    light, got = download(pair[0]), download(pair[1])
    assert not found.is_doubtful(0, (41, 30)) and found.has_largest(0) == (form == "millimetres")
    assert np.array_equal(got >= 0, inverse >= 0) and (got[got < 0] == -1).all()
    assert got == pytest.approx(inverse, rel=4.5 * 2**-23)
    wanted = rgba.astype(np.float16)
    if encoding == "srgb":
        assert light == pytest.approx(wanted, rel=2**-10 + 1e-5, abs=2**-24)
    else:
        assert np.array_equal(light, wanted)
    taking.close(), buffers.close()
    for texture in pair:
        texture.release()


@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_a_refused_picture_is_not_remembered(kind, gpu):
    """It looks like bytes as floats, or is no number somewhere: later holes show none of it."""
    dark, depth = np.full((30, 40, 3), 0.25, np.float32), np.full((30, 40), 3.0)
    aside, bad = view(yaw=25.0), np.full((30, 40, 3), 200, kind)
    with Warper(SIZE, fill="memory", gpu=gpu) as warper:
        for wrong, told in ((bad, "linear light has 1 for white"), (bad * np.inf, "row 0, column 0 is not a finite")):
            with pytest.raises(InputError, match=told):
                warper.warp(wrong.astype(kind), depth, aside, aside)
        after = warper.warp(dark, depth, view(), aside)
    assert (after.coverage == 0).mean() > 0.2 and after.colour.max() == 0.25


def test_a_fill_that_remembers_learns_from_each_picture(gpu):
    """What the second picture does not show, the first one did: only the Warper knows it."""
    # Infinitely far and of one colour: both pictures are of the same world.
    colour, depth = np.full((30, 40, 3), 0.25, np.float32), np.full((30, 40), np.inf)
    aside = view(yaw=25.0)
    with Warper(SIZE, warp="iterative", fill="memory", gpu=gpu) as warper:
        warper.warp(colour, depth, aside, aside)
        remembered = warper.warp(colour, depth, view(), aside)
    forgotten = warp_image(colour, depth, view(), aside, "iterative", "memory", gpu=gpu)
    assert forgotten.hole_share > 0.2 and (forgotten.coverage == 0).mean() > 0.2
    assert (remembered.coverage == 0).mean() < 0.02


def test_by_default_unrelated_pictures_know_nothing_of_each_other(gpu):
    """The fill of runs shows an earlier one in the holes of the next: see the test before."""
    bright, dark = (np.full((30, 40, 3), light, np.float32) for light in (1.0, 0.25))
    depth, aside = np.full((30, 40), np.inf), view(yaw=25.0)
    with Warper(SIZE, gpu=gpu) as warper:
        warper.warp(bright, depth, aside, aside)
        after = warper.warp(dark, depth, view(), aside)
    alone = warp_image(dark, depth, view(), aside, gpu=gpu)
    assert after.hole_share > 0.2 and (after.colour == alone.colour).all()


def test_a_warper_warns_once(gpu):
    """Of depth in millimetres, the largest integer, and no depth, at the first such picture."""
    colour, depth = np.zeros((30, 40, 3), np.uint8), np.full((30, 40), 2000.0)
    with Warper(SIZE, gpu=gpu) as warper:
        with pytest.warns(UserWarning) as caught:
            for _ in range(3):
                warper.warp(colour, depth, view(), view((0.05, 0, 0)))
                warper.warp(colour, np.full((30, 40), 65535, np.uint16), view(), view(), depth_scale=0.001)
        assert [str(warning.message)[:11] for warning in caught] == ["The nearest", "1200 pixels", "100.0 % of "]
        assert all(warning.filename == __file__ for warning in caught)


def test_the_depth_of_the_shown_view_comes_on_request(gpu):
    """A plane at 4 m, seen from 1 m nearer, is 3 m away in every pixel that it covers."""
    colour = picture(0)[0]
    with Warper(SIZE, warp="iterative", fill="none", depth=True, gpu=gpu) as warper:
        near = warper.warp(colour, np.full((30, 40), 4.0), view(), view((0, 0, -1.0)))
        far = warper.warp(colour, np.full((30, 40), np.inf), view(), view((0, 0, -1.0)))
    covered = near.coverage > 0
    assert near.depth_m is not None and covered.mean() > 0.9
    # float32 inverse depth on the way: 1e-6 of it, and the warp's own 1e-3 of a pixel.
    assert near.depth_m[covered] == pytest.approx(3.0, rel=1e-4)
    assert np.isnan(near.depth_m[~covered]).all()
    assert far.depth_m is not None and np.isinf(far.depth_m[far.coverage > 0]).all()
    assert warp_image(colour, np.full((30, 40), 4.0), view(), view(), gpu=gpu).depth_m is None


def test_textures_are_what_arrays_are(gpu):
    """By the id alone, as a caller's own renderer has them."""
    colour, depth = picture(6)
    with np.errstate(divide="ignore"):
        inverse = np.where(depth == 0, -1, 1 / depth).astype(np.float32)
    own = allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR)
    upload(own[0], np.dstack([colour * (inverse >= 0)[..., None], inverse >= 0]))
    upload(own[1], inverse)
    ids = [gpu.gl.external_texture(texture.glo, SIZE, texture.components, 0, texture.dtype) for texture in own]
    shown = view((0.1, 0, 0))
    with Warper(SIZE, fill="pyramid", depth=True, gpu=gpu) as warper:
        arrays = warper.warp(colour, depth, view(), shown)
        out = warper.warp_textures(*ids, view(), shown)
        found, shown_inverse = download(out.colour), download(out.inverse_depth)
        assert np.array_equal(found[..., :3].astype(np.float32), arrays.colour)
        assert np.array_equal(found[..., 3].astype(np.float32), arrays.coverage)
        for pair in ((colour, own[1]), (own[1], own[1]), own[::-1]):
            with pytest.raises(InputError, match="colour is .*: expected a moderngl.Texture of 4 components"):
                warper.warp_textures(*pair, view(), view())
    known = ~np.isnan(arrays.depth_m)
    assert np.array_equal(shown_inverse < 0, ~known)
    with np.errstate(divide="ignore"):
        exact = 1 / shown_inverse.astype(np.float64)[known]
    # A division in GLSL is within 2.5 units in the last of 24 bits.
    assert arrays.depth_m[known] == pytest.approx(exact, rel=2.5 * 2**-23)
    repairing, auto = {"repair": "complete"}, {"warp": "auto", "budget_ms": 1e6}
    for options in ({"gpu": None}, repairing, auto):
        with Warper(SIZE, **{"gpu": gpu, **options}) as warper, pytest.raises(InputError, match="textures are for a"):
            warper.warp_textures(*own, view(), view())
    with Warper(SIZE, effects="soft_motion", gpu=gpu) as warper, pytest.raises(InputError, match="runs on arrays"):
        warper.warp_textures(*own, view(), view())
    for texture in own:
        texture.release()


def test_a_context_of_its_own_belongs_to_its_thread(gpu):
    errors = []

    def elsewhere() -> None:
        with pytest.raises(InputError, match="made in another thread") as told:
            warper.warp(*picture(0), view(), view())
        errors.append(told.value)

    with Warper(SIZE, gpu=gpu) as warper:
        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()
    assert len(errors) == 1


def living() -> int:
    """Return how many textures are not released."""
    gc.collect()
    return sum(hasattr(thing, "release") for thing in gc.get_objects() if isinstance(thing, moderngl.Texture))


@pytest.mark.parametrize("is_shared", [True, False], ids=["shared", "own"])
def test_what_a_dropped_warper_held_is_freed_by_the_next_call(is_shared, gpu):
    """Also where another thread drops it, and by a call of a Warper that was there before."""
    own = {} if is_shared else {"gpu": gpu}
    with Warper(SIZE, **own) as kept:
        kept.warp(*picture(0), view(), view())
        before = living()
        dropped = [Warper(SIZE, fill="memory+pyramid", depth=True, **own)]
        dropped[0].warp(*picture(0), view(), view())
        thread = threading.Thread(target=dropped.clear)
        thread.start()
        thread.join()
        gc.collect()
        kept.warp(*picture(0), view(), view())
        assert living() == before


def test_nothing_of_a_released_object_is_kept(gpu):
    """Else each call of warp_image leaves thirty in the context's queue."""
    for _ in range(80):
        with Warper((1, 1), gpu=gpu):
            pass
    gc.collect()
    assert len(gpu.gl.objects) < 1100


@pytest.mark.parametrize("closed", ["Warper", "Gpu"])
def test_a_closed_warper_is_told(closed, gpu):
    with Gpu() as own, Warper(SIZE, gpu=own) as warper, Warper(SIZE, gpu=gpu) as other:
        (warper if closed == "Warper" else own).close()
        with pytest.raises(InputError, match="closed: make another"):
            warper.warp(*picture(0), view(), view())
        assert other.warp(*picture(0), view(), view()).coverage.any()
        assert other.warp(*picture(0), view(), view()).hole_share < 1


PROCESSES = """
import multiprocessing, os, sys, threading
import numpy as np
from hmdwarp import Fov, InputError, Pose, View, Warper, warp_image
from hmdwarp.gpu import Gpu

VIEW = View(Pose(), Fov.symmetric(1.5, 1.2))
ARRAYS = np.full((6, 8, 3), 90, np.uint8), np.full((6, 8), 2.0)

def mean(_=None):
    try:
        return warp_image(*ARRAYS, VIEW, VIEW).colour.mean()
    except InputError as error:
        return str(error)

def pooled(method):
    with multiprocessing.get_context(method).Pool(1) as pool:
        return pool.apply(mean)

if __name__ == "__main__":
    exec(sys.argv[1])
"""
CASES = {
    "pools": (
        "print(pooled('fork'), mean(), pooled('spawn'), pooled('forkserver'), pooled('fork'), mean())",
        "90.0 90.0 90.0 90.0 told 90.0",
    ),
    # Forked while another thread draws; the child leaves a block, and ends as a program does.
    "child": (
        """
inside, done = threading.Event(), threading.Event()
def draw():
    with Warper((8, 6)) as other, other._gpu(): inside.set(), done.wait()
thread = threading.Thread(target=draw)
thread.start(), inside.wait()
with Warper((8, 6), gpu=(own := Gpu())) as held, own:
    child = os.fork()
    if not child: print(mean(), flush=True), sys.exit(0)
done.set(), thread.join(), os.waitpid(child, 0), print(mean())
""",
        "told 90.0",
    ),
    # At the end of the program: a live Warper, one in a cycle, and a daemon thread that goes on.
    "exit": (
        """
warper, cycle = Warper((8, 6)), [Warper((8, 6))]
cycle.append(cycle)
begun = threading.Event()
def on():
    while True: mean(), begun.set()
threading.Thread(target=on, daemon=True).start()
begun.wait(), print(mean(), mean())
""",
        "90.0 90.0",
    ),
}
FORKED = "this process was forked from one that already used OpenGL"


@pytest.mark.parametrize("case", CASES)
def test_other_processes_warp_or_are_told_what_to_do(case, tmp_path):
    """None hangs; "told" stands for the error, which names the remedy."""
    (tmp_path / "processes.py").write_text(PROCESSES)
    # Python 3.12 and newer warn of a fork beside threads.
    quiet = ["-W", "ignore::DeprecationWarning"]
    command = [sys.executable, *quiet, str(tmp_path / "processes.py"), CASES[case][0]]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    told = ran.stdout.replace(FORKED + ",", "told").split()
    assert (ran.returncode, ran.stderr) == (0, "")
    assert " ".join(word for word in told if word in ("90.0", "told")) == CASES[case][1]
    assert ("told" in told) == ("multiprocessing.get_context('spawn') or 'forkserver'" in ran.stdout)


def test_arguments_that_do_not_fit_are_refused(gpu):
    colour, depth = picture(9)
    with Warper(SIZE, gpu=gpu) as warper:
        usual = {"colour": colour, "depth_m": depth, "rendered": view(), "shown": view()}
        for wrong, told in (
            ({"colour": colour[:, :20], "depth_m": depth[:, :20]}, "colour is 20x30 pixels: this Warper is for 40x30"),
            ({"others": 3 * [(colour, depth, view())]}, "others has 3 pictures, and warp 'iterative'.*at most 2"),
            ({"others": None}, "others is of type NoneType: expected a list of"),
            ({"layers": None}, "layers is of type NoneType: expected a dict of arrays by name"),
            ({"eye": 2}, "eye is 2: expected 0"),
            ({"shown": "here"}, "shown is a str"),
        ):
            with pytest.raises(InputError, match=told):
                warper.warp(**{**usual, **wrong})
        for copied in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(InputError, match="cannot be copied or sent to another process: make one there"):
                copied(warper)
    with Warper(SIZE, warp="multi", fill="none", gpu=gpu) as warper:
        with pytest.raises(InputError, match="warp 'multi' reads other pictures: give others="):
            warper.warp(colour, depth, view(), view())
        with pytest.raises(InputError, match=r"others\[0\]: expected \(colour, depth_m, view\)"):
            warper.warp(colour, depth, view(), view(), others=[colour[0, 0, :2]])
    with pytest.raises(InputError, match=r"gpu is of type Context: expected a hmdwarp.gpu.Gpu, as Gpu\(context\) is"):
        Warper(SIZE, gpu=gpu.gl)
    for name in warps.names():
        if not set(warps.get(name).reads_for(warps.get(name).Settings())) <= set(AVAILABLE):
            with pytest.raises(PlanError, match="Usable are warps"):
                Warper(SIZE, warp=name, fill="none", gpu=gpu)
