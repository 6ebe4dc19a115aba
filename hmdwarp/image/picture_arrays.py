"""Arrays of a picture with depth: checked, and converted to linear light and inverse depth."""

from __future__ import annotations

import math
import operator
from collections.abc import Collection
from numbers import Real
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import NO_NUMBERS, InputError, in_brief, linear_from_srgb, srgb_from_linear
from ..geometry import View, inverse_depth_from_metres, metres_from_inverse_depth
from ..sources.array_passes import LINEAR, SRGB, SRGB8, Arrays
from ..sources.repairs import RepairChain
from ..sources.sequences import about_largest, is_largest

ENCODINGS = (SRGB, LINEAR)
# Light above it is rare, and a picture is not lit like that in most places, nor in whole numbers:
# 8-bit values are, as floats.
_BRIGHTEST = 64.0
_NOTHING = 0.95  # share of holes that a late frame leaves only by mistake


@attrs.frozen(eq=False)
class CallerPicture(Arrays):
    """A picture of a caller, whose numbers checked_picture has checked, or the GPU does."""

    passed: tuple[Any, ...] = ()  # what checked_picture takes
    # (h, w, 3) the colour in linear light, of a checked picture: its depth is float64 in 1/m, NaN
    # where there is none or no colour.
    light: NDArray[Any] | None = None
    colourless: NDArray[np.bool_] | bool = False  # (h, w) where there is no colour
    notes: tuple[str, ...] = ()  # what a caller should know of its depth, one sentence each

    def checked(self) -> CallerPicture:
        """Return what checked_picture makes of it. Errors: InputError."""
        return checked_picture(*self.passed) if self.light is None else self

    def repaired(self, chain: RepairChain) -> tuple[CallerPicture, NDArray[np.float32]]:
        """Return a checked picture, its depth repaired, and how sure that is: 0 without colour."""
        assert self.light is not None
        is_bytes = self.colour.dtype == np.uint8
        srgb = self.colour * np.float32(1 / 255) if is_bytes else srgb_from_linear(self.light.astype(np.float32))
        found = chain.run(srgb, self.depth.astype(np.float32))
        inverse = np.where(self.colourless, np.nan, found.inverse_depth.astype(np.float64))
        return attrs.evolve(self, depth=inverse), np.where(self.colourless, np.float32(0), found.confidence)

    def metres(self) -> NDArray[Any]:
        """Return depth in metres; what is none is 0, below 0 or NaN."""
        if self.light is not None:
            return metres_from_inverse_depth(self.depth)
        metres = self.depth if self.scale == 1 else self.depth * self.scale
        for unknown in (
            is_largest(self.depth) if self.depth.dtype.kind == "u" else None,
            self.hidden,
            self.colour[..., 3] == 0 if self.colour.shape[2] == 4 else None,
        ):
            metres = metres if unknown is None else np.where(unknown, 0, metres)
        return metres


def raw_picture(
    colour: ArrayLike, depth_m: ArrayLike, depth_scale: float | None = None, encoding: str | None = None
) -> CallerPicture:
    """Return the picture as it is where the GPU can take it over, else checked_picture of it."""
    masks = [np.ma.getmask(array) for array in (colour, depth_m)]
    try:
        values, depth = np.asarray(colour), np.asarray(depth_m)
    except NO_NUMBERS:
        values = depth = np.empty(0)
    fits = values.ndim == 3 and values.shape[2] in (3, 4) and values.size and depth.shape == values.shape[:2]
    is_bytes, is_float = values.dtype == np.uint8, depth.dtype.kind == "f"
    said = is_one_of(encoding, ENCODINGS) and not (is_bytes and encoding == LINEAR)
    said = said and (is_float if depth_scale is None else is_float or depth.dtype == np.uint16)
    scale: Any = 1.0 if depth_scale is None else depth_scale
    is_real = isinstance(scale, Real) and not isinstance(scale, bool)
    if not (fits and said and is_real and 0 < scale <= 1 and (is_bytes or values.dtype.kind == "f")):
        return checked_picture(colour, depth_m, depth_scale, encoding)
    hidden = [np.any(mask, axis=2) if mask.ndim == 3 else mask for mask in masks if mask.any()]
    return CallerPicture(
        values,
        SRGB8 if values.dtype == np.uint8 else encoding or LINEAR,
        depth,
        float(scale),
        is_guessed=values.dtype.kind == "f" and encoding is None,
        hidden=np.logical_or(hidden[0], hidden[-1]) if hidden else None,
        passed=(colour, depth_m, depth_scale, encoding),
    )


def without_hidden(colour: ArrayLike, view: View) -> ArrayLike:
    """Return the colour, masked where the view's lens hides it."""
    if view.hidden is None or np.ndim(colour) != 3:
        return colour
    masked: Any = np.ma.asarray(colour)
    seen = view.seen((masked.shape[1], masked.shape[0]))
    return np.ma.array(masked, mask=np.ma.getmaskarray(masked) | ~seen[..., None])


def about_holes(share: float, rendered: View, shown: View) -> list[str]:
    """Return a note on a result that hardly anything of the picture is seen in. share: of holes."""
    if share <= _NOTHING:
        return []
    between = rendered.pose.inverse() @ shown.pose
    turned_deg = np.degrees(np.arccos(np.clip(between.rotation_matrix[2, 2], -1, 1)))
    moved_m = np.linalg.norm(shown.pose.position_m - rendered.pose.position_m)
    return [
        f"{100 * share:.1f} % of the picture is empty before the fill: the frame has no depth there, or the two views "
        f"see little in common, as they look {turned_deg:.0f} degrees apart from places {moved_m:.2g} m apart; check "
        "depth_m and position_m (metres) and the orientations (x y z w)"
    ]


def checked_picture(
    colour: ArrayLike, depth_m: ArrayLike, depth_scale: float | None = None, encoding: str | None = None
) -> CallerPicture:
    """Return the picture in linear light and inverse depth.

    What a mask hides, in colour or in depth, has neither, nor has a pixel whose alpha is 0; the
    largest of an integer type is no depth. Arrays may be read-only and of any strides. Errors:
    InputError.
    """
    (colour, colour_mask), (depth_m, depth_mask) = _array("colour", colour), _array("depth_m", depth_m)
    if colour.ndim != 3 or colour.shape[2] not in (3, 4) or 0 in colour.shape:
        raise InputError(f"colour has shape {colour.shape}: expected (h, w, 3), or (h, w, 4) with coverage")
    if colour.dtype != np.uint8 and colour.dtype.kind != "f":
        raise InputError(f"colour is {colour.dtype}: expected uint8 (sRGB) or a float type (linear light)")
    if depth_m.shape != colour.shape[:2] or depth_m.dtype.kind not in "fiu":
        raise InputError(
            f"depth_m is {depth_m.dtype} {depth_m.shape}: expected numbers of shape {colour.shape[:2]}, as colour has"
        )
    hidden: NDArray[np.bool_] = np.asarray(colour_mask.any(axis=2))
    if colour.shape[2] == 4:
        colour, alpha = colour[..., :3], colour[..., 3]
        if not np.isfinite(alpha).all() or alpha.min() < 0:
            y, x = np.argwhere(~(np.isfinite(alpha) & (alpha >= 0)))[0]
            raise InputError(f"alpha of colour at row {y}, column {x} is {alpha[y, x]}: expected 0 for a hole, or more")
        hidden |= alpha == 0
    if colour.dtype.kind == "f":
        hidden |= depth_mask & ~np.isfinite(colour).all(axis=2)
    colour = np.where(hidden[..., None], 0, colour).astype(colour.dtype)
    if not np.isfinite(colour).all():
        y, x = np.argwhere(~np.isfinite(colour).all(axis=2))[0]
        raise InputError(f"colour at row {y}, column {x} is not a finite number")
    light = _in_linear_light(colour, encoding)
    metres, scale = depth_m, depth_scale
    if scale is None and depth_m.dtype.kind != "f":
        raise InputError(
            f"depth_m is {depth_m.dtype}, of unknown unit: give depth_scale, the metres per unit (0.001 for "
            "millimetres, 1/5000 for TUM RGB-D, 1 for whole metres), or metres as floats"
        )
    if scale is not None:
        found, wanted = in_brief(scale), "a number above 0, such as 0.001"
        is_number = isinstance(scale, Real) and not isinstance(scale, bool) and 0 < scale < math.inf
        if not is_number or scale > 1:
            wanted = f"at most 1; where a metre has {found} units it is 1/{found}" if is_number else wanted
            raise InputError(f"depth_scale is {found}: expected metres per unit, {wanted}")
        metres = depth_m.astype(np.float64) * float(scale)
    largest = is_largest(depth_m)
    unknown = hidden | depth_mask | largest
    known = metres[np.isfinite(metres) & (metres != 0) & ~unknown]
    if len(known) and (known < 0).all() or (metres < 0).all():
        raise InputError("depth_m is negative everywhere: expected metres along -z, which are above 0: negate it")
    inverse = np.where(unknown, np.nan, inverse_depth_from_metres(metres))
    kind = SRGB8 if colour.dtype == np.uint8 else encoding or LINEAR
    notes = about_largest([depth_m]) if (largest & ~depth_mask).any() else []
    return CallerPicture(colour, kind, inverse, is_inverse=True, light=light, colourless=hidden, notes=tuple(notes))


def is_one_of(name: object, known: Collection[str]) -> bool:
    """Return whether it is None or a known name; an array compares with each of its elements."""
    return name is None or (isinstance(name, str) and name in known)


def check_view(name: str, view: object) -> None:
    """Check that it is a view. Errors: InputError for anything else."""
    if not isinstance(view, View):
        raise InputError(f"{name} is a {type(view).__name__}: expected a hmdwarp.View")
    view.pose.check_near(name)


def _in_linear_light(colour: NDArray[Any], encoding: str | None) -> NDArray[Any]:
    """Return colour as linear light. Errors: InputError where the encoding is wrong or unclear."""
    if not is_one_of(encoding, ENCODINGS):
        raise InputError(f"encoding is {in_brief(encoding)}: expected {' or '.join(ENCODINGS)}")
    if colour.dtype == np.uint8:
        if encoding == LINEAR:
            raise InputError("colour is uint8, which is sRGB, and encoding is linear: give linear light as floats")
        return linear_from_srgb(colour)
    most = float(colour.max())
    if encoding == SRGB:
        if most > 1:
            raise InputError(f"colour goes up to {most:g}: expected sRGB as floats of 0 to 1, or as uint8")
        return linear_from_srgb(colour)
    if encoding is None and most > _BRIGHTEST and (np.median(colour) > 1 or (colour == np.rint(colour)).all()):
        raise InputError(
            f"colour is {colour.dtype} and goes up to {most:g}, where linear light has 1 for white: give 8-bit values "
            'as uint8; divide encoded ones by their white and say encoding="srgb"; or say encoding="linear" if it is '
            "light"
        )
    return colour


def _array(name: str, value: ArrayLike) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Return the values, and where a mask of numpy.ma hides them."""
    try:
        array = np.asanyarray(value)
    except NO_NUMBERS as error:  # also what a tensor of a GPU says
        raise InputError(f"{name} is no array: {error}") from error
    return np.asarray(array), np.ma.getmaskarray(array)


def checked_size(size: object) -> tuple[int, int]:
    """Return (w, h) as plain integers. Errors: InputError; the GPU's limit is checked later."""
    try:
        width, height = (operator.index(side) for side in size)  # type: ignore[attr-defined]
    except (TypeError, ValueError) as error:
        raise InputError(f"size is {in_brief(size)}: expected (width, height) in whole pixels") from error
    return width, height
