"""The public names: few, all there, and what they say they are whatever was imported before."""

from __future__ import annotations

import importlib
import inspect
import pkgutil

import pytest

import hmdwarp

PUBLIC = {
    "DepthLayer",
    "Fov",
    "Hidden",
    "Panel",
    "HmdwarpError",
    "InputError",
    "MachineError",
    "Pose",
    "PoseTrack",
    "RunOptions",
    "View",
    "WarpMap",
    "WarpedImage",
    "Warper",
    "compare",
    "inverse_depth_from_clip",
    "load_trace",
    "replay",
    "warp_image",
    "__version__",
}
MODULES = {"bench", "check", "sequences", "study"}
FUNCTIONS = {"compare", "inverse_depth_from_clip", "load_trace", "replay", "warp_image"}


def test_these_names_and_no_others():
    """Adding one is a decision: it is added here too."""
    assert set(hmdwarp.__all__) == PUBLIC | MODULES
    assert set(dir(hmdwarp)) >= PUBLIC


@pytest.mark.parametrize("name", sorted(PUBLIC - {"__version__"}))
def test_each_name_is_what_it_looks_like(name):
    thing = getattr(hmdwarp, name)
    assert inspect.isfunction(thing) if name in FUNCTIONS else inspect.isclass(thing)
    assert thing.__name__ == name and inspect.getdoc(thing)


def test_names_that_are_not_there_say_so():
    with pytest.raises(AttributeError, match="No hmdwarp attribute warp_imagee"):
        hmdwarp.warp_imagee  # noqa: B018


def test_every_module_can_be_imported_alone_after_another():
    """No module relies on another having been imported first, and none leaves a public name
    changed.
    """
    for module in pkgutil.walk_packages(hmdwarp.__path__, "hmdwarp."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    for name in FUNCTIONS:
        assert inspect.isfunction(getattr(hmdwarp, name))


def test_errors_are_one_family():
    assert issubclass(hmdwarp.InputError, hmdwarp.HmdwarpError) and issubclass(
        hmdwarp.MachineError, hmdwarp.HmdwarpError
    )
    assert [e.exit_status for e in (hmdwarp.HmdwarpError, hmdwarp.InputError, hmdwarp.MachineError)] == [1, 2, 3]


def test_the_example_of_the_package_runs():
    """design.

    Out = warp_image(colour, depth_m, rendered=View, shown=View, ..), out.colour, out.coverage,
    out.time_ms.
    """
    import numpy as np

    from hmdwarp import Fov, Pose, View

    fov = Fov(left=-0.7, right=0.7, down=-0.6, up=0.6)
    here = View(pose=Pose(position_m=(0, 1.6, 0), orientation_xyzw=(0, 0, 0, 1)), fov=fov)
    there = View(pose=Pose(position_m=(0.02, 1.6, 0), orientation_xyzw=(0, 0, 0, 1)), fov=fov)
    out = hmdwarp.warp_image(
        np.zeros((10, 12, 3), np.uint8),
        np.full((10, 12), 1.5),
        rendered=here,
        shown=there,
        warp="forward",
        fill="none",
        size=None,
    )
    assert out.colour.shape == (10, 12, 3) and out.coverage.shape == (10, 12) and out.time_ms["warp"] >= 0
