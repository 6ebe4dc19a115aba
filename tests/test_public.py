"""The public names: few, all there, and what they say they are whatever was imported before."""

from __future__ import annotations

import importlib
import inspect
import itertools
import math
import pkgutil
import pydoc
import re
import warnings
from pathlib import Path

import attrs
import numpy as np
import pytest

import hmdwarp

ROOT = Path(__file__).resolve().parents[1]
PUBLIC = {
    "DepthLayer", "Fov", "Hidden", "Panel", "HmdwarpError", "InputError", "MachineError", "Pose", "PoseTrack",
    "RunOptions", "View", "WarpMap", "WarpedImage", "Warper", "choose", "compare",
    "load_trace", "replay", "warp_image", "__version__",
}  # fmt: skip
MODULES = {"bench", "check", "feed", "metrics", "sequences", "study"}
FUNCTIONS = {"choose", "compare", "load_trace", "replay", "warp_image"}


def test_these_names_and_no_others():
    """Adding one is a decision: it is added here too."""
    assert set(hmdwarp.__all__) == PUBLIC | MODULES
    assert set(dir(hmdwarp)) >= PUBLIC


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


def test_functions_that_docs_name_say_what_they_take():
    """What is looked up in an editor has NumPy's sections."""
    pages = [*(ROOT / "docs").glob("*.md"), ROOT / "README.md", *(ROOT / "examples").glob("*.py")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    named = {path[1:] for path in re.findall(r"\bhmdwarp((?:\.[A-Za-z_]\w*)+)", text)}
    for package, names in re.findall(r"from hmdwarp((?:\.\w+)*) import ([\w, ]+)", text):
        named |= {f"{package}.{name}".strip(".") for name in re.findall(r"\w+", names)}
    told = {}
    for path in named:
        found = pydoc.locate(f"hmdwarp.{path}")
        if inspect.isroutine(found) and inspect.signature(found).parameters:
            told[path] = "Parameters\n---" in inspect.getdoc(found)
    assert len(told) > 15 and [path for path, is_told in told.items() if not is_told] == []


class OnAGpu:
    """A tensor that cannot be read from here: what reading it raises is its library's."""

    def __array__(self, *_, **__):
        raise RuntimeError("copy the tensor to host memory first")


WRONG = {
    **{repr(value): value for value in (None, "x", "", b"x", -1, 0.5, 1j, (), [1, [2]], {}, {"a": 1}, len)},
    **{"huge": 10**400, "NaN": math.nan, "infinite": math.inf, "an object": object(), "on a GPU": OnAGpu()},
    **{"long": "x" * 5000, "folder": Path("/"), "a number as text": "0.5", "true": True},
    **{"empty": np.zeros(0), "texts": np.array(["a", "b"]), "objects": np.array([None, 1], object), "2d": np.eye(4)},
    "records": np.zeros((4, 6), [("a", "f4")]),
}


def public_calls():
    """Callables with arguments that are right."""
    fov, pose = hmdwarp.Fov(-0.7, 0.7, -0.6, 0.6), hmdwarp.Pose()
    view, colour, depth_m = hmdwarp.View(pose, fov), np.zeros((4, 6, 3), np.uint8), np.ones((4, 6))
    hidden = {"polygons": (((0.5, 0), (1, 0), (1, 1)),), "fov": fov}
    frames = dict.fromkeys(inspect.signature(hmdwarp.warp_image).parameters)
    frames |= {"colour": colour, "depth_m": depth_m, "rendered": view, "shown": view, "warp": "none", "fill": "none"}
    frames |= {"effects": "none", "repair": "none", "others": (), "layers": {}, "age_s": 0.0, "depth": False}
    track = {"time_ns": np.arange(3), "position_m": np.zeros((3, 3)), "orientation_xyzw": np.tile((0, 0, 0, 1), (3, 1))}
    panel = {"pictures": colour, "pose": pose, "size_m": (1, 1), "seconds": 1.0}
    sizes = {"frm_size": (6, 4), "to_size": (6, 4)}
    pair = {"shown": colour, "truth": colour}
    options = dict.fromkeys(field.alias for field in attrs.fields(hmdwarp.RunOptions) if field.init)
    return {
        "Pose": (hmdwarp.Pose, {"position_m": (0, 0, 0), "orientation_xyzw": (0, 0, 0, 1)}),
        "Pose.transform": (pose.transform, {"points": (1, 2, 3)}),
        "Pose.relative_to": (pose.relative_to, {"other": pose}),
        "Pose.towards": (pose.towards, {"other": pose, "share": 0.5}),
        "Fov": (hmdwarp.Fov, {"left": -1, "right": 1, "down": -1, "up": 1}),
        "Fov.symmetric": (hmdwarp.Fov.symmetric, {"horizontal_rad": 1, "vertical_rad": 1}),
        "Fov.from_tangents": (hmdwarp.Fov.from_tangents, {"tangents": (-1, 1, -1, 1)}),
        "Fov.from_intrinsics": (
            hmdwarp.Fov.from_intrinsics,
            {"fx": 5, "fy": 5, "cx": 3, "cy": 2, "width": 6, "height": 4, "centre": 0},
        ),
        "View": (hmdwarp.View, {"pose": pose, "fov": fov, "head_from_eye": pose, "hidden": None, "gaze": None}),
        "Hidden": (lambda **given: hmdwarp.View(pose, fov, hidden=hmdwarp.Hidden(**given)).seen((6, 4)), hidden),
        "WarpMap.between": (hmdwarp.WarpMap.between, {"frm": view, "to": view, **sizes}),
        "WarpMap.apply": (hmdwarp.WarpMap.between(view, (6, 4), view, (6, 4)).apply, {"pixels": (1, 2)}),
        "DepthLayer": (hmdwarp.DepthLayer, {"min_depth": 0, "max_depth": 1, "near_z": 0.1, "far_z": 9}),
        "Panel": (hmdwarp.Panel, panel),
        "PoseTrack": (hmdwarp.PoseTrack, {**track, "jumps": (), "max_gap_ns": 9, "gaze": None, "notes": ()}),
        "load_trace": (hmdwarp.load_trace, {"options": None}),
        "RunOptions": (lambda **given: hmdwarp.RunOptions(**{"trace": "walk", **given}), options),
        "warp_image": (hmdwarp.warp_image, frames),
        "replay": (hmdwarp.replay, {"options": None}),
        **{name: (getattr(hmdwarp.metrics, name), pair) for name in hmdwarp.metrics.__all__},
        "compare": (hmdwarp.compare, {"options": None}),
        "bench": (hmdwarp.bench.bench, {"options": None}),
        "sequences.open": (hmdwarp.sequences.open, {"path": "x", "options": None}),
        "sequences.read_frame": (hmdwarp.sequences.read_frame, {"path": "x.npz", "depth": None, "camera": None}),
        "sequences.read_view": (hmdwarp.sequences.read_view, {"path": "x.json"}),
        "sequences.read_colour": (hmdwarp.sequences.read_colour, {"path": "x.png"}),
        "sequences.read_depth": (hmdwarp.sequences.read_depth, {"path": "x.png"}),
    }


FIRST = {"WarpMap.apply": {"inverse_depth": 0.5}, "load_trace": {"name_or_path": "still"}}


@pytest.mark.parametrize("name", public_calls())
def test_whatever_an_argument_is_the_error_is_ours_and_short(name):
    """A wrong type, shape or unit is never an AttributeError from within."""
    call, right = public_calls()[name]
    # All options of a run are left out but for one.
    rest = FIRST.get(name, {}) if name == "RunOptions" else {**FIRST.get(name, {}), **right}
    for argument, (kind, value) in itertools.product(right, WRONG.items()):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                call(**{**rest, argument: value})
        except hmdwarp.HmdwarpError as error:
            assert len(str(error)) < (6000 if kind == "long" else 1000), argument
            assert "\n" not in str(error), (argument, kind)
        except Exception as error:
            error.add_note(f"{argument} is {kind}")
            raise
