"""Which convention makes motion vectors explain the next frame, and whether any does."""

from __future__ import annotations

import math
import operator
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..errors import listed
from ..report import labelled_strip, magma
from .motion_frames import BACKWARD, DOWN, IN, METRES, NDC, PIXELS, PROPERTIES, UV, Array, Convention, MotionFrames
from .motion_places import BLOCKS, CANDIDATES, SCORED, Found, Pair, grid, inside, nearest_at, sampled
from .search import SURE

_NOISE = 0.004  # of the brightness: sampling and 8 bits leave half of it on the library's scenes
# What costs half of what nothing does: of the brightness, of the depth as a share of it.
_SCORE_NOISE, _DEPTH_NOISE = 0.01, 0.03
_SHARED = 9.0  # pixels of a blurred picture that count as one
# How well a block tells a shift, and a shift that contradicts the vectors, beyond 5 deviations.
_KNOWN_PX, _OFF_PX, _SURELY = 0.1, 0.3, 25
_LEAST_BLOCKS = 15  # that must tell a shift
# The most that a right convention leaves. Exact vectors of matt scenes leave half of the first two
# at most, without antialiasing, nothing of the third, and half of the last: moving shadows.
_MOST = {
    "blocks": (0.04, "{:.1%} of the picture moved otherwise"),
    "drift": (0.15, "one picture as a whole by {:.2f} pixels"),
    "elsewhere": (5e-4, "{:.2%} of it came from where the depth before was farther"),
    "missed": (0.015, "{:.1%} of it came from where the colour was another"),
}


@attrs.frozen(eq=False)
class Contradictions:
    """What pictures and depths say against the best candidate."""

    blocks: float  # of the blocks that tell a shift, those but one that show it in frame after frame
    drift: float  # the whole picture's shift in one of the frames, in pixels
    elsewhere: float  # of the pixels: the surface was not there
    missed: float  # of the pixels: something of another colour was there
    judged: int  # blocks that tell a shift, in two frames or more
    factor: list[float]  # the factor by which the vectors fit best, of x and y, and its standard error
    factor_error: list[float]

    def reasons(self) -> list[str]:
        """Return what is more than a right convention leaves."""
        if self.judged < _LEAST_BLOCKS:
            return [f"only {self.judged} blocks of the picture have detail that three frames show"]
        return [text.format(getattr(self, name)) for name, (most, text) in _MOST.items() if getattr(self, name) > most]


@attrs.frozen(eq=False)
class Property:
    """What is found of one property of the convention."""

    name: str
    value: str
    as_stated: bool
    other: Convention  # the best candidate of another value, and by how many standard errors it is worse
    margin: float
    moved_px: float  # median shift between the two

    @property
    def told(self) -> bool:
        """Whether every other value is surely worse."""
        return self.margin >= SURE

    def line(self) -> str:
        """Return it in words."""
        label = f"  {PROPERTIES[self.name][1]:<9}  "
        if not self.told:
            return f"{label}cannot be told from {text_of(self.other)}: that moves pixels by {self.moved_px:.2g}"
        mark = "" if self.as_stated else "  <- not as stated"
        return f"{label}{self.value}  ({self.margin:.0f} standard errors ahead){mark}"


@attrs.frozen(eq=False)
class Verdict:
    """What frames say about their motion vectors."""

    frames: MotionFrames
    best: Convention
    rivals: tuple[Convention, ...]  # those that fit as well with as few changes
    properties: tuple[Property, ...]
    contradictions: Contradictions
    # Slope of the change of depth over the vectors' z, and its standard error; None without z.
    z: tuple[float, float] | None

    @property
    def explained(self) -> bool:
        """Whether the best candidate leaves no more than a right one does."""
        return not self.contradictions.reasons()

    @property
    def verdict(self) -> str:
        """Return "right", "wrong" or "cannot be told"."""
        if not self.explained or self.rivals:
            return "cannot be told"
        return "right" if self.best == self.frames.stated else "wrong"

    def headline(self) -> str:
        """Return the verdict in one sentence."""
        count, best = f"{len(self.frames.pairs)} pairs of frames", text_of(self.best)
        if not self.explained:
            why = listed(self.contradictions.reasons())
            return f"cannot be told: no convention explains the next frame. With the nearest ({best}), {why} ({count})"
        if self.rivals:
            return f"cannot be told: {' or '.join([best, *map(text_of, self.rivals)])} explain it as well ({count})"
        wrong = listed([PROPERTIES[one.name][1] for one in self.properties if not one.as_stated])
        return f"{f'wrong: {wrong}' if wrong else 'right'}. The vectors explain the next frame as {best} ({count})"

    def lines(self) -> list[str]:
        """Return what to print below it."""
        if not self.explained:
            return []
        (x, y), (dx, dy) = self.contradictions.factor, self.contradictions.factor_error
        lines = [one.line() for one in self.properties]
        lines += [f"  factor     {x:.3f} +- {1.96 * dx:.3f} across, {y:.3f} +- {1.96 * dy:.3f} down (95 %)"]
        if self.z is not None:
            slope, error = self.z
            follows = "as the depth changes" if abs(slope - 1) < max(0.25, SURE * error) else "not as the depth changes"
            lines.append(f"  z          {follows}: slope {slope:.2f} +- {1.96 * error:.2f}")
        code = self.code()
        return [*lines, *(["Read them so:"] if code else []), *(f"    {line}" for line in code)]

    def code(self) -> list[str]:
        """Return C and GLSL that make of them what XR_EXT_frame_synthesis expects."""
        return code_of(self) if self.verdict == "wrong" else []

    def as_json(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        told = [one.name for one in self.properties if one.told] if self.explained else []
        about = {"verdict": self.verdict, "told": told, "reasons": self.contradictions.reasons(), "code": self.code()}
        return about | attrs.asdict(self, filter=lambda field, _: field.name != "frames")


def text_of(convention: Convention) -> str:
    """Return a convention in words."""
    return f"{convention.unit}, y {convention.y}, {convention.sign}, jitter {convention.jitter}"


def code_of(verdict: Verdict) -> list[str]:
    """Return the lines that turn vectors as found into those of the extension."""
    found, now = verdict.best, verdict.frames.pairs[0][0]
    back = -1.0 if found.sign == BACKWARD else 1.0
    down = 1.0 if found.y == DOWN else -1.0
    lines = []
    if found.unit == METRES:
        lines += [
            f"motion.xyz *= vec3({back:g}, {-down * back:g}, {back:g});  // now the way in the eye, y up",
            "vec4 then = previousProjection * vec4(eyePosition - motion.xyz, 1.0);  // without jitter",
            "motion.xyz = ndcPosition - then.xyz / then.w;",
        ]
    else:
        units = {NDC: (1.0, 1.0), UV: (2.0, 2.0), PIXELS: (2 / now.size[0], 2 / now.size[1])}[found.unit]
        factors = (back * units[0], back * down * units[1], -back if verdict.z and verdict.z[0] < 0 else back)
        for name, stated in (("Scale", now.scale), ("Offset", now.offset)):
            numbers = ", ".join(f"{value * factor:.9g}" for value, factor in zip(stated, factors, strict=True))
            if name == "Scale" or any(stated):
                lines.append(f"info.motionVector{name} = {{{numbers}, 0}};  // XrFrameSynthesisInfoEXT")
        lines.append("// XR_FB_space_warp: motion.xyz *= vec3({:.9g}, {:.9g}, {:.9g});".format(*factors))
    if found.jitter == IN and found.unit != METRES:
        lines.append(
            "motion.xy -= (jitter - previousJitter) * vec2(2.0 / {}, 2.0 / {});  // pixels, y down".format(*now.size)
        )
    return lines


def check_motion(frames: MotionFrames) -> Verdict:
    """Return which candidate explains each next frame, by colour and by depth."""
    full = [Pair(now, before) for now, before in frames.pairs]
    pairs = [attrs.evolve(one, step=max(1, round(math.sqrt(one.vectors[..., 0].size / SCORED)))) for one in full]
    costs = {one: np.concatenate([_by_block(pair, _cost(Found.of(pair, one))) for pair in pairs]) for one in CANDIDATES}
    least = min(costs, key=lambda one: float(costs[one].sum()))
    alike = [one for one in CANDIDATES if _margin(costs[least], costs[one]) < SURE]
    stated = attrs.astuple(frames.stated)
    order = {one: (sum(map(operator.ne, attrs.astuple(one), stated)), float(costs[one].sum())) for one in alike}
    best = min(alike, key=order.__getitem__)
    rivals = tuple(one for one in alike if one != best and order[one][0] == order[best][0])
    found = [Found.of(pair, best) for pair in full]
    return Verdict(
        frames,
        best,
        rivals,
        tuple(_property(frames, name, best, costs, full[0]) for name in PROPERTIES),
        _contradictions(found),
        _slope_of_z(found, best),
    )


def _by_block(pair: Pair, values: Array) -> Array:
    """Return the sum of each block of the picture."""
    return np.asarray(np.bincount(pair.block.ravel(), np.nan_to_num(values).ravel(), BLOCKS), np.float64)


def _cost(found: Found) -> Array:
    """Return 0 to 1: nothing for what is there as it should be, 1 for what is not there."""
    squared = (found.bright / _SCORE_NOISE) ** 2 + (np.clip(found.deep, -1, 1) / _DEPTH_NOISE) ** 2
    return np.where(found.seen, np.nan_to_num(squared / (1 + squared), nan=1.0), 1.0)


def _margin(better: Array, worse: Array) -> float:
    """Return by how many standard errors one is better, over blocks."""
    apart = worse - better
    error = float(apart.std()) / math.sqrt(len(apart))
    return float(apart.mean()) / error if error > 0 else 0.0


def _property(
    frames: MotionFrames, name: str, best: Convention, costs: dict[Convention, Array], pair: Pair
) -> Property:
    value = getattr(best, name)
    margins = {one: _margin(costs[best], costs[one]) for one in costs if getattr(one, name) != value}
    other = min(margins, key=margins.__getitem__)
    apart = np.linalg.norm((pair.places(other) - pair.places(best)) * pair.now.size, axis=-1)
    as_stated = value == getattr(frames.stated, name)
    return Property(name, value, as_stated, other, margins[other], float(np.nanmedian(apart)))


def _contradictions(found: list[Found]) -> Contradictions:
    shift, matrix, known, off, way = (np.stack(each) for each in zip(*map(_shifts, found), strict=True))
    # Edges without antialiasing seem to move by chance: each time elsewhere.
    length = np.maximum(np.linalg.norm(shift, axis=-1, keepdims=True), 1e-9)
    along = np.linalg.norm((off[..., None] * shift / length).sum(axis=0), axis=-1)
    counts = known.sum(axis=0)
    judged, wrong = int((counts > 1).sum()), int((along >= np.maximum(1.5, counts / 2)).sum())
    whole = np.linalg.solve(matrix.sum(axis=1) + 1e-5 * np.eye(2), np.einsum("nbij,nbj->ni", matrix, shift)[..., None])
    elsewhere, missed = (
        float(np.mean([ndimage.binary_opening(getattr(one, name), np.ones((2, 2))).mean() for one in found]))
        for name in ("elsewhere", "missed")
    )
    factor, error = _factor(way[known], shift[known], matrix[known][:, (0, 1), (0, 1)])
    drift = float(np.linalg.norm(whole, axis=1).max())
    return Contradictions(max(0, wrong - 1) / max(judged, 1), drift, elsewhere, missed, judged, factor, error)


def _factor(way: Array, shift: Array, weight: Array) -> tuple[list[float], list[float]]:
    """Return the factors of x and y that fit best and their standard errors, over blocks."""
    total = np.maximum((weight * way**2).sum(axis=0), 1e-12)
    slope = (weight * way * shift).sum(axis=0) / total
    scatter = ((weight * way * (shift - slope * way)) ** 2).sum(axis=0)
    return (1 + slope).tolist(), (np.sqrt(scatter) / total).tolist()


def _shifts(found: Found) -> tuple[NDArray[Any], ...]:
    """Return for each block by how many pixels the picture before lies elsewhere, and how sure.

    Source: Lucas and Kanade 1981, one step: what is left is below a pixel where vectors are right.
    """
    pair, gradient, bright = found.pair, found.gradient, np.nan_to_num(found.bright)
    steep = np.linalg.norm(gradient, axis=-1)
    weight = (found.seen & pair.one_surface) / (1 + (bright / (4 * _NOISE + steep)) ** 2)
    x, y = gradient[..., 0], gradient[..., 1]
    xx, xy, yy, xb, yb = (_by_block(pair, weight * one) for one in (x * x, x * y, y * y, x * bright, y * bright))
    matrix = np.stack([xx, xy, xy, yy], axis=-1).reshape(-1, 2, 2)
    shift = np.linalg.solve(matrix + 1e-5 * np.eye(2), np.stack([xb, yb], axis=-1)[..., None])[..., 0]
    variance = _SHARED * _NOISE**2
    sure = np.einsum("ni,nij,nj->n", shift, matrix, shift) / variance
    off = np.asarray((sure > _SURELY) & (np.linalg.norm(shift, axis=1) > _OFF_PX))
    known = off | (np.linalg.eigvalsh(matrix)[:, 1] > variance / _KNOWN_PX**2)
    way = np.where(weight[..., None] > 0, (found.uv - pair.uv) * pair.now.size, 0)
    count = np.maximum(_by_block(pair, weight > 0), 1)
    return shift, matrix, known, off, np.stack([_by_block(pair, way[..., k]) / count for k in (0, 1)], axis=-1)


def _slope_of_z(found: list[Found], best: Convention) -> tuple[float, float] | None:
    """Return the change of depth over the vectors' z, and its standard error, over blocks."""
    if best.unit == METRES or any(one.pair.vectors.shape[2] < 3 or one.pair.now.planes is None for one in found):
        return None
    over, under = [], []
    for one in found:
        pair, planes, then = one.pair, one.pair.now.planes, one.pair.before.planes
        assert planes is not None and then is not None, "checked above"
        z = pair.vectors[..., 2] * (-1 if best.sign == BACKWARD else 1)
        change = planes.encode(pair.inverse) - then.encode(sampled(pair.before.inverse_depth, one.uv))
        good = one.seen & pair.one_surface & np.isfinite(change) & np.isfinite(z)
        over.append(_by_block(pair, np.where(good, z * change, 0)))
        under.append(_by_block(pair, np.where(good, z * z, 0)))
    top, low = np.concatenate(over), np.concatenate(under)
    if not low.sum() > 0:
        return None
    slope = float(top.sum() / low.sum())
    return slope, float(np.sqrt(((top - slope * low) ** 2).sum()) / low.sum())


def motion_mismatch(verdict: Verdict) -> NDArray[np.uint8]:
    """Return a strip: a frame, the one before, and that one moved as stated and as found."""
    now, before = verdict.frames.pairs[-1]
    pair, where = Pair(now, before), grid(now.size)
    panels = [("one frame", now.colour), ("the one before", before.colour)]
    for words, convention in {"as stated": verdict.frames.stated, "nearest": verdict.best}.items():
        found = Found.of(pair, convention)
        uv = where + nearest_at(found.uv - pair.uv, where)
        moved = np.where(inside(uv)[..., None], nearest_at(before.colour, uv), 0).astype(np.uint8)
        wrong = nearest_at((found.missed | found.elsewhere).astype(float), where)
        panels += [(f"that, moved here: {words}", moved), ("contradicted", magma(wrong))]
    return labelled_strip(panels, columns=2)
