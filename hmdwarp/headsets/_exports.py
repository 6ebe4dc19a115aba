"""Headsets in other programs' JSON: what SteamVR keeps, and what hmdq exports."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..geometry import Eyes, Fov, Polygon, Pose
from ..options.documents import DocumentError, parse_json
from ..options.named_files import FACTS, text_in
from ..options.tables import Table
from ._lenses import COLOURS, Array, ViveLens
from ._model import Headset, HeadsetEye

REPORTED = "the views as the runtime reported them; no lens, because the runtime corrects it"
REFRESH_HZ = 90.0  # of a Vive; a file does not tell, --rate takes another
_NAMES = {"red": "distortion_red", "green": "distortion", "blue": "distortion_blue"}
_KINDS = ("DISTORT_DPOLY3",)


def load_export(path: Path) -> Headset:
    """Load the JSON that SteamVR keeps of a Vive, Vive Pro or Index, or that hmdq exports.

    Serial numbers are not read. Of hmdq's the views, the size and the hidden area are.
    Errors: InputError naming the file and its fault.
    Source: Valve's description of the HMD's JSON file; hmdq (R. Musil), as it reads OpenVR.
    """
    try:
        data = Table(parse_json(text_in(path, FACTS)))
        return _vive(data, path) if "tracking_to_eye_transform" in data else _hmdq(data, path)
    except DocumentError as error:
        raise InputError(f"{path}: this is no JSON: {error}") from error
    except InputError as error:  # keys and the model's own name no file
        raise error if str(error).startswith(str(path)) else InputError(f"{path}: {error}") from error


def reported_headset(name: str, about: str, size: tuple[int, int], rate_hz: float, eyes: Eyes) -> Headset:
    """Return a headset as a connected runtime reports it. about: what runtime and headset it is."""
    views = eyes.views(Pose())
    return Headset(
        name=name,
        summary=f"{about}, {size[0]}x{size[1]} per eye",
        source=f"reported by {about}",
        emulated=REPORTED,
        eye_size_px=size,
        refresh_hz=rate_hz,
        eyes=tuple(
            HeadsetEye(view.pose, view.fov, hidden=view.hidden.polygons if view.hidden is not None else ())
            for view in views
        ),
    )


def _vive(data: Table, path: Path) -> Headset:
    found, device = data.tables("tracking_to_eye_transform"), data.table("device")
    if len(found) != 2:
        raise data.fault("tracking_to_eye_transform", f"has {len(found)} eyes: expected the left one and the right one")
    size = tuple(device.whole(f"eye_target_{side}_in_pixels", 1, 1 << 15) for side in ("width", "height"))
    aspect = device.within("physical_aspect_x_over_y", 0.1, 10)
    places = [-_matrix(eye, "extrinsics", (3, 4))[0, 3] for eye in found if "extrinsics" in eye]
    if "lens_separation" in data or len(places) < 2:
        half = data.within("lens_separation", 0, 1) / 2
        places = [-half, half]
    eyes = tuple(_vive_eye(eye, float(x), (2.0, 2.0 / aspect)) for eye, x in zip(found, places, strict=True))
    return Headset(
        name=path.stem,
        summary=f"SteamVR's configuration of a headset, {size[0]}x{size[1]} per eye",
        source=path.name,
        eye_size_px=size,
        refresh_hz=REFRESH_HZ,
        eyes=eyes,
    )


def _matrix(data: Table, key: str, shape: tuple[int, int]) -> Array:
    try:
        found = np.array(data.raw(key), np.float64)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.shape != shape or not np.isfinite(found).all():
        raise data.fault(key, f"is no matrix of {shape[0]} x {shape[1]} finite numbers")
    return found


def _vive_eye(data: Table, x: float, panel: tuple[float, float]) -> HeadsetEye:
    turn = _matrix(data, "eye_to_head", (3, 3)) if "eye_to_head" in data else np.eye(3)
    centres, coefficients = {}, {}
    for colour, name in _NAMES.items():
        told = data.table(name)
        told.word("type", _KINDS, _KINDS[0])
        numbers = told.numbers("coeffs")
        if not 3 <= len(numbers) <= 8 or any(numbers[4:]):
            raise told.fault("coeffs", f"has {len(numbers)} numbers: expected 3 to 8, those after the fourth 0")
        k1, k2, k3, k4 = (*numbers, 0.0)[:4]
        coefficients[colour] = (k1, k2, k3, k4)
        centres[colour] = (told.number("center_x"), -told.number("center_y"))  # there +y is down
    focal = _matrix(data, "intrinsics", (3, 3))[0, 0]
    lens = ViveLens(float(focal), centres, coefficients, data.within("undistort_r2_cutoff", 0, 100, above=True))
    return HeadsetEye(Pose((x, 0, 0), _quaternion(turn)), _seen_through(lens, panel), panel, lens)


def _seen_through(lens: ViveLens, panel: tuple[float, float]) -> Fov:
    """Return the least field of view that holds what the panel shows of any colour."""
    x, y = (np.linspace(-side / 2, side / 2, 129) for side in panel)
    places = np.stack(np.meshgrid(x, y), axis=-1)
    shown = []
    for colour in COLOURS:
        from_centre = places - lens.centres[colour]
        r = np.hypot(*np.moveaxis(from_centre, -1, 0))
        inside = r * r <= lens.cutoff_r2
        shown.append((from_centre * lens.scales(colour, r)[..., None])[inside])
    every = np.concatenate(shown)
    (left, down), (right, up) = every.min(axis=0), every.max(axis=0)
    return Fov.from_tangents((left, right, down, up))


def _quaternion(turn: Array) -> Any:
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(turn).as_quat()


def _hmdq(data: Table, path: Path) -> Headset:
    found = _geometry(data)
    if found is None:
        raise InputError(
            "neither SteamVR's configuration (tracking_to_eye_transform) nor an export of hmdq (rec_rts and raw_eye)"
        )
    size = found.numbers("rec_rts", 2)
    eyes = tuple(_hmdq_eye(found, side) for side in ("Left", "Right"))
    return Headset(
        name=path.stem,
        summary=f"exported by hmdq, {size[0]:g}x{size[1]:g} per eye",
        source=f"hmdq, {path.name}",
        emulated=REPORTED,
        eye_size_px=size,
        refresh_hz=REFRESH_HZ,
        eyes=eyes,
    )


def _geometry(data: Table) -> Table | None:
    """Return the first table with views, wherever this version of the format keeps it."""
    if "rec_rts" in data and "raw_eye" in data:
        return data
    for key in (*data.keys(),):
        if isinstance(data.raw(key), dict) and (found := _geometry(data.table(key))) is not None:
            return found
    return None


def _hmdq_eye(data: Table, side: str) -> HeadsetEye:
    raw = data.table("raw_eye").table(side)
    fov = Fov.from_tangents([raw.number(f"tan_{end}") for end in ("left", "right", "bottom", "top")])
    pose = _matrix(data.table("eye2head"), side, (3, 4))
    meshes = data.table("ham_mesh") if "ham_mesh" in data and data.raw("ham_mesh") else Table({})
    hidden = _triangles(meshes.table(side), fov) if side in meshes and meshes.raw(side) else ()
    return HeadsetEye(Pose(pose[:, 3], _quaternion(pose[:, :3])), fov, hidden=hidden)


def _triangles(mesh: Table, fov: Fov) -> tuple[Polygon, ...]:
    """Return the hidden triangles in tangents; in the file they lie in 0..1 of the view."""
    left, right, down, up = fov.tangents
    count = len(mesh.raw("verts_raw"))
    places = _matrix(mesh, "verts_raw", (count - count % 3, 2)) * (right - left, up - down) + (left, down)
    return tuple(tuple((float(x), float(y)) for x, y in corners) for corners in places.reshape(-1, 3, 2))
