"""What the depth of pictures suggests about how it was read: notes, one sentence each."""

from __future__ import annotations

from collections.abc import Sequence as Several
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .recorded import NO_DEPTH, Sequence, is_largest

LOOKED_AT = 3  # frames of a sequence: decoding one takes milliseconds
# A region of sky: its share of the picture, and of the picture's edge that it reaches.
_LEAST_AREA, _LEAST_TOP, _LEAST_SIDE = 0.04, 0.15, 0.3
_FINEST = 160  # narrower than one over this of the picture's width, a region is no sky
# What lies within a share below 2^n - 1 is as frequent, unless a sensor of n bits saturates there.
_BELOW, _LEAST_MOST, _LEAST_SHARE = 64, 511, 0.005
# Metres to the nearest surface: beyond, a head that moves by a tenth of it at most is rarely meant.
# Beyond the farthest it is sky, written as a large number.
_FAR_M, _FARTHEST_M, _MOVED = 40.0, 2e4, 0.1
_UNITS = {"centimetres": 0.01, "millimetres": 0.001}


def depth_notes(sequence: Sequence) -> list[str]:
    """Return what some frames of a sequence suggest.

    Values that are no measurement, sky that was written as no depth, depth in another unit.
    """
    last = len(sequence.frames) - 1
    looked = [sequence.frames[at] for at in sorted({round(last * k / (LOOKED_AT - 1)) for k in range(LOOKED_AT)})]
    depths = [frame.depth_m for frame in looked]
    raw = [frame.raw_depth() for frame in looked if frame.raw_depth is not None]
    first = np.array([frame.pose.position_m for frame in sequence.frames])
    moved_m = float(np.linalg.norm(first - first[0], axis=1).max())
    is_far = any(
        assumption.what == NO_DEPTH and assumption.value.startswith("infinitely") for assumption in sequence.assumptions
    )
    sky = [] if is_far else about_sky(depths)
    return [*about_largest(raw), *sky, *about_unit(depths, moved_m, "--depth-scale {:g}")]


def about_largest(depths: Several[NDArray[Any]]) -> list[str]:
    """Return a note on integers that are the largest of their type, or of a sensor's bits.

    depths: as files have them.
    """
    whole = [depth for depth in depths if depth.dtype.kind in "iu" and depth.size]
    if not whole:
        return []
    most, pixels = max(int(depth.max()) for depth in whole), sum(depth.size for depth in whole)
    at = [depth == most for depth in whole]
    count = sum(int(found.sum()) for found in at)
    pictures = "its depth" if len(whole) == 1 else f"the depth of {len(whole)} frames looked at"
    are = f"{count} pixels ({100 * count / pixels:.2g} %) of {pictures} are {most}, the largest value of"
    if any(is_largest(depth).any() for depth in whole):
        kind = str(whole[0].dtype) if most == np.iinfo(whole[0].dtype).max else "16 bits"
        return [f"{are} {kind} (or of a PGM's own bits): they are taken as no depth."]
    below = sum(int((depth > most - most // _BELOW).sum()) for depth in whole) - count
    if most & (most + 1) or most < _LEAST_MOST or count < max(below, _LEAST_SHARE * pixels):
        return []
    return [
        f"{are} {most.bit_length()} bits, and hardly any is a little less: they are taken as depth. If the sensor "
        "saturates there, write 0 for them."
    ]


def about_sky(depths: Several[NDArray[np.floating]]) -> list[str]:
    """Return a note where large regions without depth reach the top or the border, as sky does.

    depths: (h, w) metres each, the top row first; 0, negative or NaN is no depth.
    """
    share = max(map(_sky, depths), default=0.0)
    if not share:
        return []
    return [
        f"A region without depth of {100 * share:.0f} % of the picture reaches its border. If that is sky, written as "
        "no depth, state it by --no-depth far: it is a hole otherwise, which a fill covers with what is near."
    ]


def about_unit(depths: Several[NDArray[np.floating]], moved_m: float, option: str) -> list[str]:
    """Return a note on depth in a smaller unit than metres: far away, while the eye hardly moves.

    depths: metres. moved_m: how far the eye moves. option: how the scale is stated, as a format.
    """
    known = np.concatenate([depth[np.isfinite(depth) & (depth > 0)].ravel()[::7] for depth in depths])
    near = float(np.quantile(known, 0.01, method="lower")) if len(known) else 0.0
    if not _FAR_M < near <= _FARTHEST_M or not 0 < moved_m < _MOVED * near:
        return []
    readings = [f"{option.format(unit)} takes it as {name}: {near * unit:.3g} m" for name, unit in _UNITS.items()]
    return [
        f"The nearest surface is {near:.4g} m away, while the eye moves by {moved_m:.2g} m, so that hardly anything "
        f"shifts against anything else. If depth is in another unit, {'; '.join(readings)}."
    ]


def _sky(depth: NDArray[np.floating]) -> float:
    """Return the share of the largest region without depth that lies as sky does; 0 for none.

    A rim without any depth, as a depth camera leaves, is no border of the picture.
    """
    from scipy.ndimage import binary_opening, label

    known = depth > 0
    if not known.any():
        return 0.0
    rows, columns = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
    left, right = columns[0], columns[-1] + 1
    # What is empty above is a rim only where the sides have one too.
    top = rows[0] if rows[0] <= 2 * min(left, known.shape[1] - right) else 0
    inner = ~known[top:, left:right]
    regions, count = label(binary_opening(inner, iterations=max(1, known.shape[1] // _FINEST)))
    best = 0.0
    for number in range(1, count + 1):
        region = regions == number
        is_above = region[0].mean() >= _LEAST_TOP
        is_beside = max(region[:, 0].mean(), region[:, -1].mean()) >= _LEAST_SIDE
        if is_above or is_beside:
            best = max(best, region.sum() / known.size)
    return best if best >= _LEAST_AREA else 0.0
