"""What the headset's display chooses from what a runtime offers.

How to draw, in which pictures, in which space.
"""

from __future__ import annotations

import ctypes
import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from hmdwarp.base import HmdwarpError, InputError, MachineError
from hmdwarp.display.openxr.diagnosis import load_binding
from hmdwarp.geometry import Pose

try:
    load_binding()
except MachineError as lacking:
    pytest.skip(str(lacking), allow_module_level=True)

import xr

from hmdwarp.display import DisplayOptions, Lost
from hmdwarp.display.openxr.connection import DEPTHS, RGBA8, RGBA16F, SRGB8_A8, colour_format, depth_format
from hmdwarp.display.openxr.graphics import VARIABLE, _put, check_requirements, kinds
from hmdwarp.display.openxr.runtime import Calls, Session
from hmdwarp.display.openxr.tracking import EYE_HEIGHT_M, HeadTracker, RuntimeEyes, _world
from hmdwarp.poses import Origin

BOTH = frozenset({"XR_KHR_opengl_enable", "XR_MNDX_egl_enable"})
X = {"DISPLAY": ":0"}
WATCHING = DisplayOptions().watching


@pytest.mark.parametrize(
    ("extensions", "environ", "wanted"),
    [
        (BOTH, X, ["glx", "egl"]),
        (BOTH, {}, ["egl"]),
        ({"XR_MNDX_egl_enable"}, X, ["egl"]),
        ({"XR_KHR_opengl_enable"}, X, ["glx"]),
        (BOTH, {**X, VARIABLE: "egl"}, ["egl"]),
        (BOTH, {**X, VARIABLE: "GLX"}, ["glx"]),
        (BOTH, {**X, VARIABLE: ""}, ["glx", "egl"]),
    ],
)
def test_a_window_is_preferred_and_either_can_be_insisted_on(extensions, environ, wanted):
    assert kinds(frozenset(extensions), environ) == wanted


def test_windows_has_one_way_and_its_addresses_lie_where_pyopenxr_reads_them():
    """Its binding is read, not imported: that needs Windows. A handle there has 64 bits."""
    assert kinds(BOTH, {}, "win32") == ["wgl"]
    text = (Path(xr.__file__).parent / "platform" / "windows.py").read_text(encoding="utf-8")
    (found,) = re.findall(r"class GraphicsBindingOpenGLWin32KHR.*?_fields_ = (\[.*?\])", text, re.DOTALL)
    names = re.findall(r'\("(\w+)", ([\w.]+)\)', found)
    assert names == [("h_dc", "wintypes.HDC"), ("h_glrc", "WGL.HGLRC")]
    fields = [(name, ctypes.c_void_p) for name, _ in names]
    binding = type("Binding", (ctypes.Structure,), {"_fields_": [("head", ctypes.c_void_p * 2), *fields]})()
    _put(binding, h_dc=0xFEDC_BA98_7654_3210, h_glrc=1)
    assert (binding.h_dc, binding.h_glrc, list(binding.head)) == (0xFEDC_BA98_7654_3210, 1, [None, None])


@pytest.mark.parametrize(
    ("extensions", "environ", "error", "words"),
    [
        ({"XR_KHR_opengl_enable"}, {}, MachineError, "DISPLAY is not set"),
        ({"XR_KHR_opengl_enable"}, {**X, VARIABLE: "egl"}, InputError, "is 'egl': expected glx"),
        (BOTH, {VARIABLE: "glx"}, InputError, "is 'glx': expected egl"),
        (BOTH, {**X, VARIABLE: "vulkan"}, InputError, "expected glx or egl"),
    ],
)
def test_no_way_to_draw_is_said(extensions, environ, error, words):
    with pytest.raises(error, match=words):
        kinds(frozenset(extensions), environ)


def test_the_best_format_and_the_best_known_floor_are_taken():
    assert colour_format([RGBA8, RGBA16F, SRGB8_A8]) == SRGB8_A8
    assert colour_format([0x805B, RGBA8, RGBA16F]) == RGBA16F
    with pytest.raises(MachineError, match="0x805b: expected one of 0x8c43"):
        colour_format([0x805B])
    assert depth_format([DEPTHS[3], DEPTHS[0], RGBA8]) == DEPTHS[0]
    assert depth_format([RGBA8]) is None
    stage, local, floor = (xr.ReferenceSpaceType[name].value for name in ("STAGE", "LOCAL", "LOCAL_FLOOR"))
    assert _world({local, stage, floor}, floor=True)[1].value == stage
    assert _world({local, floor}, floor=True)[1].value == floor
    assert _world({local, floor}, floor=False)[1:] == (xr.ReferenceSpaceType.LOCAL, EYE_HEIGHT_M)


# --- results of calls ---------------------------------------------------------------------------


RESULTS = {  # of calls in a session: losses, lacks, internal errors (of wrong calls), qualified successes
    **dict.fromkeys((-13, -17, -2), Lost), **dict.fromkeys((-3, -987654321), MachineError),
    **dict.fromkeys((-1, -37), HmdwarpError), **dict.fromkeys((0, 1, 3, 4, 8, 9)),
}  # fmt: skip


@pytest.mark.parametrize("result", RESULTS)
def test_a_result_is_handed_back_or_raised_as_what_it_means(result):
    calls, error = Calls(WATCHING), RESULTS[result]
    calls._functions["xrEndFrame"] = lambda *arguments: result
    calls.name, calls.stage = "Runtime 1", "running"
    if error is None:
        assert calls("xrEndFrame") == result
        return
    with pytest.raises(HmdwarpError) as raised:
        calls("xrEndFrame")
    assert type(raised.value) is error and "\n" not in str(raised.value)
    assert ("xrEndFrame" if error is HmdwarpError else "Runtime 1") in str(raised.value)
    assert raised.value.exit_status == (1 if error is HmdwarpError else 3)


def test_a_driver_that_is_too_old_is_refused():
    needs = SimpleNamespace(min_api_version_supported=int(xr.Version(4, 6, 0).number()))
    calls = SimpleNamespace(call_once=lambda *arguments: needs, name="Runtime 1")
    instance = SimpleNamespace(extensions=BOTH, handle=None, system=0)
    with pytest.raises(MachineError, match=r"Runtime 1 wants OpenGL 4.6, found 4.5"):
        check_requirements(calls, instance, SimpleNamespace(gl=SimpleNamespace(version_code=450)))
    check_requirements(calls, instance, SimpleNamespace(gl=SimpleNamespace(version_code=460)))


# --- flags that no runtime here sets ------------------------------------------------------------

ORIENTATION_VALID, POSITION_VALID, ORIENTATION_TRACKED = 1, 2, 4


class Told:
    """A tracker whose runtime says what the test says."""

    def __init__(self) -> None:
        self.tracker = HeadTracker()
        self.flags, self.position, self.orientation = 0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
        self.tracker._calls, self.tracker.offset_ns = self._answer, 0
        self.tracker._spaces = SimpleNamespace(head=None, world=None, kind=xr.ReferenceSpaceType.STAGE)

    def _answer(self, *_: object) -> int:
        location = self.tracker._location
        location._location_flags = self.flags
        location.pose.position.x, location.pose.position.y, location.pose.position.z = self.position
        turned = location.pose.orientation
        turned.x, turned.y, turned.z, turned.w = self.orientation
        return 0

    def at(self, time_ns: int, flags: int, position=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0)):
        self.flags, self.position, self.orientation = flags, position, orientation
        return self.tracker.head_at(time_ns)


def test_before_the_first_pose_someone_stands_there():
    sample = Told().at(5, 0)
    assert sample.origin is Origin.HELD and sample.time_ns == 5
    assert sample.pose.isclose(Pose((0, EYE_HEIGHT_M, 0)))


def test_a_guess_is_no_measurement():
    """How a runtime says that it has lost track of a headset.

    What it last knew stays valid, and is not tracked.
    """
    told = Told()
    both = ORIENTATION_VALID | POSITION_VALID
    sample = told.at(5, both, position=(1.0, 2.0, 3.0))
    assert sample.origin is Origin.HELD and told.tracker.lost
    assert np.array_equal(sample.pose.position_m, (1, 2, 3))
    assert told.at(5, both | ORIENTATION_TRACKED).origin is Origin.MEASURED and not told.tracker.lost
    assert told.at(2**62, both | ORIENTATION_TRACKED).origin is Origin.PREDICTED


TURNED = (0.0, math.sin(0.4), 0.0, math.cos(0.4))


@pytest.mark.parametrize("orientation", [TURNED, (0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0)])
def test_what_a_pose_lacks_is_held(orientation):
    """A headset that knows only turns turns where it is; one whose pose is none is lost."""
    told, is_known = Told(), orientation is TURNED
    told.at(5, ORIENTATION_VALID | POSITION_VALID, position=(1.0, 2.0, 3.0))
    flags = ORIENTATION_VALID | (ORIENTATION_TRACKED if is_known else POSITION_VALID)
    sample = told.at(6, flags, position=(9.0, 9.0, 9.0), orientation=orientation)
    assert np.array_equal(sample.pose.position_m, (1, 2, 3))
    assert np.allclose(sample.pose.orientation_xyzw, TURNED if is_known else (0, 0, 0, 1), atol=1e-7)
    assert told.tracker.lost == (sample.origin is Origin.HELD) == (not is_known)


def test_eyes_that_are_not_valid_stay_as_they_were():
    eyes, said = RuntimeEyes(), {"flags": 0, "left": -0.7}

    def calls(*_: object) -> int:
        eyes._state._view_state_flags = said["flags"]
        for view in eyes._views:
            fov = view.fov
            fov.angle_left, fov.angle_right, fov.angle_down, fov.angle_up = said["left"], 0.7, -0.7, 0.7
        return 0

    # The third has its left edge to the right of the right one.
    for flags, left, wanted in ((0, -0.7, None), (3, -0.7, -0.7), (3, 0.8, -0.7), (0, -0.5, -0.7), (3, -0.5, -0.5)):
        said.update(flags=flags, left=left)
        eyes.locate(calls, None, None, 1)
        assert eyes.known == (wanted is not None)
        if eyes.known:
            assert [view.fov.left for view in eyes.views(Pose())] == pytest.approx([wanted, wanted])


class Events:
    """Calls of a runtime that has these events to tell of, and nothing else."""

    def __init__(self, *events: xr.EventDataReferenceSpaceChangePending) -> None:
        self._events = list(events)
        self.name = "a runtime"

    def call_once(self, function, *_: object) -> int:
        return 1

    def __call__(self, call: str, instance: object, buffer) -> int:
        if not self._events:
            return xr.Result.EVENT_UNAVAILABLE.value
        event = self._events.pop(0)
        ctypes.memmove(buffer, ctypes.byref(event), ctypes.sizeof(event))
        return 0


def test_a_recentre_of_the_runtime_changes_the_space_of_later_poses_alone():
    told = Told()
    tracked = ORIENTATION_VALID | ORIENTATION_TRACKED
    assert told.at(90, tracked).space == told.at(200, tracked).space == 0
    kinds = (xr.ReferenceSpaceType.LOCAL, 50), (xr.ReferenceSpaceType.STAGE, 100)
    calls = Events(*(xr.EventDataReferenceSpaceChangePending(None, kind, at) for kind, at in kinds))
    session = Session(calls, SimpleNamespace(handle=None, system=0), xr.GraphicsBindingEGLMNDX())
    session.on_world_change = told.tracker.world_changes
    session.poll()
    assert [told.at(at, tracked).space for at in (60, 99, 100, 200)] == [0, 0, 1, 1]
    told.tracker.offset_ns = 50  # the runtime's clock is ahead
    assert [told.at(at, tracked).space for at in (49, 50)] == [0, 1]
