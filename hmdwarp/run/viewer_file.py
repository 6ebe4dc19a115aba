"""A replay as an MCAP file, for viewers such as Foxglove: poses, views, pictures and figures.

Axes are those of ROS (x forward, y left, z up), which viewers expect; the frames of views are
those of cameras (x right, y down, z forward). Times are the replay's own.

Source: MCAP specification; Foxglove schemas in JSON; ROS REP 103 and REP 105.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..frames import EyeImage
from ..frames.layers import PICTURE
from ..geometry import Pose, View, metres_from_inverse_depth
from ..gpu.textures import download
from ..metrics import QualityJob
from ..pipeline.loop import Refresh
from ..poses.formats.mcap import AXES, POSES, PoseMessages, numbers, of_object, stamp
from ..poses.reading.axes import parse_axes
from ..report import atomic, png_bytes, refuse_existing
from .run_summary import EYES

SUFFIX = ".mcap"
_CAMERA_FROM_EYE = np.diag([1.0, -1, -1])
_TEXT, _COUNT = {"type": "string"}, {"type": "integer"}
_BYTES = {"type": "string", "contentEncoding": "base64"}
_LIST = {"type": "array", "items": {"type": "number"}}
_AT = {"timestamp": POSES["timestamp"], "frame_id": _TEXT}
_TRANSFORM = of_object(
    timestamp=POSES["timestamp"], parent_frame_id=_TEXT, child_frame_id=_TEXT,
    translation=numbers("xyz"), rotation=numbers("xyzw"),
)  # fmt: skip
_SCHEMAS: dict[str, dict[str, Any]] = {
    "foxglove.PoseInFrame": POSES,
    "foxglove.FrameTransforms": {"transforms": {"type": "array", "items": _TRANSFORM}},
    "foxglove.CameraCalibration": {
        **_AT, "width": _COUNT, "height": _COUNT, "distortion_model": _TEXT, **dict.fromkeys("DKRP", _LIST)
    },
    "foxglove.CompressedImage": {**_AT, "data": _BYTES, "format": _TEXT},
    "foxglove.RawImage": {
        **_AT, "width": _COUNT, "height": _COUNT, "encoding": _TEXT, "step": _COUNT, "data": _BYTES
    },
    "hmdwarp.Figures": {},
}  # fmt: skip


@contextmanager
def viewer_file(path: Path | None, *, force: bool = False) -> Iterator[ViewerFile | None]:
    """Yield what writes the file, which is there when the block has ended without error.

    Errors: InputError for another kind of file, or one that exists; MachineError without the
    package.
    """
    if path is None:
        yield None
        return
    if path.suffix != SUFFIX:
        raise InputError(f"--record-to {path}: expected a file that ends in {SUFFIX}")
    refuse_existing(path, force=force)
    with atomic(path) as partial, partial.open("wb") as stream:
        written = ViewerFile(stream)
        yield written
        written.close()


class ViewerFile:
    """Write what a replay shows while it runs.

    Topics: /head and /tf at every refresh, /EYE/figures with the row of frames.csv. Pictures at
    measured refreshes: /EYE/shown/image, /EYE/truth/image, /EYE/holes/image (white: empty after the
    warp); /EYE/late/image and /EYE/late/depth in metres, NaN where none is known, at their first.
    Each view has a /camera beside its pictures.
    """

    def __init__(self, stream: Any) -> None:
        self._poses, self._ros_from_openxr = PoseMessages(stream), parse_axes(AXES).world.T
        self._channels: dict[str, int] = {}
        self._late: dict[int, int] = {}
        self._offset_ns: int | None = None

    def add(self, refresh: Refresh) -> None:
        """Add the head, and the views of both eyes."""
        if self._offset_ns is None:  # a log begins at 0 or later
            self._offset_ns = max(0, -min(refresh.shown_ns, refresh.frame.drawn_ns))
        at_ns = self._at(refresh.shown_ns)
        head = self._placed(refresh.head.pose, self._ros_from_openxr.T)
        self._poses.add(at_ns, *head)
        views = [(f"{eye}/shown", inputs.middle) for eye, inputs in zip(EYES, refresh.inputs, strict=False)]
        views += [(f"{eye}/late", image.view) for eye, image in zip(EYES, refresh.frame.eyes, strict=False)]
        moved = [("head", *head), *((name, *self._placed(view.pose, _CAMERA_FROM_EYE)) for name, view in views)]
        transforms = [
            {
                "timestamp": stamp(at_ns), "parent_frame_id": "world", "child_frame_id": name,
                "translation": place, "rotation": turned,
            }
            for name, place, turned in moved
        ]  # fmt: skip
        self._put("/tf", "foxglove.FrameTransforms", at_ns, {"transforms": transforms})

    def add_pictures(self, eye: int, refresh: Refresh, job: QualityJob) -> None:
        """Add what one eye saw, should have seen, and had to see it from."""
        at_ns, name = self._at(refresh.shown_ns), EYES[eye]
        shown = f"{name}/shown"
        self._camera(shown, at_ns, job.now.view, job.now.shown.shape[1::-1])
        self._image(f"/{shown}/image", shown, at_ns, job.now.shown)
        self._image(f"/{name}/truth/image", shown, at_ns, job.now.truth)
        if job.covered is not None:
            self._image(f"/{name}/holes/image", shown, at_ns, np.where(job.covered, 0, 255).astype(np.uint8))
        if self._late.get(eye) != refresh.transit.number:
            self._late[eye] = refresh.transit.number
            self._late_picture(f"{name}/late", at_ns, refresh.frame.eyes[eye], job.rendered_picture)

    def _late_picture(self, name: str, at_ns: int, image: EyeImage, picture: NDArray[np.uint8] | None) -> None:
        if picture is None:
            return
        self._camera(name, at_ns, image.view, image.size)
        self._image(f"/{name}/image", name, at_ns, picture)
        if PICTURE[1] in image.left_out:
            return
        inverse = download(image.inverse_depth)
        depth = metres_from_inverse_depth(np.where(inverse < 0, np.nan, inverse)).astype("<f4")
        high, wide = depth.shape
        raw = {
            "width": wide, "height": high, "encoding": "32FC1", "step": 4 * wide,
            "data": base64.b64encode(depth.tobytes()).decode(),
        }  # fmt: skip
        self._put(f"/{name}/depth", "foxglove.RawImage", at_ns, {**_at(at_ns, name), **raw})

    def add_figures(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add the rows of frames.csv, each at its refresh; JSON has no infinite numbers."""
        for row in rows:
            known = {key: value for key, value in row.items() if not isinstance(value, float) or np.isfinite(value)}
            self._put(f"/{EYES[row['eye']]}/figures", "hmdwarp.Figures", self._at(row["shown_ns"]), known)

    def close(self) -> None:
        """End the file."""
        self._poses.close()

    def _at(self, time_ns: int) -> int:
        assert self._offset_ns is not None, "the first refresh comes first"
        return time_ns + self._offset_ns

    def _placed(self, pose: Pose, own_axes: NDArray[np.float64]) -> tuple[dict[str, float], dict[str, float]]:
        """Return position and quaternion in the axes of ROS of a frame with its own axes."""
        from scipy.spatial.transform import Rotation  # 0.3 s, which a run without such a file need not wait for

        turn = Rotation.from_matrix(self._ros_from_openxr @ pose.rotation_matrix @ own_axes).as_quat()
        place = self._ros_from_openxr @ pose.position_m
        return dict(zip("xyz", place.tolist(), strict=True)), dict(zip("xyzw", turn.tolist(), strict=True))

    def _camera(self, name: str, at_ns: int, view: View, size: tuple[int, int]) -> None:
        self._put(f"/{name}/camera", "foxglove.CameraCalibration", at_ns, {**_at(at_ns, name), **_pinhole(view, size)})

    def _image(self, topic: str, frame: str, at_ns: int, picture: NDArray[np.uint8]) -> None:
        data = base64.b64encode(png_bytes(picture)).decode()
        self._put(topic, "foxglove.CompressedImage", at_ns, {**_at(at_ns, frame), "data": data, "format": "png"})

    def _put(self, topic: str, schema: str, at_ns: int, content: Mapping[str, Any]) -> None:
        if topic not in self._channels:
            self._channels[topic] = self._poses.channel(topic, schema, _SCHEMAS[schema])
        self._poses.put(self._channels[topic], at_ns, json.dumps(content, default=float))


def _at(at_ns: int, frame: str) -> dict[str, Any]:
    return {"timestamp": stamp(at_ns), "frame_id": frame}


def _pinhole(view: View, size: tuple[int, int]) -> dict[str, Any]:
    """Return a view as a camera whose pixel centres are whole numbers, as OpenCV has them."""
    (left, right, down, up), (wide, high) = view.fov.tangents, size
    across, along = wide / (right - left), high / (up - down)
    k = [across, 0.0, -left * across - 0.5, 0.0, along, up * along - 0.5, 0.0, 0.0, 1.0]
    p = [*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0]
    return {
        "width": wide, "height": high, "distortion_model": "", "D": [], "K": k,
        "R": np.eye(3).ravel().tolist(), "P": p,
    }  # fmt: skip
