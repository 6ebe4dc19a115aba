"""Frames that somebody has misread: right ones, and one convention taken for another."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np
from depth_camera import CameraFrame, DepthCamera
from scipy.spatial.transform import Rotation

from hmdwarp.check import LEFT, RIGHT, StatedFrame
from hmdwarp.geometry import DepthLayer, Fov, Pose, View, inverse_depth_from_metres
from hmdwarp.gpu import Gpu
from hmdwarp.scenes import scenes
from hmdwarp.sources.server import Server

FRAMES, INTERVAL_NS = 12, 10**8
EYES_APART_M = 0.064
NEAREST_FAR_M = 6.0  # the shortest range of the cameras
# Rows are OpenXR's right, up and back of the eye, in the axes of others.
OPENCV = np.diag([1.0, -1.0, -1.0])  # x right, y down, z forward
UNITY = np.diag([1.0, 1.0, -1.0])  # x right, y up, z forward
ROS = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])  # x forward, y left, z up
Frames = list[StatedFrame]


def hand_held(rng: np.random.Generator) -> Callable[[int], Pose]:
    """Return the pose over time of a camera that somebody moves about by hand, to see a room."""
    hertz, phase = rng.uniform(0.25, 0.8, 6), rng.uniform(0, 2 * np.pi, 6)
    size = np.r_[rng.uniform(0.15, 0.35, 3), np.radians(rng.uniform(8, 20, 3))]
    heading = rng.uniform(0, 2 * np.pi)

    def at(time_ns: int) -> Pose:
        x, y, z, pitch, yaw, roll = size * np.sin(2 * np.pi * hertz * time_ns / 1e9 + phase)
        turn = Rotation.from_euler("YXZ", [heading + yaw, pitch, roll])
        return Pose((x, 1.5 + y, z), turn.as_quat())

    return at


@attrs.frozen(eq=False)
class Recording:
    """What both eyes of a camera saw."""

    head_at: Callable[[int], Pose]
    eyes: tuple[Sequence[CameraFrame], Sequence[CameraFrame]]

    def eye_at(self, eye: int, time_ns: int) -> Pose:
        return self.head_at(time_ns) @ Pose(((eye - 0.5) * EYES_APART_M, 0, 0))

    @classmethod
    def of(cls, server: Server, head_at: Callable[[int], Pose], camera: DepthCamera) -> Recording:
        """Return FRAMES frames of each eye."""
        made = cls(head_at, ([], []))
        times = range(0, FRAMES * INTERVAL_NS, INTERVAL_NS)
        rng = np.random.default_rng(0)
        for eye in (LEFT, RIGHT):
            made.eyes[eye].extend(camera.record(server, lambda t, eye=eye: made.eye_at(eye, t), times, rng))
        return made

    @property
    def shows_things(self) -> bool:
        """Whether every frame has something else than sky."""
        return all((picture.truth_m < NEAREST_FAR_M).mean() > 0.2 for eye in self.eyes for picture in eye)


def recordings(gpu: Gpu, names: Sequence[str], count: int, rng: np.random.Generator) -> list[Recording]:
    """Return `count` recordings in each of the scenes, of a camera moved by hand."""
    found: list[Recording] = []
    for place, name in enumerate(names, 1):
        server = Server(gpu, scenes.get(name).build())
        while len(found) < place * count:
            one = Recording.of(server, hand_held(rng), DepthCamera())
            found += [one] if one.shows_things else []
        server.close()
    return found


def right_frames(recording: Recording, camera: DepthCamera, rng: np.random.Generator, stereo: bool = False) -> Frames:
    """Return frames of one eye, or both, with the camera's faults, in a world of any axes."""
    world = Pose(rng.normal(scale=3, size=3), Rotation.random(random_state=rng).as_quat())
    eyes = (LEFT, RIGHT) if stereo else (LEFT,)
    frames = []
    for k in range(FRAMES):
        for eye in eyes:
            one = recording.eyes[eye][k]
            depth = camera.measured(inverse_depth_from_metres(one.truth_m), rng)
            view = View(world @ one.view.pose, one.view.fov)
            frames.append(StatedFrame(f"frame {k}", one.colour, depth, view, one.time_ns, eye if stereo else None))
    return frames


def _posed(frames: Frames, change: Callable[[Pose], Pose]) -> Frames:
    return [attrs.evolve(frame, view=View(change(frame.view.pose), frame.view.fov)) for frame in frames]


def _deep(frames: Frames, change: Callable[[StatedFrame], np.ndarray]) -> Frames:
    return [attrs.evolve(frame, depth=change(frame)) for frame in frames]


def w_first(frames: Frames, rng: np.random.Generator) -> Frames:
    return _posed(frames, lambda pose: Pose(pose.position_m, np.roll(pose.orientation_xyzw, 1)))


def world_to_eye(frames: Frames, rng: np.random.Generator) -> Frames:
    return _posed(frames, Pose.inverse)


def in_axes(eye: np.ndarray) -> Callable[[Frames, np.random.Generator], Frames]:
    """Return a misreading of poses in other axes; left-handed ones have another world too."""
    world = np.diag([1.0, 1.0, np.linalg.det(eye)])

    def change(pose: Pose) -> Pose:
        return Pose(world @ pose.position_m, Rotation.from_matrix(world @ pose.rotation_matrix @ eye).as_quat())

    return lambda frames, rng: _posed(frames, change)


def rows_up(frames: Frames, rng: np.random.Generator) -> Frames:
    return [attrs.evolve(frame, colour=frame.colour[::-1], depth=frame.depth[::-1]) for frame in frames]


def along_the_ray(frames: Frames, rng: np.random.Generator) -> Frames:
    def change(one: StatedFrame) -> np.ndarray:
        rays = one.view.rays(one.depth.shape[::-1])[::-1]
        return one.depth * np.linalg.norm(rays, axis=-1)

    return _deep(frames, change)


def as_buffer(layer: DepthLayer) -> Callable[[StatedFrame], np.ndarray]:
    return lambda one: layer.encode(inverse_depth_from_metres(one.depth)).astype(np.float32)


def buffer(frames: Frames, rng: np.random.Generator) -> Frames:
    near, far = rng.uniform(0.05, 0.3), rng.choice([20.0, 50.0, 1000.0, np.inf])
    return _deep(frames, as_buffer(DepthLayer(rng.choice([0.0, -1.0]), 1, near, far)))


def reversed_buffer(frames: Frames, rng: np.random.Generator) -> Frames:
    return _deep(frames, as_buffer(DepthLayer(0, 1, np.inf, rng.uniform(0.05, 0.3))))


def read_as_not_reversed(frames: Frames, rng: np.random.Generator) -> Frames:
    near = rng.uniform(0.05, 0.3)

    def change(one: StatedFrame) -> np.ndarray:
        numbers = DepthLayer(0, 1, np.inf, near).encode(inverse_depth_from_metres(one.depth))
        return 1 / DepthLayer(0, 1, near, 100.0).inverse_depth(numbers)

    return _deep(frames, change)


def wrong_far_plane(frames: Frames, rng: np.random.Generator) -> Frames:
    wrong = 1 / rng.uniform(9, 20)
    return _deep(frames, lambda one: 1 / (inverse_depth_from_metres(one.depth) + wrong))


def scaled(frames: Frames, rng: np.random.Generator) -> Frames:
    factor = rng.choice([1000.0, 5000.0, 100.0, 0.001, 3.0])
    return _deep(frames, lambda one: one.depth * factor)


def filmed(frames: Frames, wide: tuple[float, float] = (1, 1), off: tuple[float, float] = (0, 0)) -> Frames:
    """Return frames with tangents times as wide, and the principal point off by pixels."""

    def change(one: StatedFrame) -> View:
        height, width = one.depth.shape
        fx, fy, cx, cy = one.view.fov.intrinsics((width, height))
        fov = Fov.from_intrinsics(fx / wide[0], fy / wide[1], cx + off[0], cy + off[1], width, height)
        return View(one.view.pose, fov)

    return [attrs.evolve(frame, view=change(frame)) for frame in frames]


def half_a_pixel(frames: Frames, rng: np.random.Generator) -> Frames:
    return filmed(frames, off=(rng.choice([-0.5, 0.5]),) * 2)


def _a_width(rng: np.random.Generator) -> float:
    return float(np.exp(rng.choice([-1, 1]) * rng.uniform(0.03, 0.4)))


def wrong_field_of_view(frames: Frames, rng: np.random.Generator) -> Frames:
    return filmed(frames, (_a_width(rng),) * 2)


def wrong_aspect(frames: Frames, rng: np.random.Generator) -> Frames:
    wide = _a_width(rng)
    return filmed(frames, (wide, 1) if rng.random() < 0.5 else (1, wide))


def wrong_principal_point(frames: Frames, rng: np.random.Generator) -> Frames:
    """Two to fourteen pixels of 96, in any direction."""
    far, way = rng.uniform(2, 14), rng.uniform(0, 2 * np.pi)
    return filmed(frames, off=(far * np.cos(way), far * np.sin(way)))


def eyes_swapped(frames: Frames, rng: np.random.Generator) -> Frames:
    return [attrs.evolve(one, view=frames[k ^ 1].view) for k, one in enumerate(frames)]


# Each with the convention that is to be named.
MISREADINGS = {
    "right": (lambda frames, rng: frames, None), "w first": (w_first, "order"),
    "world to eye": (world_to_eye, "direction"), "OpenCV": (in_axes(OPENCV), "axes"), "Unity": (in_axes(UNITY), "axes"),
    "ROS": (in_axes(ROS), "axes"), "rows up": (rows_up, "rows"), "along the ray": (along_the_ray, "ray"),
    "buffer": (buffer, "encoding"), "reversed": (reversed_buffer, "encoding"),
    "not reversed": (read_as_not_reversed, "encoding"), "far plane": (wrong_far_plane, "planes"),
    "scale": (scaled, "scale"), "half a pixel": (half_a_pixel, "pixel"), "eyes swapped": (eyes_swapped, "eyes"),
    "late": (None, "time"), "field of view": (wrong_field_of_view, "focal"),
    "one focal length": (wrong_aspect, "focal"), "principal point": (wrong_principal_point, "centre"),
}  # fmt: skip
# Two of one group are another one of it, or hide each other.
ALONE = (
    {"right"}, {"OpenCV", "Unity", "ROS"}, {"buffer", "reversed", "not reversed", "far plane", "scale"},
    {"half a pixel", "principal point"}, {"field of view", "one focal length"},
)  # fmt: skip
_FIRST, _LAST = ("late", "along the ray"), ("rows up",)  # they need the right ones, or turn everything over


def two_misreadings(rng: np.random.Generator) -> tuple[str, str]:
    """Return two conventions that can be misread together, in the order to apply them."""
    while True:
        one, two = (str(name) for name in rng.choice(list(MISREADINGS), 2, replace=False))
        if "right" not in (one, two) and not any({one, two} <= group for group in ALONE):
            return (two, one) if one in _LAST or two in _FIRST and one != "late" else (one, two)


def wrong_frames(recording: Recording, name: str, rng: np.random.Generator) -> Frames:
    """Return frames with the faults of a camera, of which one convention is misread."""
    return right_and_wrong(recording, (name,), rng)[1]


def right_and_wrong(recording: Recording, names: Sequence[str], rng: np.random.Generator) -> tuple[Frames, Frames]:
    """Return frames with the faults of a camera, and the same with some conventions misread."""
    camera = DepthCamera(
        noise=rng.uniform(0, 0.003), far_m=rng.uniform(NEAREST_FAR_M, 12), near_m=0.2, edge_gaps=rng.uniform(0, 1)
    )
    right = right_frames(recording, camera, rng, stereo="eyes swapped" in names or rng.random() < 0.2)
    wrong = right
    for name in names:
        misread = MISREADINGS[name][0]
        wrong = misread(wrong, rng) if misread else _late(recording, wrong, rng)
    return right, wrong


def _late(recording: Recording, frames: Frames, rng: np.random.Generator) -> Frames:
    late_ns = round(rng.choice([-1, 1]) * rng.uniform(0.25, 0.75) * INTERVAL_NS)

    def pose(one: StatedFrame) -> Pose:
        assert one.time_ns is not None
        before, now = (recording.eye_at(one.eye or LEFT, time) for time in (one.time_ns - late_ns, one.time_ns))
        return one.view.pose @ now.inverse() @ before

    return [attrs.evolve(frame, view=View(pose(frame), frame.view.fov)) for frame in frames]
