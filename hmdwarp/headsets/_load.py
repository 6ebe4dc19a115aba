"""Read headset files (.toml)."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..errors import InputError, unknown_name
from ..geometry import Fov
from ..options.tables import Table, parsed, text_of
from ._model import COLOURS, Headset, RadialLens

_FOLDER = Path(__file__).parent


def headset_names() -> list[str]:
    """Return the names of the shipped headsets, sorted."""
    return sorted(p.stem for p in _FOLDER.glob("*.toml"))


def load_headset(name: str) -> Headset:
    """Load a shipped headset by name, or the user's own .toml file by path.

    Errors: InputError naming the file and its fault.
    """
    path = Path(name) if name.endswith(".toml") else _FOLDER / f"{name}.toml"
    if not name.endswith(".toml") and not path.is_file():
        raise unknown_name("headset", name, [*headset_names(), "FILE.toml"])
    text, example = text_of(path, "a headset, as a .toml file"), "hmdwarp/headsets/rift-dk1.toml"
    try:
        return parsed(text, path, _headset, example)
    except InputError as error:  # the model's own name no file
        raise error if str(error).startswith(str(path)) else InputError(f"{path}: {error}") from error


def _headset(data: Table) -> Headset:
    panel, fov_deg = data.table("panel"), data.table("fov_deg")
    width_m, height_m = panel.numbers("eye_size_m", 2)
    size_m = width_m, height_m
    lens = data.table("lens") if "lens" in data else None
    return Headset(
        name=data.text("name"),
        summary=data.text("summary"),
        source=data.text("source"),
        eye_size_px=panel.numbers("eye_size_px", 2),
        eye_size_m=size_m,
        refresh_hz=panel.number("refresh_hz"),
        ipd_m=data.table("eyes").number("ipd_m"),
        left_fov=Fov(*(math.radians(fov_deg.number(side)) for side in ("left", "right", "down", "up"))),
        lens=_lens(lens, size_m) if lens else None,
        peak_cd_m2=panel.number("peak_cd_m2") if "peak_cd_m2" in panel else None,
        black_cd_m2=panel.number("black_cd_m2") if "black_cd_m2" in panel else None,
    )


def _lens(data: Table, size_m: tuple[float, float]) -> RadialLens:
    if data.text("model") != "radial":
        raise InputError(f"unknown lens model '{data.text('model')}': known is radial")
    x, y = data.numbers("axis_from_centre_m", 2)
    axis, unit_m = (x, y), data.number("unit_m")
    corner = np.array(size_m) / 2 + np.abs(axis)
    return RadialLens(
        axis_from_centre_m=axis,
        unit_m=unit_m,
        tangent_per_unit=data.number("tangent_per_unit"),
        coefficients={colour: data.numbers(colour) for colour in COLOURS},
        reach=float(np.hypot(*corner) / unit_m) if unit_m else 0.0,
    )
