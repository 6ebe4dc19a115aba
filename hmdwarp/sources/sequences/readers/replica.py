"""Replica as NICE-SLAM renders it: frames and depth in results, a matrix a line in traj.txt."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ....errors import InputError
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ..camera import Camera, number_of, read_json
from ..options import SequenceOptions
from ..recorded import NO_DEPTH, POSE, Sequence
from . import readers
from ._base import Pair, SequenceReader, at_rate, facts_of, intrinsics_fact, poses_of, rows_of, scale_fact
from ._dataset import axes_of, by_number, clock_of, left_out

POSES, FACTS = "traj.txt", "cam_params.json"
RENDERER = Camera(600.0, 600.0, 599.5, 339.5, size=(1200, 680))
_SCALE = 1 / 6553.5
_WORLD = "x,z,y"  # z up


@readers.register
class ReplicaReader(SequenceReader):
    """Scenes of Replica in NICE-SLAM's form; matrices from camera to world, row by row.

    Source: Zhu et al. 2022, NICE-SLAM: neural implicit scalable encoding for SLAM (its data sets:
    cam_params.json beside the scenes, depth * 6553.5).
    """

    name = "replica"
    summary = f"Replica of NICE-SLAM: results/frameN.jpg, results/depthN.png, {POSES}, and {FACTS} there or above"
    assumes = (
        intrinsics_fact(RENDERER, By.FORMAT),
        scale_fact(_SCALE, By.FORMAT),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(f"world={_WORLD} head=x,-y,z")),
        Assumption(POSE, "world from camera, matrices by rows", By.FORMAT),
        clock_of(SequenceOptions()),
    )

    def fits(self, path: Path) -> int:
        return 90 if (path / POSES).exists() and any((path / "results").glob("frame*.*")) else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        camera, scale = _stated(path)
        facts = facts_of(path, options, RENDERER, _SCALE, own=camera, own_scale=scale)
        axes, rows = facts.axes(_WORLD), rows_of(path / POSES)
        colours, depths = by_number(path / "results", "frame*.*"), by_number(path / "results", "depth*.png")
        whole = sorted(colours.keys() & depths.keys())
        if whole and whole[-1] >= len(rows):
            raise InputError(
                f"{path / POSES}: {len(rows)} poses, and a picture {colours[whole[-1]].name}; expected a line for each"
            )
        poses, way = poses_of(axes, [(rows[at].where, rows[at].floats(16)) for at in whole])
        pairs = [
            Pair(colours[at], depths[at], at_rate(options, at), pose) for at, pose in zip(whole, poses, strict=True)
        ]
        more = (axes_of(axes), way, clock_of(options))
        notes = left_out(len(colours) - len(pairs), "no depth")
        return self.sequence_of(path, pairs, facts, notes=notes, more=more)


def _stated(path: Path) -> tuple[Camera | None, float | None]:
    """Return the camera and the depth scale of cam_params.json, if there is one."""
    file = next((place / FACTS for place in (path, path.resolve().parent) if (place / FACTS).exists()), None)
    if file is None:
        return None, None
    data: Any = read_json(file).get("camera")
    if not isinstance(data, dict):
        raise InputError(f"{file}: no object 'camera'; expected w, h, fx, fy, cx, cy and scale in it")
    wide, high, fx, fy, scale = (
        number_of(file, key, data.get(key), "a number above 0", above=0) for key in ("w", "h", "fx", "fy", "scale")
    )
    cx, cy = (number_of(file, key, data.get(key)) for key in ("cx", "cy"))
    return Camera(fx, fy, cx, cy, size=(round(wide), round(high))), 1 / scale
