"""The frame between two, or after them, made from motion vectors and depth as a runtime does."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..client.effects import effects
from ..geometry import Fov, Pose, View
from ..image import Warper
from ..metrics import psnr
from ..pipeline.feed_coding import velocity_of
from .motion_verdict import BACKWARD, METRES, Convention, MotionFrame, MotionFrames, Pair, grid, nearest_at

_SAME_NS = 1000  # a frame at most so far from the instant is its truth


@attrs.frozen(eq=False)
class Synthesised:
    """A frame that was made, and how far it is from the true one, where that is there."""

    name: str
    time_ns: int
    colour: NDArray[np.uint8]
    # The true frame's name, and PSNR in dB: with the vectors, by head and depth alone, and of the
    # frame as it was.
    truth: str | None = None
    psnr_db: float | None = None
    without_vectors_db: float | None = None
    as_it_was_db: float | None = None

    def row(self) -> dict[str, Any]:
        """Return what synthesis.json has."""
        return {**attrs.asdict(self, filter=lambda field, _: field.name != "colour"), "file": f"{self.name}.png"}


def synthesise(frames: MotionFrames, at: float = 1.0) -> Iterator[Synthesised]:
    """Yield the frame `at` intervals after each that has vectors, read as stated.

    The head's motion between two frames goes on evenly, unless the true frame says where it was.
    What moves by itself goes on with the velocity that its vectors give it.

    Parameters
    ----------
    frames : MotionFrames
        As `read_motion` reads them.
    at : float
        1 is the next frame, 0.5 half way to it, -0.5 half way back.

    Yields
    ------
    Synthesised

    Raises
    ------
    MachineError
        As Warper.
    """
    size = frames.frames[0].size
    carried = ",".join(effect.name for effect in effects if "velocity" in effect.needs)
    with Warper(size, effects=carried) as moving, Warper(size) as still:
        for number, (now, before) in enumerate(frames.pairs):
            time_ns = round(now.time_ns + at * (now.time_ns - before.time_ns))
            truth = next((one for one in frames.frames if abs(one.time_ns - time_ns) <= _SAME_NS), None)
            pair, rendered = Pair(now, before), jittered(now.view, now)
            inverse = np.nan_to_num(nearest_at(now.inverse_depth, grid(size)))
            with np.errstate(divide="ignore"):
                depth_m = 1 / inverse
            velocity = velocity_of(vectors_of(pair, frames.stated), rendered, inverse)[..., :3].astype(np.float32)
            if truth is None:  # the eye goes on as from the frame before to this one
                here, then = now.view.pose, pair.then_view.pose
                turned = Rotation.from_rotvec(at * (then.rotation.inv() * here.rotation).as_rotvec())
                place = here.position_m + at * (here.position_m - then.position_m)
                shown = now.view.at(Pose(place, (here.rotation * turned).as_quat()))
            else:  # where it was, in the space of this frame
                spaces = {True: truth.app_space_delta, False: now.app_space_delta.inverse()}
                eye = truth.view.pose if truth is now else spaces[truth.time_ns > now.time_ns] @ truth.view.pose
                shown = jittered(truth.view.at(eye), truth)
            arguments: dict[str, Any] = {"colour": now.colour, "depth_m": depth_m, "rendered": rendered, "shown": shown}
            made = moving.warp(**arguments, layers={"velocity": velocity}, age_s=(time_ns - now.time_ns) * 1e-9).colour
            found = Synthesised(f"{number:04}", time_ns, made)
            if truth is not None:
                errors = [psnr(one, truth.colour) for one in (made, still.warp(**arguments).colour, now.colour)]
                found = Synthesised(found.name, time_ns, made, truth.name, *errors)
            yield found


def jittered(view: View, frame: MotionFrame) -> View:
    """Return the view that a jittered projection draws."""
    left, right, down, up = view.fov.tangents
    across, high = np.array(frame.jitter) / frame.size * (right - left, up - down)
    return view.within(Fov.from_tangents((left - across, right - across, down + high, up + high)))


def vectors_of(pair: Pair, stated: Convention) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return vectors as XR_EXT_frame_synthesis has them, and their row of the feed's message."""
    vectors, planes, ends = np.zeros((*pair.vectors.shape[:2], 4)), pair.now.planes, (0.0, 0.0)  # no z
    vectors[..., :2] = 2 * (pair.uv - pair.places(stated))
    has_z = pair.vectors.shape[2] > 2 and stated.unit != METRES
    if has_z and planes is not None and planes.max_depth - planes.min_depth == 1:
        vectors[..., 2] = pair.vectors[..., 2] * (-1 if stated.sign == BACKWARD else 1)
        ends = planes.near_z, planes.far_z
    before = jittered(pair.then_view, pair.before)
    pose, fov, seconds = before.pose, before.fov, (pair.now.time_ns - pair.before.time_ns) * 1e-9
    eye = (*pose.position_m, *pose.orientation_xyzw, 0, 0, 0, 0, 0, 0, 1, fov.left, fov.right, fov.down, fov.up)
    return vectors, np.array([[1, 1, 1, 0, 0, 0, *ends, seconds, *eye]], np.float64)
