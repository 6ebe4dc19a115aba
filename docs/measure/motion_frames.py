"""Write frames of a scene with exact motion vectors in any convention, to compare an engine with.

Each pixel's ray meets the triangles themselves: a triangle's three corners in the eye, inverted,
give the weights of the place that a ray meets, and the same weights the place it had in the frame
before. No matrix of a projection, no rasteriser and no code of what is tested.
"""

from __future__ import annotations

import argparse
import json
from itertools import product
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial.transform import Rotation

from hmdwarp.base import srgb8_from_linear
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Gpu
from hmdwarp.scenes import Scene, load_scene
from hmdwarp.sources.server import Server

Array = NDArray[np.float64]
SIZE, LOW = (320, 240), (160, 120)  # of colour; of vectors and depth
NEAR, FAR = 0.1, 1000.0
SKY_M = FAR  # where a sky lies, as a depth buffer has it
CONVENTIONS = tuple(
    product(("ndc", "uv", "pixels", "metres"), ("down", "up"), ("current - previous", "previous - current"),
            ("out", "in"))
)  # fmt: skip
HALTON = np.array([(0, -1 / 3), (-0.5, 1 / 3), (0.5, -7 / 9), (-0.75, -1 / 9)]) / 2  # pixels


@attrs.frozen(eq=False)
class TrueFrame:
    """One frame. jitter: pixels by which its picture lies right and down."""

    view: View
    time_ns: int
    jitter: Array
    colour: NDArray[np.uint8]
    inverse_depth: Array  # (h, w) of LOW, top row first
    now: Array  # (h, w, 3) places in the eye, of the sky those at FAR
    then: Array  # the same places in the eye of the frame before, where they were then
    moves: NDArray[np.bool_]  # which move by themselves


def jittered(view: View, jitter: Array) -> View:
    """Return the view that draws everything so many pixels further right and down."""
    left, right, down, up = view.fov.tangents
    across, high = jitter * ((right - left) / SIZE[0], (up - down) / SIZE[1])
    return View(view.pose, Fov.from_tangents((left - across, right - across, down + high, up + high)))


def corners_at(scene: Scene, time_ns: int) -> tuple[Array, NDArray[np.bool_]]:
    """(m, 3, 3) triangles in the world then, and whether each moves."""
    found, moves = [], []
    for mesh in scene.meshes:
        points = mesh.positions.astype(np.float64)
        if mesh.deformation is not None:
            points = mesh.deformation.positions(time_ns)
        if mesh.body:
            points = scene.bodies[mesh.body - 1].motion.state(time_ns).pose.transform(points)
        found.append((points + scene.origin_m)[mesh.triangles])
        moves.append(np.full(len(mesh.triangles), bool(mesh.body) or mesh.deformation is not None))
    return np.concatenate(found), np.concatenate(moves)


def rays_of(view: View, size: tuple[int, int]) -> Array:
    left, right, down, up = view.fov.tangents
    x = left + (np.arange(size[0]) + 0.5) * (right - left) / size[0]
    y = up - (np.arange(size[1]) + 0.5) * (up - down) / size[1]
    return np.stack([*np.meshgrid(x, y), np.full(size[::-1], -1.0)], axis=-1)


_AT_ONCE = 100_000  # pixels


def met(corners: Array, view: View, size: tuple[int, int]) -> tuple[Array, NDArray[np.int64], Array]:
    """(h, w) inverse depth, triangle (-1: none) and (h, w, 3) weights of its corners.

    A ray r meets the corners' plane where r = M b, M being the corners as columns: b is the
    weights times the inverse depth.
    """
    seen = (corners - view.pose.position_m) @ view.pose.rotation.as_matrix()
    rays, (wide, high) = rays_of(view, size).reshape(-1, 3), size
    left, right, down, up = view.fov.tangents
    inverse, which, weights = np.zeros(high * wide), np.full(high * wide, -1), np.zeros((high * wide, 3))
    ahead = seen[..., 2].max(axis=1) < -0.02
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (seen[..., 0] / -seen[..., 2] - left) / (right - left) * wide
        y = (up - seen[..., 1] / -seen[..., 2]) / (up - down) * high
    x, y = (np.where(ahead[:, None], places, (0, 0, count)) for places, count in ((x, wide), (y, high)))
    low = np.clip(np.floor(np.stack([x.min(1), y.min(1)], 1) - 0.5), 0, size).astype(int)
    end = np.clip(np.ceil(np.stack([x.max(1), y.max(1)], 1) + 0.5), 0, size).astype(int)
    behind = seen[..., 2].min(axis=1) >= 0
    solid = np.abs(np.linalg.det(seen)) > 1e-12 * np.linalg.norm(seen, axis=2).prod(axis=1)
    drawn = np.flatnonzero((low < end).all(axis=1) & ~behind & solid)
    boxes, turns = end - low, np.zeros_like(seen)
    turns[drawn] = np.linalg.inv(seen[drawn])
    until = boxes[drawn].prod(axis=1).cumsum()
    # The pixels of the boxes around many triangles at once.
    for some in np.split(drawn, np.flatnonzero(np.diff(until // _AT_ONCE)) + 1):
        counts = boxes[some].prod(axis=1)
        index, place = np.repeat(some, counts), np.arange(counts.sum()) - np.repeat(counts.cumsum() - counts, counts)
        down, across = np.divmod(place, boxes[index, 0])
        pixel = (low[index, 1] + down) * wide + low[index, 0] + across
        part = np.einsum("ni,nij->jn", rays[pixel], turns[index])
        found = part.sum(axis=0)
        nearer = np.flatnonzero((part >= 0).all(axis=0) & (found > inverse[pixel]))
        nearer = nearer[np.lexsort((-index[nearer], found[nearer]))]  # where several are, the last one stays
        inverse[pixel[nearer]], which[pixel[nearer]] = found[nearer], index[nearer]
        weights[pixel[nearer]] = (part[:, nearer] / found[nearer]).T
    return inverse.reshape(high, wide), which.reshape(high, wide), weights.reshape(high, wide, 3)


def true_frames(server: Server, views: list[View], times_ns: list[int], jitter: Array = HALTON) -> list[TrueFrame]:
    """Return the frames; `then` of the first is that of itself."""
    found: list[TrueFrame] = []
    for number, (view, time_ns) in enumerate(zip(views, times_ns, strict=True)):
        seen_by, before = jittered(view, jitter[number]), max(number - 1, 0)
        eye = server.draw(seen_by, SIZE, time_ns=time_ns)
        picture = np.frombuffer(eye.colour.read(alignment=1), np.float16).reshape(*SIZE[::-1], 4)[::-1, :, :3]
        colour = srgb8_from_linear(picture.astype(np.float64))
        server.pool(SIZE).release(eye.colour)
        (corners, moves), (past, _) = (corners_at(server.scene, when) for when in (time_ns, times_ns[before]))
        inverse, which, weights = met(corners, seen_by, LOW)
        there = which >= 0
        world = np.einsum("hwc,hwcx->hwx", weights, corners[which])
        sky = view.pose.position_m + SKY_M * rays_of(seen_by, LOW) @ view.pose.rotation.as_matrix().T
        world = np.where(there[..., None], world, sky)
        old = np.where(there[..., None], np.einsum("hwc,hwcx->hwx", weights, past[which]), sky)
        now, then = (view.pose.inverse().transform(world), views[before].pose.inverse().transform(old))
        found.append(TrueFrame(view, time_ns, jitter[number], colour, inverse, now, then, there & moves[which]))
    return found


def ndc(view: View, points: Array) -> Array:
    """X and y from -1 to 1, y down; z of a depth buffer, 0 at NEAR and 1 at FAR."""
    left, right, down, up = view.fov.tangents
    inverse = -1 / points[..., 2]
    x = 2 * (points[..., 0] * inverse - left) / (right - left) - 1
    y = 1 - 2 * (points[..., 1] * inverse - down) / (up - down)
    return np.stack([x, y, (inverse - 1 / NEAR) / (1 / FAR - 1 / NEAR)], axis=-1)


def shifted(view: View, points: Array, jitter: Array) -> Array:
    """Return the points that a picture shows where a jittered one shows these."""
    left, right, down, up = view.fov.tangents
    across, high = jitter * ((right - left) / SIZE[0], (down - up) / SIZE[1])
    return points - points[..., 2:] * (across, high, 0)


def vectors_of(frame: TrueFrame, before: TrueFrame, convention: tuple[str, str, str, str]) -> Array:
    """(h, w, 3) motion vectors of a frame in a convention."""
    unit, y, sign, jitter = convention
    now, then = frame.now, frame.then
    if jitter == "in":
        now, then = shifted(frame.view, now, frame.jitter), shifted(before.view, then, before.jitter)
    if unit == "metres":
        moved = (now - then) * (1, -1, 1)
    else:
        factor = {"ndc": (1, 1, 1), "uv": (0.5, 0.5, 1), "pixels": (SIZE[0] / 2, SIZE[1] / 2, 1)}[unit]
        moved = (ndc(frame.view, now) - ndc(before.view, then)) * factor
    return moved * (1, -1 if y == "up" else 1, 1) * (-1 if sign == "previous - current" else 1)


def depth_of(frame: TrueFrame) -> Array:
    """Return what a depth buffer has: 0 at NEAR, 1 at FAR and beyond."""
    return np.clip((1 / NEAR - frame.inverse_depth) / (1 / NEAR - 1 / FAR), 0, 1)


def arrays_of(frames: list[TrueFrame], convention: tuple[str, str, str, str]) -> list[NDArray[np.float16]]:
    """Return the vectors of each frame as half floats; those of the first lead to itself."""
    return [vectors_of(now, frames[max(k - 1, 0)], convention).astype(np.float16) for k, now in enumerate(frames)]


def write_folder(folder: Path, frames: list[TrueFrame], read: tuple[str, str, str, str], **stated) -> Path:
    """Write a folder as an engine may: PNG, NPY, and one motion.json."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for number, (frame, vectors) in enumerate(zip(frames, arrays_of(frames, read), strict=True)):
        Image.fromarray(frame.colour).save(folder / f"{number}.png")
        np.save(folder / f"{number}.depth.npy", depth_of(frame).astype(np.float32))
        np.save(folder / f"{number}.motion.npy", vectors)
        pose, fov = frame.view.pose, frame.view.fov
        rows.append(
            {"colour": f"{number}.png", "depth": f"{number}.depth.npy", "displayTime": frame.time_ns,
             "pose": {"position": pose.position_m.tolist(), "orientation": pose.orientation_xyzw.tolist()},
             "fov": {"angleLeft": fov.left, "angleRight": fov.right, "angleUp": fov.up, "angleDown": fov.down},
             "jitter": frame.jitter.tolist(), **({"motion": f"{number}.motion.npy"} if number else {})}
        )  # fmt: skip
    (folder / "motion.json").write_text(json.dumps({"nearZ": NEAR, "farZ": FAR, **stated, "frames": rows}))
    return folder


def walking_head(at: tuple[float, float, float], count: int = 4, step_s: float = 0.05) -> list[View]:
    """Return a head that turns, nods, rolls and walks."""
    found = []
    for seconds in np.arange(count) * step_s:
        turn = Rotation.from_euler("yxz", (0.6 * seconds, -0.12 + 0.4 * seconds, 0.12 * seconds))
        place = np.array(at) + seconds * np.array((0.5, 0.25, -0.6))
        found.append(View(Pose(place, turn.as_quat()), Fov(-0.75, 0.7, -0.6, 0.62)))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("out", type=Path, help="folder for motion.json and the files of four frames")
    parser.add_argument("--scene", default="parade", help="a scene of the library, or a file")
    parser.add_argument("--at", default="0.2,1.5,0.2", help="where the head begins to walk: x,y,z in metres")
    parser.add_argument("--start", type=float, default=0.25, help="seconds on the scene's clock")
    names = zip(("unit", "y", "sign", "jitter"), zip(*CONVENTIONS, strict=True), strict=True)
    for name, values in names:
        parser.add_argument(f"--{name}", choices=sorted({*values}), default=values[0])
    asked = parser.parse_args()
    convention = (asked.unit, asked.y, asked.sign, asked.jitter)
    x, y, z = map(float, asked.at.split(","))
    with Gpu() as gpu:
        times = [round((asked.start + step) * 1e9) for step in (0, 0.05, 0.1, 0.15)]
        frames = true_frames(Server(gpu, load_scene(asked.scene)), walking_head((x, y, z)), times)
    print(write_folder(asked.out, frames, convention))


if __name__ == "__main__":
    main()
