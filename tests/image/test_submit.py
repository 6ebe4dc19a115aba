"""Warper.submit: the results of warp, with several pictures on their way."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp import Fov, InputError, Pose, View, Warper

SIZE = (70, 50)
FOV = Fov.symmetric(1.2, 0.95)


def view(x: float) -> View:
    return View(Pose((x, 0, 0)), FOV)


def frames(count: int, kind: type = np.uint8) -> list[dict[str, object]]:
    """Pictures of two planes with holes, each moved on."""
    rng = np.random.default_rng(5)
    found = []
    for number in range(count):
        colour = rng.integers(0, 256, (50, 70, 3)).astype(np.uint8)
        depth = np.full((50, 70), 3.0, np.float32)
        depth[10:40, 20 + number : 40] = 1.0
        depth[:3] = 0
        colour = colour if kind is np.uint8 else (colour / 255).astype(kind)
        found.append({"colour": colour, "depth_m": depth, "rendered": view(0.01 * number), "shown": view(0.1)})
    return found


def same(one, other) -> bool:
    assert (one.depth_m is None) == (other.depth_m is None) and one.hole_share == other.hole_share
    names = ("colour", "coverage", *([] if one.depth_m is None else ["depth_m"]))
    return all(np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True) for name in names)


@pytest.mark.parametrize("kind", [np.uint8, np.float64])
@pytest.mark.parametrize("options", [{"fill": "memory+pyramid"}, {"fill": "pyramid", "repair": "complete"}])
def test_results_are_those_of_warp_in_any_order_of_asking(options, kind, gpu):
    """Each equal bit for bit: also where the caller's arrays hold something else by then."""
    given = frames(7, kind)
    with Warper(SIZE, depth=True, gpu=gpu, **options) as warper:
        wanted = [warper.warp(**frame, eye=number % 2) for number, frame in enumerate(given)]
    with Warper(SIZE, depth=True, gpu=gpu, **options) as warper:
        pending = []
        for number, frame in enumerate(given):
            pending.append(warper.submit(**frame, eye=number % 2))
            frame["colour"][:], frame["depth_m"][:] = 3, np.nan
        got = [one.result() for one in reversed(pending)][::-1]
        assert all(map(same, got, wanted)) and pending[0].result() is got[0]


def test_each_frame_comes_in_turn_while_the_next_two_are_on_their_way(gpu):
    given, taken = frames(6), []

    def coming():
        for number, frame in enumerate(given):
            taken.append(number)
            yield frame

    with Warper(SIZE, depth=True, gpu=gpu) as warper:
        wanted = [warper.warp(**frame) for frame in given]
        for number, (got, want) in enumerate(zip(warper.warp_each(coming()), wanted, strict=True)):
            assert same(got, want) and len(taken) == min(number + 3, 6)


def test_buffers_are_those_of_three_calls_however_many_are_pending(gpu, monkeypatch):
    """Results that nobody has asked for wait as arrays, those of `out` written."""
    given = frames(9)
    with Warper(SIZE, gpu=gpu) as warper:
        warper.warp(**given[0])
        made, usual = [], gpu.gl.buffer
        monkeypatch.setattr(gpu.gl, "buffer", lambda *a, **k: (made.append(k), usual(*a, **k))[1])
        out = np.zeros((50, 70, 3), np.uint8)
        pending = [
            warper.submit(**frame, out={"colour": out} if not number else {}) for number, frame in enumerate(given)
        ]
        count = len(made)
        assert 0 < count <= 2 * 5 and out.any()  # each: what was found, two up, two down
        assert pending[0].result().colour is out
        for _ in range(3):
            pending = [warper.submit(**frame) for frame in given]
        assert len(made) == count and all(
            same(one.result(), warper.warp(**f)) for one, f in zip(pending, given, strict=True)
        )


def test_what_is_wrong_with_a_frame_is_told_by_its_result(gpu):
    """In the words of warp; those before and after it are as they would be without it."""
    bad = [dict(frame) for frame in frames(5, np.float32)]
    bad[1]["colour"] = bad[1]["colour"] * np.float32(200)
    bad[2]["depth_m"] = bad[2]["depth_m"][:-1]
    bad[3]["colour"] = np.where(np.arange(70)[:, None] == 6, np.nan, bad[3]["colour"])
    for fill in ("pyramid", "memory+pyramid"):
        with Warper(SIZE, fill=fill, gpu=gpu) as warper, Warper(SIZE, fill=fill, gpu=gpu) as alone:
            pending = [warper.submit(**frame) for frame in bad]
            bad[3]["colour"][:] = 0 if fill == "memory+pyramid" else bad[3]["colour"]
            for number, (one, frame) in enumerate(zip(pending, bad, strict=True)):
                if number in (0, 4):
                    assert same(one.result(), alone.warp(**frame))
                    continue
                with pytest.raises(InputError) as late:
                    one.result()
                if number != 3 or fill == "pyramid":
                    with pytest.raises(InputError) as at_once:
                        alone.warp(**frame)
                    assert str(late.value) == str(at_once.value)


def test_an_error_does_not_hide_the_frames_before_it(gpu):
    given = frames(4)
    given[2]["depth_m"] = -given[2]["depth_m"]
    with Warper(SIZE, gpu=gpu) as warper:
        coming = warper.warp_each(given)
        assert same(next(coming), warper.warp(**given[0])) and same(next(coming), warper.warp(**given[1]))
        with pytest.raises(InputError, match="negative everywhere"):
            next(coming)


def test_what_is_pending_when_the_warper_is_closed_says_so(gpu):
    with Warper(SIZE, gpu=gpu) as warper:
        done, dropped = (warper.submit(**frame) for frame in frames(2))
        image = done.result()
    with pytest.raises(InputError, match=r"closed before result\(\) was called"):
        dropped.result()
    assert done.result() is image
    with pytest.raises(InputError, match="closed: make another"):
        warper.submit(**frames(1)[0])
