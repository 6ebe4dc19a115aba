"""Warp one's own RGB-D frame: one call, one eye, no scene, no headset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from numpy.typing import ArrayLike

from ..geometry import View
from ..gpu.context import Gpu
from .given_arrays import checked, checked_size, checked_view
from .warper import Other, WarpedImage, Warper


def warp_image(
    colour: ArrayLike,
    depth_m: ArrayLike,
    rendered: View,
    shown: View,
    warp: str = "iterative",
    fill: str = "pyramid",
    size: tuple[int, int] | None = None,
    gpu: Gpu | None = None,
    *,
    effects: str = "none",
    repair: str = "none",
    others: Sequence[Other] = (),
    client_depth_m: ArrayLike | None = None,
    layers: Mapping[str, Any] = MappingProxyType({}),
    age_s: float = 0.0,
    depth_scale: float | None = None,
    encoding: str | None = None,
    result: str | None = None,
    depth: bool = False,
) -> WarpedImage:
    """Return the view `shown`, warped from a picture with depth drawn for `rendered`.

    colour: (h, w, 3), uint8 sRGB or float linear light, row 0 at the top; see `encoding`. A fourth
    channel is coverage: 0 is a hole, all else is seen. depth_m: (h, w) metres along -z; inf is
    infinitely far; 0, negative or NaN marks a hole, which is counted and never spread. A pixel that
    a numpy.ma mask hides, in colour or depth, is a hole too. size: (w, h) of the result, by default
    the size of `colour`. gpu: a context made in the calling thread; by default one is made at the
    first call and shared by all threads, one at a time.
    effects: names of effects that pictures are enough for, such as "reflections_from_pictures".
    repair: what mends the depth first, such as "edges+complete"; then a pixel shown by guessed
    depth has the confidence of the guess as its coverage.
    others: further pictures of the scene as (colour, depth_m, view), for warps and effects that
    read them: the other eye's, then older ones, newest first. client_depth_m: (h, w)
    metres in the shown view, for warps that read it. layers: further layers by name, for effects
    and warps that read them: velocity, ids, overlay, peeled, transparent; docs/rgbd.md says what
    each holds. age_s: seconds from drawing the picture to showing it, for what moves.
    depth_scale: metres per unit of depth, which integers must have: 0.001 for millimetres.
    encoding: "linear" or "srgb" (0..1) of float colour; by default it is linear, and values that
    look like 8 bits as floats are refused. result: "srgb8" (uint8), "srgb" or "linear" (float32);
    by default as `colour` is. depth: whether the result has the depth of what is shown.
    For many pictures of one size take a Warper, which compiles and allocates once.
    Errors: InputError for arguments that do not fit; PlanError for a warp that needs more than such
    pictures; UnknownNameError; MachineError without OpenGL 4.3.
    """
    given = checked(colour, depth_m, depth_scale, encoding)
    for name, view in (("rendered", rendered), ("shown", shown)):
        checked_view(name, view)
    rendered_size = given.hidden.shape[1::-1]
    shown_size = rendered_size if size is None else checked_size(size)
    with Warper(
        shown_size,
        rendered_size=rendered_size,
        warp=warp,
        fill=fill,
        effects=effects,
        repair=repair,
        depth=depth,
        gpu=gpu,
    ) as warper:
        return warper.warp(
            colour,
            depth_m,
            rendered,
            shown,
            others=others,
            client_depth_m=client_depth_m,
            layers=layers,
            age_s=age_s,
            depth_scale=depth_scale,
            encoding=encoding,
            result=result,
        )
