"""Headset files (.toml) to Headset objects."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..geometry import Fov
from ..registry import unknown_name
from ._model import COLOURS, Headset, RadialLens

_FOLDER = Path(__file__).parent


def headset_names() -> list[str]:
    """Names of the shipped headsets, sorted."""
    return sorted(p.stem for p in _FOLDER.glob("*.toml"))


def load_headset(name: str) -> Headset:
    """A shipped headset by name, or one's own .toml file by path. Errors: InputError naming the file and what is wrong in it."""
    path = Path(name) if name.endswith(".toml") else _FOLDER / f"{name}.toml"
    if not path.is_file():
        if name.endswith(".toml"):
            raise InputError(f"headset file {name} is not there")
        raise unknown_name("headset", name, headset_names())
    try:
        return _headset(tomllib.loads(path.read_text(encoding="utf-8")))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"headset file {path}: {error}") from error
    except KeyError as error:
        raise InputError(f"headset file {path}: the key {error} is missing; {_FOLDER.name}/rift-dk1.toml has them all") from error
    except (TypeError, ValueError) as error:
        raise InputError(f"headset file {path}: {error}") from error


def _headset(data: dict) -> Headset:
    panel, fov = data["panel"], data["fov_deg"]
    size_m = tuple(map(float, panel["eye_size_m"]))
    return Headset(
        name=data["name"],
        summary=data["summary"],
        source=data["source"],
        eye_size_px=tuple(map(int, panel["eye_size_px"])),
        eye_size_m=size_m,
        refresh_hz=float(panel["refresh_hz"]),
        ipd_m=float(data["eyes"]["ipd_m"]),
        left_fov=Fov(*(math.radians(fov[side]) for side in ("left", "right", "down", "up"))),
        lens=_lens(data["lens"], size_m) if "lens" in data else None,
    )


def _lens(data: dict, size_m: tuple[float, float]) -> RadialLens:
    if data["model"] != "radial":
        raise InputError(f"unknown lens model '{data['model']}': known is radial")
    axis = tuple(map(float, data["axis_from_centre_m"]))
    corner = np.array(size_m) / 2 + np.abs(axis)
    return RadialLens(
        axis_from_centre_m=axis,
        unit_m=float(data["unit_m"]),
        tangent_per_unit=float(data["tangent_per_unit"]),
        coefficients={colour: tuple(map(float, data[colour])) for colour in COLOURS},
        reach=float(np.hypot(*corner) / data["unit_m"]),
    )
