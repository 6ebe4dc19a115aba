"""The headset's display with a real runtime.

Whose eyes and head it has, what it hands over, and that it lets go whatever happens.
"""

from __future__ import annotations

import contextlib
import ctypes
import itertools
import math
import signal
import time

import attrs
import numpy as np
import pytest
import xr
from display.virtual_screen import until

from hmdwarp.base import InputError, MachineError, picture_from_linear
from hmdwarp.display import DisplayOptions
from hmdwarp.display.openxr import OpenXrDisplay
from hmdwarp.display.openxr.connection import NEAR_M, Swapchain
from hmdwarp.display.openxr.runtime import Calls
from hmdwarp.geometry import Fov, Pose
from hmdwarp.gpu import download, flip_rows
from hmdwarp.poses import Origin, angle_between, load_trace

from .live_runs import LONG_S, SMALL, Here, quick

pytestmark = pytest.mark.usefixtures("no_screen")

HEAD = Pose((0.1, 1.7, -0.25), (0.1, -0.2, 0.05, 0.97))
UNLIKE = [
    (Pose((-0.034, 0.002, 0.01)), Fov(-0.8, 0.6, -0.7, 0.5)),
    (Pose((0.029, -0.001, 0.0), (0.0, 0.1, 0.0, 1.0)), Fov(-0.55, 0.75, -0.65, 0.6)),  # canted outwards, too
]
FLOAT32 = 2e-7  # relative step of the runtime's numbers, all of which are below 2 here


@pytest.fixture(autouse=True)
def no_hang():
    """A frame left open blocks the next xrWaitFrame for ever, inside C."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(int(LONG_S))
    yield
    signal.alarm(0)


@pytest.fixture
def display(monado):
    made = OpenXrDisplay(DisplayOptions(size=SMALL))
    yield made
    made.close()


def frames(display, count: int) -> list:
    """Empty ones."""
    ticks = []
    while len(ticks) < count:
        tick = display.wait()
        if tick is not None:
            ticks.append(tick)
            display.show(None)
    return ticks


def until_head_at(display, wanted: Pose) -> None:
    """What is put there takes a fraction of a millisecond to be known."""
    until(lambda: display.source.head_at(display.now_ns()).pose.isclose(wanted, 1e-5), "that head")


# --- whose eyes and head ------------------------------------------------------------------------


def test_the_head_is_the_runtimes(display, remote_head):
    remote_head.put(HEAD)
    until_head_at(display, HEAD)
    now_ns = display.now_ns()
    # Further ahead than any machine stands still.
    past, to_come = display.source.head_at(now_ns - 1_000_000), display.source.head_at(now_ns + 60_000_000_000)
    for sample in (past, to_come):
        assert np.abs(sample.pose.position_m - HEAD.position_m).max() < FLOAT32
        # Monado turns it into its own space and back: a few steps more.
        assert angle_between(sample.pose.orientation_xyzw, HEAD.orientation_xyzw) < 10 * FLOAT32
        assert now_ns <= sample.read_ns <= display.now_ns()
    assert (past.origin, to_come.origin) == (Origin.MEASURED, Origin.PREDICTED)


def test_eyes_follow_the_runtime_while_it_runs(display, remote_head):
    before = display.eyes.views(HEAD)
    assert before[1].head_from_eye.position_m[0] - before[0].head_from_eye.position_m[0] == pytest.approx(
        0.063, abs=0.01
    )
    remote_head.put_eyes(UNLIKE)
    until(lambda: frames(display, 1) and display.eyes.views(HEAD)[0].fov.left != before[0].fov.left, "other eyes")
    for view, (head_from_eye, fov) in zip(display.eyes.views(HEAD), UNLIKE, strict=True):
        assert view.head_from_eye.isclose(head_from_eye, 4 * FLOAT32)
        assert view.pose.isclose(HEAD @ head_from_eye, 1e-6)
        assert np.allclose(attrs.astuple(view.fov), attrs.astuple(fov), atol=1e-7)


def test_a_head_that_is_lost_is_held_where_it_was(display, remote_head, monado):
    """A dead service's locations are identities without a flag, and no error, as long as nobody
    polls.
    """
    remote_head.put(HEAD)
    until_head_at(display, HEAD)
    assert not display.source.lost
    monado.kill()
    sample = display.source.head_at(display.now_ns())
    assert display.source.lost and sample.origin is Origin.HELD
    assert sample.pose.isclose(HEAD, 1e-5)


# --- what is handed over ------------------------------------------------------------------------


class HandedOver:
    """What reached the runtime.

    At each xrEndFrame the views of its layer, and each picture as it was when it was released.
    """

    def __init__(self, monkeypatch) -> None:
        self.layers: list[list[dict[str, object]]] = []
        self.pictures: list[np.ndarray] = []
        call, acquire, release, drawn = Calls.__call__, Swapchain.acquire, Swapchain.release, {}

        def calling(calls, name, *arguments):
            if name == "xrEndFrame":
                self.layers.append(_views(arguments[1]._obj))
            return call(calls, name, *arguments)

        def acquiring(swapchain):
            drawn[swapchain] = acquire(swapchain)
            return drawn[swapchain]

        def releasing(swapchain):
            how = {"components": 1, "attachment": -1, "dtype": "f4"} if swapchain.is_depth else {"components": 4}
            pixels = np.frombuffer(drawn[swapchain].read(**how), np.float32 if swapchain.is_depth else np.uint8)
            shape = swapchain.size[::-1] if swapchain.is_depth else (*swapchain.size[::-1], 4)
            self.pictures.append(flip_rows(pixels.reshape(shape)))
            release(swapchain)

        monkeypatch.setattr(Calls, "__call__", calling)
        monkeypatch.setattr(Swapchain, "acquire", acquiring)
        monkeypatch.setattr(Swapchain, "release", releasing)


def _views(end: xr.FrameEndInfo) -> list[dict[str, object]]:
    if not end.layer_count:
        return []
    layer = ctypes.cast(end._layers[0], ctypes.POINTER(xr.CompositionLayerProjection)).contents
    found = []
    for view in layer.views:
        at, turned, fov = view.pose.position, view.pose.orientation, view.fov
        depth = view._next and ctypes.cast(view._next, ctypes.POINTER(xr.CompositionLayerDepthInfoKHR)).contents
        found.append({
            "position": (at.x, at.y, at.z), "orientation": (turned.x, turned.y, turned.z, turned.w),
            "fov": (fov.angle_left, fov.angle_right, fov.angle_down, fov.angle_up),
            "depth": (depth.min_depth, depth.max_depth, depth.near_z, depth.far_z) if depth else None,
        })  # fmt: skip
    return found


@pytest.mark.parametrize(("warp", "depth_layer"), [("forward", True), ("backward", True), ("forward", False)])
def test_pictures_arrive_with_what_they_were_made_for(remote_head, monkeypatch, tmp_path, warp, depth_layer):
    """Each eye's picture within a step of 8 bits, its depth as float32 has it, and the very pose
    and field of view it was warped for: of the runtime's eyes on its head, which is recorded.
    """
    remote_head.put(HEAD)
    remote_head.put_eyes(UNLIKE)
    here, expected, handed_over = Here(monkeypatch), [], HandedOver(monkeypatch)

    def after(number: int) -> None:
        refresh = here.shown[-1]
        for one, eye in zip(refresh.inputs, refresh.eyes, strict=True):
            depth = download(eye.inverse_depth) if depth_layer else None
            expected.append((one.shown, picture_from_linear(download(eye.panel.texture)), depth))

    how = {"scene": "room", "warp": warp, "fill": "interpolate", "depth_layer": depth_layer}
    here.run(quick(pictures=4, record=tmp_path / "head.csv", **how), after)
    track = load_trace(tmp_path / "head.csv").track
    assert len(track) == 4 and np.abs(track.position_m - HEAD.position_m).max() < FLOAT32
    layers, pictures = [layer for layer in handed_over.layers if layer], iter(handed_over.pictures)
    assert len(layers) == 4
    for view, (shown, picture, inverse_depth) in zip(itertools.chain(*layers), expected, strict=True):
        assert np.array_equal(view["position"], shown.pose.position_m.astype(np.float32))
        assert np.array_equal(view["orientation"], shown.pose.orientation_xyzw.astype(np.float32))
        fov = shown.fov
        assert any(shown.pose.isclose(HEAD @ from_eye, 1e-6) for from_eye, _ in UNLIKE)
        assert np.array_equal(view["fov"], np.float32([fov.left, fov.right, fov.down, fov.up]))
        arrived = next(pictures)
        # Half a step by rounding here, and up to 0.6 by the encoding in hardware that OpenGL
        # allows.
        assert np.abs(arrived[..., :3].astype(int) - picture[..., :3]).max() <= 1
        assert (arrived[..., 3] == 255).all() and arrived[..., :3].std() > 5
        assert (view["depth"] is not None) == depth_layer
        if depth_layer:
            assert view["depth"] == pytest.approx((0, 1, math.inf, NEAR_M), rel=1e-7)
            assert np.allclose(next(pictures), np.clip(NEAR_M * inverse_depth, 0, 1), rtol=1e-6, atol=0)
    assert next(pictures, None) is None


def test_invisible_pictures_are_not_handed_over(display, monkeypatch):
    handed_over = HandedOver(monkeypatch)
    for label, rendered in (("", 1), ("waiting", 1), ("waiting", 0)):
        display.wait()
        display._connection.frames.state.should_render &= rendered
        display.show(None, label)
    assert [len(layer) for layer in handed_over.layers] == [0, 2, 0]
    assert len(handed_over.pictures) == 2
    for picture in handed_over.pictures:  # black, and a text in it
        assert (picture[:20, :, :3] == 0).all() and picture[..., :3].max() > 100


# --- in step, whatever happens ------------------------------------------------------------------


def test_refreshes_that_went_by_are_counted(display):
    ticks = frames(display, 3)
    assert [tick.period_ns for tick in ticks] == [50_000_000] * 3 and display.rate_hz == pytest.approx(20)
    assert ticks[-1].shown_ns < display.now_ns() + 1_000_000_000 < time.monotonic_ns() + 2_000_000_000
    display.wait()
    time.sleep(0.22)
    display.show(None)
    assert sum(tick.missed for tick in frames(display, 2)) >= 3  # 4 periods of 50 ms and a bit


@pytest.mark.parametrize(
    ("when", "call"), [("after", "xrWaitFrame"), ("after", "xrBeginFrame"), ("before", "xrEndFrame")]
)
def test_an_interrupt_in_a_frame_leaves_none_open(display, monkeypatch, call, when):
    frames(display, 2)
    calling, hit = Calls.__call__, []

    def interrupted(calls, name, *arguments):
        is_ours = name == call and not hit
        result = None if is_ours and when == "before" else calling(calls, name, *arguments)
        if is_ours:
            hit.append(name)
            raise KeyboardInterrupt
        return result

    monkeypatch.setattr(Calls, "__call__", interrupted)
    with pytest.raises(KeyboardInterrupt):
        frames(display, 1)
    frames(display, 3)  # blocks for ever where one was left open


def test_what_is_refused_leaves_nothing(monado):
    """A size beyond the runtime's, and a second display beside one that goes on."""
    with pytest.raises(InputError, match="takes pictures up to"):
        OpenXrDisplay(DisplayOptions(size=(100_000, 64)))
    display = OpenXrDisplay(DisplayOptions(size=SMALL))
    with pytest.raises(MachineError, match="LimitReachedError"):
        OpenXrDisplay(DisplayOptions(size=SMALL))
    with display.gpu.current():
        frames(display, 2)
    display.close()


def test_every_call_that_may_hang_is_watched(monado):
    watched = []

    def watching(what: str) -> contextlib.nullcontext:
        watched.append(what)
        return contextlib.nullcontext()

    display = OpenXrDisplay(DisplayOptions(size=SMALL, watching=watching))
    opened = set(watched)
    watched.clear()
    display.wait()
    display.show(None, "text")
    display.close()
    assert {"xrCreateInstance", "xrCreateSession", "xrCreateSwapchain", "xrBeginSession"} <= opened
    frame = {"xrPollEvent", "xrWaitFrame", "xrBeginFrame", "xrLocateViews", "xrWaitSwapchainImage", "xrEndFrame"}
    assert frame <= set(watched)
