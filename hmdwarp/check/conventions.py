"""What the frames say about each convention, in words, with the code that reads them right."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import attrs
import numpy as np

from ..errors import listed
from . import decide as names
from .decide import Decision, agreement, decide, differences, likeness
from .fit import ALONG, FACTOR, LATE, OFFSET, PIXEL_X, PIXEL_Y
from .frame_reading import AXES, BUFFER, METRES, Reading, eye_axes
from .search import SURE, Search, standard_errors
from .stated_frames import Array, Stated

_AGREE = 0.5  # share of the depths: below it, frames do not agree
_STILL_PX = 0.5  # median shift between two readings: below it they show the same
# Standard errors beyond which a number cannot be told: of the factor's logarithm; of the offset,
# in the median; of the way along the ray; in pixels; in frames.
_VAGUE = {names.SCALE: 0.1, names.PLANES: 0.1, names.RAY: 0.2, names.PIXEL: 0.15, names.TIME: 0.15}
_NUMBERS = {
    names.SCALE: (FACTOR,),
    names.PLANES: (FACTOR, OFFSET),
    names.RAY: (ALONG,),
    names.PIXEL: (PIXEL_X, PIXEL_Y),
    names.TIME: (LATE,),
}
LABELS = {
    names.ORDER: "quaternion order",
    names.DIRECTION: "pose",
    names.AXES: "axes",
    names.ROWS: "rows",
    names.EYES: "eyes",
    names.RAY: "depth along",
    names.ENCODING: "depth encoding",
    names.PLANES: "near and far",
    names.SCALE: "depth scale",
    names.PIXEL: "pixel centres",
    names.TIME: "time of the pose",
}
_NEEDS = {
    names.ORDER: "frames that are turned and moved against each other",
    names.DIRECTION: "frames that are turned and moved against each other",
    names.AXES: "frames that are turned and moved against each other",
    names.ROWS: "frames that look up or down, roll or rise against each other",
    names.EYES: "pairs of eyes at several places of the head: give two folders, the left eye's first",
    names.RAY: "frames from places farther apart, or a wider view",
    names.ENCODING: "frames from places farther apart",
    names.PLANES: "frames from places farther apart, with things near and far",
    names.SCALE: "frames from places farther apart",
    names.PIXEL: "frames that roll or approach",
    names.TIME: "five or more frames with times, close together, while the head changes its speed",
}
_SAME_UNIT = 0.06  # difference of the logarithms within which a scale is that of a unit
# Metres per unit that are common: of depth, and of positions.
_SCALES = {
    1e-3: "millimetres",
    1 / 5000: "1/5000 m, as TUM RGB-D",
    1e-2: "centimetres",
    1e-1: "decimetres",
    1 / 256: "1/256 m, as KITTI",
    0.3048: "feet",
    0.0254: "inches",
    1e3: "metres, where positions are in millimetres",
    1e2: "metres, where positions are in centimetres",
}


@attrs.frozen
class Finding:
    """What the frames say about one convention."""

    name: str
    label: str
    # What was found, or what is stated where it cannot be told.
    value: str
    as_stated: bool
    told: bool
    # Standard errors by which the nearest other reading is worse; None for numbers.
    margin: float | None = None
    # Why it cannot be told; "" where it can.
    why: str = ""


@attrs.frozen(eq=False)
class Answer:
    """What the frames say, and what they would say if read that way."""

    decision: Decision
    findings: tuple[Finding, ...]
    # Share of the depths in view of two frames that agree within 5 %.
    agreement_stated: float
    agreement: float
    # Correlation of their brightness where depths agree.
    likeness: float
    # Other readings under which the frames agree as well.
    as_good: tuple[str, ...]
    code: tuple[str, ...]

    @property
    def reading(self) -> Reading:
        """The reading under which the frames agree best."""
        return self.decision.best.reading

    @property
    def agree(self) -> bool:
        """Whether the frames agree under it."""
        return self.agreement >= _AGREE and self.likeness >= names.ALIKE

    @property
    def verdict(self) -> str:
        """Return "right", "wrong" (and the findings say what), or "no agreement"."""
        if not self.agree:
            return "no agreement"
        return "wrong" if differences(self.reading) else "right"

    def headline(self) -> str:
        """Return the verdict in one sentence."""
        frames = f"{len(self.decision.search.stated.frames)} frames"
        share = f"{100 * self.agreement:.0f} %"
        if self.verdict == "right":
            return f"right: {frames} agree as they are stated, in {share} of the depths that two of them show"
        if self.verdict == "wrong":
            changed = listed([one.label for one in self.findings if not one.as_stated])
            return (
                f"wrong: {changed}. Of the depths that two frames show, {100 * self.agreement_stated:.0f} % agree as "
                f"stated, {share} as found ({frames})"
            )
        if self.agreement >= names.WELL:
            return (
                f"no agreement: {frames} agree in {share} of the depths that two of them show, but not in colour; "
                "expected pictures of the same things, with detail that can be compared"
            )
        return (
            f"no agreement: {frames} agree in {share} of the depths that two of them show, however they are read; "
            "expected a scene that stands still, seen from places nearby, and the field of view of the camera"
        )

    def as_json(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        return {
            "verdict": self.verdict,
            "frames": len(self.decision.search.stated.frames),
            "agreement_stated": self.agreement_stated,
            "agreement": self.agreement,
            "likeness": self.likeness,
            "conventions": [attrs.asdict(one) for one in self.findings] if self.agree else [],
            "as_good": list(self.as_good),
            "code": list(self.code) if self.agree else [],
        }


def check(stated: Stated) -> Answer:
    """Return under which conventions the frames agree."""
    search = Search(stated)
    decision = decide(search)
    best = decision.best.reading
    findings = tuple(_finding(decision, name) for name in LABELS)
    rivals = [one for one in decision.others if one.changes and abs(_margin(decision, one.reading)) < SURE]
    rivals = [one for one in rivals if differences(one.reading) != differences(best)]
    as_good = dict.fromkeys(
        listed([f"{LABELS[name]}: {value(one.reading, stated, name)}" for name in differences(one.reading)])
        for one in (rivals if differences(best) else ())
    )
    return Answer(
        decision,
        findings,
        agreement(search, Reading()),
        agreement(search, best),
        likeness(search, best),
        tuple(as_good),
        tuple(code(best, stated)),
    )


def _finding(decision: Decision, name: str) -> Finding:
    search, best = decision.search, decision.best.reading
    changed = name in differences(best)
    finding = Finding(name, LABELS[name], value(best, search.stated, name), not changed, True)
    if name == names.EYES and search.stated.other_eye is None:
        return _unknown(finding, "these are not of both eyes")
    if name in _NUMBERS and not (changed and name != names.RAY):
        if name in (names.SCALE, names.PLANES) and {names.ENCODING} & set(differences(best)):
            return finding  # part of the encoding
        why = _vague(search, best, name)
        return _unknown(finding, why) if why else finding
    others = list(_others(search, best, name))
    if not others:
        return finding
    margins = [_margin(decision, one) for one in others]
    least = int(np.argmin(margins))
    if margins[least] >= SURE:
        return attrs.evolve(finding, margin=margins[least])
    shift = _shift(search, best, others[least])
    other = value(others[least], search.stated, name)
    why = (
        f"{other} would move pixels by only {shift:.2g}"
        if shift < _STILL_PX and name != names.ROWS
        else f"{other} fits as well, with other numbers"
        if margins[least] > -SURE
        else f"{other} fits better, and another change better still"
    )
    return _unknown(attrs.evolve(finding, margin=margins[least]), why)


def _unknown(finding: Finding, why: str) -> Finding:
    return attrs.evolve(finding, told=False, why=f"{why}; it takes {_NEEDS[finding.name]}")


def _others(search: Search, best: Reading, name: str) -> Iterator[Reading]:
    """Yield the readings in which one convention is another one."""
    if name in (names.ENCODING, names.PLANES, names.SCALE, names.TIME, names.PIXEL):
        if name in differences(best):
            plain = {
                names.TIME: {"late_s": 0.0},
                names.PIXEL: {"pixel_x": 0.0, "pixel_y": 0.0},
                names.PLANES: {"offset": 0.0},
            }.get(name, {"kind": METRES, "factor": 1.0, "end": 0.0, "offset": 0.0})
            yield attrs.evolve(best, **plain)
        return
    if name == names.RAY:
        yield attrs.evolve(best, along=0.0 if best.along else 1.0)
        return
    for one in search.discrete(best):
        if set(differences(one)) ^ set(differences(best)) <= {name} and one.along == best.along:
            before, after = (value(which, search.stated, name) for which in (best, one))
            if before != after:
                yield one


def _margin(decision: Decision, other: Reading) -> float:
    """Return by how many standard errors of the coarse score another reading is worse."""
    coarse = decision.search.coarse
    better, worse = (coarse.by_block(np.nan_to_num(coarse.score(one)))[0] for one in (decision.best.reading, other))
    return standard_errors(better - worse)


def _shift(search: Search, one: Reading, other: Reading) -> float:
    """Return the median shift between two readings, in pixels."""
    a, b = (search.fine.residuals(which) for which in (one, other))
    both = a.seen & b.seen
    return float(np.median(np.linalg.norm(a.pixel[both] - b.pixel[both], axis=-1))) if both.any() else math.inf


def _vague(search: Search, best: Reading, name: str) -> str:
    """Return why a number cannot be told, "" where it can."""
    numbers = _NUMBERS[name]
    steps = search.steps(best)
    if not set(numbers) <= set(steps):
        return "there are too few frames, or they are too far apart to know the motion between them"
    fitted = search.fitted(best, numbers)
    unit = {OFFSET: 1e3 * steps[OFFSET], LATE: search.stated.interval_s or 1.0}
    errors = {key: float(error) / unit.get(key, 1.0) for key, error in zip(fitted.names, fitted.error, strict=True)}
    most = max(errors.values())
    if most <= _VAGUE[name]:
        return ""
    moved = search.moved_m(best)
    if name in (names.SCALE, names.PLANES, names.RAY) and moved * search.span(best) < 0.01:
        return f"the eye moves by only {100 * moved * search.span(best):.2g} % of the distance"
    words = {names.PIXEL: f"known to {most:.2g} pixels only", names.TIME: f"known to {most:.2g} frames only"}
    return words.get(
        name, f"known to {100 * most:.0f} % only" if math.isfinite(most) else "nothing in them depends on it"
    )


# In words.


def value(reading: Reading, stated: Stated, name: str) -> str:
    """Return what a reading takes one convention for."""
    rows = {
        (False, False): "top row first",
        (True, True): "bottom row first",
        (True, False): "colour bottom row first",
        (False, True): "depth bottom row first",
    }
    if name in differences(reading) and name in (names.ENCODING, names.PLANES, names.SCALE, names.PIXEL, names.TIME):
        return _number(reading, stated, name)
    return {
        names.ORDER: " ".join(reading.order),
        names.DIRECTION: "eye from world" if reading.inverse else "world from eye",
        names.AXES: _axes(reading.axes),
        names.ROWS: rows[reading.colour_rows_up, reading.depth_rows_up],
        names.EYES: "left and right swapped" if reading.eyes_swapped else "as named",
        names.RAY: "the ray" if reading.along else "-z",
        names.ENCODING: "distance",
        names.PLANES: "as stated",
        names.SCALE: "as stated",
        names.PIXEL: "as stated",
        names.TIME: "that of the picture",
    }[name]


def _number(reading: Reading, stated: Stated, name: str) -> str:
    if name == names.ENCODING:
        return _encoding(reading, stated)
    if name == names.PLANES:
        return f"inverse depth off by {reading.offset:+.3g} /m: another near or far plane"
    if name == names.SCALE:
        return _scale(reading.factor)
    if name == names.PIXEL:
        return f"{reading.pixel_x:+.2f}, {reading.pixel_y:+.2f} pixels to the right and down"
    return _late(reading, stated)


def _axes(name: str) -> str:
    hand = "left" if np.linalg.det(eye_axes(name)) < 0 else "right"
    return f"{name}, {hand}-handed"


def _late(reading: Reading, stated: Stated) -> str:
    when = "before" if reading.late_s > 0 else "after"
    frames = abs(reading.late_s) / (stated.interval_s or math.inf)
    return f"{abs(reading.late_s) * 1e3:.1f} ms ({frames:.2f} frames) {when} the picture"


def _scale(factor: float) -> str:
    metres, words = _scale_of(factor)
    return f"{metres} of what is stated{f': {words}' if words else ''}"


def _scale_of(factor: float) -> tuple[str, str]:
    """Return the metres per unit, and which unit has as many; "" for none that is common."""
    near = [(one, words) for one, words in _SCALES.items() if abs(math.log(one * factor)) < _SAME_UNIT]
    metres, words = near[0] if near else (1 / factor, "")
    return f"{metres:.4g}", words


def _planes(reading: Reading, stated: Stated) -> tuple[float, float, float, bool]:
    """Return the low end of a depth buffer, near, far, and whether it is reversed."""
    low = -1.0 if stated.signed else 0.0
    is_reversed = reading.factor > 0
    ends = [reading.offset + reading.factor * (end - reading.end) for end in (low, 1.0)]
    near, far = max(ends), min(ends)
    return low, 1 / near, 1 / far if far > 0.005 else math.inf, is_reversed


def _encoding(reading: Reading, stated: Stated) -> str:
    if reading.kind == METRES:
        return "reversed depth, converted as if it were not"
    low, near, far, is_reversed = _planes(reading, stated)
    planes = f"near {near:.3g} m, far {'infinite' if math.isinf(far) else f'{far:.3g} m'}"
    return f"{'reversed ' if is_reversed else ''}depth buffer of {low:g} to 1, {planes}"


# In code.


def code(reading: Reading, stated: Stated) -> Iterator[str]:
    """Yield the lines that read such frames right, in the order in which they are to stand."""
    wrong = differences(reading)
    if names.ORDER in wrong:
        yield "pose = Pose(pose.position_m, np.roll(pose.orientation_xyzw, -1))  # w came first"
    if names.DIRECTION in wrong:
        yield "pose = pose.inverse()  # it took points of the world to the eye"
    if names.AXES in wrong:
        yield from _turned(reading.axes)
    if names.EYES in wrong:
        yield "left, right = right, left  # the pictures, or the poses"
    if names.TIME in wrong:
        yield f"pose = track.at(time_ns + {round(reading.late_s * 1e9)}).pose"
    if names.ROWS in wrong:
        both = [word for word, up in (("colour", reading.colour_rows_up), ("depth_m", reading.depth_rows_up)) if up]
        yield f"{', '.join(both)} = {', '.join(f'{one}[::-1]' for one in both)}  # the bottom row came first"
    if names.ENCODING in wrong and reading.kind == BUFFER:
        low, near, far, is_reversed = _planes(reading, stated)
        text = ", ".join("np.inf" if math.isinf(one) else f"{one:.4g}" for one in (near, far))
        ndc = ', ndc="minus_one_to_one"' if low < 0 else ""
        yield f"depth_m = 1 / inverse_depth_from_clip(depth_m, {text}{ndc}{', reversed_z=True' if is_reversed else ''})"
    elif names.ENCODING in wrong or names.PLANES in wrong:
        constant = reading.offset - reading.factor * reading.end
        yield f"depth_m = 1 / ({constant:.5g} + {reading.factor:.5g} / depth_m)  # better: the planes of the renderer"
    if names.SCALE in wrong:
        yield f"depth_m = depth_m * {_scale_of(reading.factor)[0]}  # or --depth-scale, times as much"
    if names.RAY in wrong:
        yield "rays = View(pose, fov).rays((width, height))[::-1]"
        yield "depth_m = depth_m / np.linalg.norm(rays, axis=-1)  # it was along them"
    if names.PIXEL in wrong:
        was, now = (0, 0.5) if reading.pixel_x > 0 else (0.5, 0)
        yield f"fx, fy, cx, cy = fov.intrinsics((width, height), centre={was})  # half a pixel"
        yield f"fov = Fov.from_intrinsics(fx, fy, cx, cy, width, height, centre={now})"


def _turned(axes: str) -> Iterator[str]:
    eye = eye_axes(axes)
    if np.linalg.det(eye) > 0:
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_matrix(eye.T).as_quat(canonical=True)
        yield f"pose = pose @ Pose(orientation_xyzw={_numbers(turn)})  # the eye's axes were those of {axes}"
        return
    yield f"eye = np.array({[[int(one) for one in row] for row in eye]})  # right, up and back in the axes of {axes}"
    yield "world = np.diag([1, 1, -1])  # the other hand"
    yield "turn = Rotation.from_matrix(world @ pose.rotation_matrix @ eye.T)  # of SciPy"
    yield "pose = Pose(world @ pose.position_m, turn.as_quat())"


def _numbers(values: Array | Sequence[float]) -> str:
    return f"({', '.join(f'{round(float(one), 6) + 0.0:g}' for one in values)})"


__all__ = ["AXES", "LABELS", "Answer", "Finding", "check", "code", "value"]
