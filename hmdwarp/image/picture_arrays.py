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
    """A picture of a caller, of checked types; its numbers checked() checks, or the GPU."""

    # (h, w, 3) the colour in linear light, of a checked picture: its depth is float64 in 1/m, NaN
    # where there is none or no colour.
    light: NDArray[Any] | None = None
    colourless: NDArray[np.bool_] | bool = False  # (h, w) where there is no colour: till checked, where a mask hides it
    notes: tuple[str, ...] = ()  # what a caller should know of its depth, one sentence each

    @property
    def unknown(self) -> NDArray[np.bool_]:
        """(h, w) where an unchecked picture has no depth, whatever its number."""
        hidden: Any = False if self.hidden is None else self.hidden
        clear: Any = self.colour[..., 3] == 0 if self.colour.shape[2] == 4 else False
        return np.asarray(is_largest(self.depth) | hidden | clear)

    def checked(self) -> CallerPicture:
        """Return the picture in linear light and inverse depth, its numbers checked.

        What a mask hides, in colour or in depth, has neither, nor has a pixel whose alpha is 0; the
        largest of an integer type is no depth. Errors: InputError.
        """
        if self.light is not None:
            return self
        hidden: Any = False if self.hidden is None else self.hidden
        colour, colourless, depth = self.colour[..., :3], np.asarray(self.colourless), self.depth
        if self.colour.shape[2] == 4:
            alpha = self.colour[..., 3]
            if len(wrong := np.argwhere(~(np.isfinite(alpha) & (alpha >= 0)))):
                y, x = wrong[0]
                expected = "expected 0 for a hole, or more"
                raise InputError(f"alpha of colour at row {y}, column {x} is {alpha[y, x]}: {expected}")
            colourless = colourless | (alpha == 0)
        colourless = colourless | (hidden & ~np.isfinite(colour).all(axis=2))
        colour = np.where(colourless[..., None], 0, colour).astype(colour.dtype)
        if len(wrong := np.argwhere(~np.isfinite(colour).all(axis=2))):
            raise InputError("colour at row {}, column {} is not a finite number".format(*wrong[0]))
        light, most = colour, float(colour.max())
        if self.encoding == SRGB and most > 1:
            raise InputError(f"colour goes up to {most:g}: expected sRGB as floats of 0 to 1, or as uint8")
        if self.encoding != LINEAR:
            light = linear_from_srgb(colour)
        elif self.is_guessed and most > _BRIGHTEST and (np.median(colour) > 1 or (colour == np.rint(colour)).all()):
            raise InputError(
                f"colour is {colour.dtype} and goes up to {most:g}, where linear light has 1 for white: give 8-bit "
                'values as uint8; divide encoded ones by their white and say encoding="srgb"; or say '
                'encoding="linear" if it is light'
            )
        unknown = self.unknown
        metres = depth if self.scale == 1 else depth.astype(np.float64) * self.scale
        known = metres[np.isfinite(metres) & (metres != 0) & ~unknown]
        if len(known) and (known < 0).all() or (metres < 0).all():
            raise InputError("depth_m is negative everywhere: expected metres along -z, which are above 0: negate it")
        inverse = np.where(unknown, np.nan, inverse_depth_from_metres(metres))
        notes = tuple(about_largest([depth])) if (is_largest(depth) & ~np.asarray(hidden)).any() else ()
        return CallerPicture(
            colour, self.encoding, inverse, is_inverse=True, light=light, colourless=colourless, notes=notes
        )

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
        return np.where(self.unknown, 0, self.depth if self.scale == 1 else self.depth * self.scale)


def raw_picture(
    colour: ArrayLike, depth_m: ArrayLike, depth_scale: float | None = None, encoding: str | None = None
) -> CallerPicture:
    """Return the picture as it is where the GPU can take it over, else checked.

    Arrays may be read-only, masked and of any strides. Errors: InputError.
    """
    arrays = []
    for name, given in (("colour", colour), ("depth_m", depth_m)):
        try:
            arrays.append(np.asarray(given))
        except NO_NUMBERS as error:  # also what a tensor of a GPU says
            raise InputError(f"{name} is no array: {error}") from error
    values, depth = arrays
    if values.ndim != 3 or values.shape[2] not in (3, 4) or not values.size:
        raise InputError(f"colour has shape {values.shape}: expected (h, w, 3), or (h, w, 4) with coverage")
    is_bytes = values.dtype == np.uint8
    if not is_bytes and values.dtype.kind != "f":
        raise InputError(f"colour is {values.dtype}: expected uint8 (sRGB) or a float type (linear light)")
    if depth.shape != values.shape[:2] or depth.dtype.kind not in "fiu":
        wanted = f"numbers of shape {values.shape[:2]}, as colour has"
        raise InputError(f"depth_m is {depth.dtype} {depth.shape}: expected {wanted}")
    if not is_one_of(encoding, ENCODINGS):
        raise InputError(f"encoding is {in_brief(encoding)}: expected {' or '.join(ENCODINGS)}")
    if is_bytes and encoding == LINEAR:
        raise InputError("colour is uint8, which is sRGB, and encoding is linear: give linear light as floats")
    if depth_scale is None and depth.dtype.kind != "f":
        raise InputError(
            f"depth_m is {depth.dtype}, of unknown unit: give depth_scale, the metres per unit (0.001 for "
            "millimetres, 1/5000 for TUM RGB-D, 1 for whole metres), or metres as floats"
        )
    scale = 1.0 if depth_scale is None else depth_scale
    is_number = isinstance(scale, Real) and not isinstance(scale, bool) and 0 < scale < math.inf
    if not (is_number and scale <= 1):
        found, wanted = in_brief(scale), "a number above 0, such as 0.001"
        wanted = f"at most 1; where a metre has {found} units it is 1/{found}" if is_number else wanted
        raise InputError(f"depth_scale is {found}: expected metres per unit, {wanted}")
    masks: list[Any] = [np.ma.getmask(array) for array in (colour, depth_m)]
    masked = [mask.any(axis=2) if mask.ndim == 3 else mask for mask in masks]
    hidden = np.logical_or(*masked) if any(map(np.any, masked)) else None
    kind, is_guessed = SRGB8 if is_bytes else encoding or LINEAR, not is_bytes and encoding is None
    picture = CallerPicture(
        values, kind, depth, float(scale), is_guessed=is_guessed, hidden=hidden, colourless=masked[0]
    )
    return picture if depth.dtype.kind == "f" or depth.dtype == np.uint16 else picture.checked()


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


def is_one_of(name: object, known: Collection[str]) -> bool:
    """Return whether it is None or a known name; an array compares with each of its elements."""
    return name is None or (isinstance(name, str) and name in known)


def check_view(name: str, view: object) -> None:
    """Check that it is a view. Errors: InputError for anything else."""
    if not isinstance(view, View):
        raise InputError(f"{name} is a {type(view).__name__}: expected a hmdwarp.View")
    view.pose.check_near(name)


def checked_size(size: object) -> tuple[int, int]:
    """Return (w, h) as plain integers. Errors: InputError; the GPU's limit is checked later."""
    try:
        width, height = (operator.index(side) for side in size)  # type: ignore[attr-defined]
    except (TypeError, ValueError) as error:
        raise InputError(f"size is {in_brief(size)}: expected (width, height) in whole pixels") from error
    return width, height
