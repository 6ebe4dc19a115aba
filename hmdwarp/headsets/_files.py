"""Headset files: the package's, the user's, and what SteamVR keeps and hmdq exports."""

from __future__ import annotations

import functools
import json
import math
import re
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError, Table, in_brief, parsed, text_of, unknown_name
from ..base.documents import DocumentError, parse_json
from ..base.named_files import FACTS, text_in
from ..geometry import Eyes, Fov, Hidden, Polygon, Pose
from ._model import COLOURS, IPD_RANGE_M, MODELS, Array, Headset, HeadsetEye, Lens, ViveLens

REPORTED = "the views as the runtime reported them; no lens, because the runtime corrects it"
_REFRESH_HZ = 90.0  # of a Vive; a file does not tell, --rate takes another
_NAMES = {"red": "distortion_red", "green": "distortion", "blue": "distortion_blue"}


def reported_headset(name: str, about: str, size: tuple[int, int], rate_hz: float, eyes: Eyes) -> Headset:
    """Return a headset as a connected runtime reports it. about: what runtime and headset it is."""
    seen = tuple(HeadsetEye(view.pose, view.fov, hidden=view.hidden) for view in eyes.views(Pose()))
    summary = f"{about}, {size[0]}x{size[1]} per eye"
    return Headset(name, summary, f"reported by {about}", size, rate_hz, seen, emulated=REPORTED)


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
    summary = f"SteamVR's configuration of a headset, {size[0]}x{size[1]} per eye"
    return Headset(path.stem, summary, path.name, size, _REFRESH_HZ, eyes)


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
    pose = Pose.from_matrix(np.column_stack([turn, (x, 0, 0)]))
    centres, coefficients = {}, {}
    for colour, name in _NAMES.items():
        told = data.table(name)
        told.word("type", ("DISTORT_DPOLY3",), "DISTORT_DPOLY3")
        numbers = told.numbers("coeffs")
        if not 3 <= len(numbers) <= 8 or any(numbers[4:]):
            raise told.fault("coeffs", f"has {len(numbers)} numbers: expected 3 to 8, those after the fourth 0")
        k1, k2, k3, k4 = (*numbers, 0.0)[:4]
        coefficients[colour] = (k1, k2, k3, k4)
        centres[colour] = (told.number("center_x"), -told.number("center_y"))  # there +y is down
    focal = _matrix(data, "intrinsics", (3, 3))[0, 0]
    cutoff = data.within("undistort_r2_cutoff", 0, 100, above=True)
    lens = ViveLens((0.0, 0.0), 1.0, float(focal), coefficients, cutoff, centres=centres)
    # The least field of view that holds what the panel shows of any colour.
    places = np.stack(np.meshgrid(*(np.linspace(-side / 2, side / 2, 129) for side in panel)), axis=-1)
    shown = []
    for colour in COLOURS:
        r = np.hypot(*np.moveaxis(places - centres[colour], -1, 0))
        shown.append(lens.tangents(colour, places)[r * r <= cutoff])
    (left, down), (right, up) = (ends(np.concatenate(shown), axis=0) for ends in (np.min, np.max))
    return HeadsetEye(pose, Fov.from_tangents((left, right, down, up)), panel, lens)


def _hmdq(data: Table, path: Path) -> Headset:
    found = _geometry(data)
    if found is None:
        raise InputError("neither SteamVR's configuration (tracking_to_eye_transform) nor hmdq's (rec_rts and raw_eye)")
    size = found.numbers("rec_rts", 2)
    eyes = []
    for side in ("Left", "Right"):
        raw = found.table("raw_eye").table(side)
        fov = Fov.from_tangents([raw.number(f"tan_{end}") for end in ("left", "right", "bottom", "top")])
        pose = Pose.from_matrix(_matrix(found.table("eye2head"), side, (3, 4)))
        meshes = found.table("ham_mesh") if "ham_mesh" in found and found.raw("ham_mesh") else Table({})
        hidden = None
        if side in meshes and meshes.raw(side):  # triangles, which lie in 0..1 of the view
            left, right, down, up = fov.tangents
            count = len(meshes.table(side).raw("verts_raw"))
            matrix = _matrix(meshes.table(side), "verts_raw", (count - count % 3, 2))
            places = matrix * (right - left, up - down) + (left, down)
            hidden = Hidden(tuple(tuple(map(tuple, each)) for each in places.reshape(-1, 3, 2).tolist()), fov)
        eyes.append(HeadsetEye(pose, fov, hidden=hidden))
    summary = f"exported by hmdq, {size[0]:g}x{size[1]:g} per eye"
    return Headset(path.stem, summary, f"hmdq, {path.name}", size, _REFRESH_HZ, tuple(eyes), emulated=REPORTED)


def _geometry(data: Table) -> Table | None:
    """Return the first table with views, wherever this version of the format keeps it."""
    if "rec_rts" in data and "raw_eye" in data:
        return data
    for key in (*data.keys(),):
        if isinstance(data.raw(key), dict) and (found := _geometry(data.table(key))) is not None:
            return found
    return None


_FOLDER = Path(__file__).parent
_EXAMPLE = "hmdwarp/headsets/rift-dk1.toml"
MIRRORED = "mirrored"
IPD, DRAWN = ":ipd=", ":hidden=drawn"
FILE_ENDINGS = (".toml", ".json")
# Of shipped ones once: checking what eyes hide takes 20 ms, and each RunOptions asks for its own.
_of_toml = functools.cache(lambda path: parsed(text_of(path, "a headset, as a .toml file"), path, _headset, _EXAMPLE))


def headset_names() -> list[str]:
    """Return the names of the shipped headsets, sorted."""
    return sorted(p.stem for p in _FOLDER.glob("*.toml"))


def load_headset(spec: str) -> Headset:
    """Load a shipped headset by name, or the user's own .toml or .json file by path.

    `NAME:ipd=62` sets the distance of its pupils, in millimetres; `NAME:hidden=drawn`, before that,
    draws and counts what its lenses hide.
    Source: Valve's description of the HMD's JSON file; hmdq (R. Musil), as it reads OpenVR.
    Errors: InputError naming the file and its fault.
    """
    if not isinstance(spec, str):
        raise InputError(f"headset is {in_brief(spec)}: expected a name, or a file")
    name, distance, ipd = spec.partition(IPD)
    if distance:
        if not re.fullmatch(r"[0-9]{1,4}(\.[0-9]*)?", ipd):
            raise InputError(f"headset '{spec}': expected NAME{IPD} and millimetres")
        return load_headset(name).with_ipd(float(ipd) * 1e-3)
    if name.endswith(DRAWN):
        drawn = load_headset(name.removesuffix(DRAWN))
        return attrs.evolve(drawn, name=name, eyes=tuple(attrs.evolve(eye, hidden=None) for eye in drawn.eyes))
    path = Path(name) if name.endswith(FILE_ENDINGS) else _FOLDER / f"{name}.toml"
    if not name.endswith(FILE_ENDINGS) and name not in headset_names():
        raise unknown_name("headset", name, [*headset_names(), *(f"FILE{ending}" for ending in FILE_ENDINGS)])
    try:
        if path.suffix == ".json":  # that SteamVR keeps of a Vive, Vive Pro or Index, or that hmdq exports
            data = Table(parse_json(text_in(path, FACTS)))
            return _vive(data, path) if "tracking_to_eye_transform" in data else _hmdq(data, path)
        return (_of_toml if path.parent == _FOLDER else _of_toml.__wrapped__)(path)
    except DocumentError as error:
        raise InputError(f"{path}: this is no JSON: {error}") from error
    except InputError as error:  # the model's own name no file
        raise error if str(error).startswith(str(path)) else InputError(f"{path}: {error}") from error


def _headset(data: Table) -> Headset:
    panel, eyes, lens = data.table("panel"), data.table("eyes"), data.table("lens") if "lens" in data else None
    size_m = _pair(panel, "eye_size_m") if "eye_size_m" in panel else None
    if lens is not None and size_m is None:
        raise panel.missing("eye_size_m")
    ipd_m = eyes.within("ipd_m", 0, 1)

    def eye(data: Table, side: int, fov: Fov | None = None) -> HeadsetEye:
        """Return the left (side -1) or right eye (1). fov: in place of its table's tangents."""
        offset_m = data.numbers("offset_m", 3) if "offset_m" in data else (0, 0, 0)
        half = -side * math.radians(data.number("cant_deg", 0.0)) / 2
        turn: tuple[float, ...] = (0.0, math.sin(half), 0.0, math.cos(half))
        if "orientation_xyzw" in data:
            turn = data.numbers("orientation_xyzw", 4)
        fov = Fov.from_tangents(data.numbers("tangents", 4)) if fov is None else fov
        made: Lens | None = None
        if lens is not None and size_m is not None:
            model = lens.text("model")
            if model not in MODELS:
                raise InputError(f"unknown lens model '{model}': known is {', '.join(MODELS)}")
            x, y = _pair(lens, "axis_from_centre_m")
            axis = _pair(data, "lens_axis_m") if "lens_axis_m" in data else (-side * x, y)
            made = MODELS[model].of(lens, axis, float(np.hypot(*(np.array(size_m) / 2 + np.abs(axis)))))
        pose = Pose(np.add(offset_m, (side * ipd_m / 2, 0, 0)), turn)
        hidden = _rounded_corners(data, fov) if "hidden_share" in data else _polygons(data)
        return HeadsetEye(pose, fov, size_m, made, Hidden(hidden, fov) if hidden else None)

    if "left" in eyes:
        left = eye(eyes.table("left"), -1)
    else:  # one that looks straight ahead, by four angles
        fov_deg = data.table("fov_deg")
        fov = Fov(*(math.radians(fov_deg.number(side)) for side in ("left", "right", "down", "up")))
        left = eye(Table({}), -1, fov)
    other = eyes.raw("right") if "right" in eyes else MIRRORED
    if isinstance(other, str) and other != MIRRORED:
        raise eyes.fault("right", f"is '{other}': expected \"{MIRRORED}\", or a table")
    right = left.mirrored() if other == MIRRORED else eye(eyes.table("right"), 1)
    return Headset(
        name=data.text("name"),
        summary=data.text("summary"),
        source=data.text("source"),
        emulated=data.text("emulated", ""),
        eye_size_px=panel.numbers("eye_size_px", 2),
        refresh_hz=panel.number("refresh_hz"),
        eyes=(left, right),
        ipd_range_m=_pair(eyes, "ipd_range_m") if "ipd_range_m" in eyes else IPD_RANGE_M,
        peak_cd_m2=panel.number("peak_cd_m2") if "peak_cd_m2" in panel else None,
        black_cd_m2=panel.number("black_cd_m2") if "black_cd_m2" in panel else None,
    )


def _pair(data: Table, key: str) -> tuple[float, float]:
    first, second = data.numbers(key, 2)
    return first, second


def _polygons(data: Table) -> tuple[Polygon, ...]:
    try:
        found = [np.array(polygon, np.float64) for polygon in (data.raw("hidden") if "hidden" in data else [])]
        if all(one.ndim == 2 and one.shape[1] == 2 and len(one) > 2 and np.isfinite(one).all() for one in found):
            return tuple(tuple(map(tuple, one.tolist())) for one in found)
    except (TypeError, ValueError):
        pass
    raise data.fault("hidden", "is no list of polygons: expected each as three or more [x, y] in tangents")


def _rounded_corners(data: Table, fov: Fov) -> tuple[Polygon, ...]:
    """Return four corners that hide a share of the view, outside of a superellipse.

    It stands for an area of which the share is known, and how far one sees to each side.
    Source: area of Lame's curve |x|^n + |y|^n = 1: 4 Gamma(1 + 1/n)^2 / Gamma(1 + 2/n).
    """
    edge = fov.tangents
    (left, right, down, up) = np.tan(np.radians(data.numbers("seen_deg", 4))) if "seen_deg" in data else edge
    share = data.within("hidden_share", 0, 0.5)
    if share == 0:
        return ()
    of_box = (1 - share) * (edge[1] - edge[0]) * (edge[3] - edge[2]) / ((right - left) * (up - down))
    low, high = 0.9, 200.0
    if not (_area(low) < of_box < _area(high)):
        says = f"and hidden_share {share:g} do not fit each other: the share is that of the whole view"
        raise data.fault("seen_deg", says)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if _area(middle) < of_box else (low, middle)
    turn = np.linspace(0, math.pi / 2, 33)
    arc = np.stack([np.cos(turn) ** (2 / low), np.sin(turn) ** (2 / low)], axis=1)
    centre, half = np.array([left + right, down + up]) / 2, np.array([right - left, up - down]) / 2
    made: list[NDArray[np.float64]] = []
    for x, y in ((0, 2), (0, 3), (1, 2), (1, 3)):
        corner = np.array([edge[x], edge[y]])
        ends = np.array([(centre[0], corner[1]), corner, (corner[0], centre[1])])
        made.append(np.vstack([arc * half * np.sign(corner - centre) + centre, ends]))
    return tuple(tuple((float(x), float(y)) for x, y in points) for points in made)


def _area(power: float) -> float:
    """Return the share of its box that a superellipse covers."""
    return math.gamma(1 + 1 / power) ** 2 / math.gamma(1 + 2 / power)


def headset_toml(headset: Headset) -> str:
    """Return the file of a headset as runtimes report it. Errors: InputError for a lens."""
    if headset.lens is not None:
        raise InputError(f"headset '{headset.name}' has a lens, which a file of views cannot hold")
    texts = {key: getattr(headset, key) for key in ("name", "summary", "source", "emulated")}
    lines = [f"{key} = {json.dumps(text)}" for key, text in texts.items() if text]
    lines += ["", "[panel]", f"eye_size_px = {list(headset.eye_size_px)}", f"refresh_hz = {headset.refresh_hz!r}"]
    lines += ["", "[eyes]", f"ipd_m = {headset.ipd_m!r}"]
    for name, side, eye in zip(("left", "right"), (-1, 1), headset.eyes, strict=True):
        offset = eye.head_from_eye.position_m - (side * headset.ipd_m / 2, 0, 0)
        lines += ["", f"[eyes.{name}]", f"tangents = {eye.fov.tangents.tolist()}", f"offset_m = {offset.tolist()}"]
        lines += [f"orientation_xyzw = {list(eye.head_from_eye.unit_quaternion)}"]
        if eye.hidden is not None:
            lines.append(f"hidden = {[[list(point) for point in polygon] for polygon in eye.hidden.polygons]}")
    return "\n".join(lines) + "\n"
