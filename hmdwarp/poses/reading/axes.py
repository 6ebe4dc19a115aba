"""From a file's axes to OpenXR's: +x right, +y up, -z forward."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, unknown_name
from ...options import Table
from .. import quaternions

OPENXR = "openxr"
AUTO = "auto"  # --axes auto: those that fit the motion, where that is clear
_PRESETS = Path(__file__).parents[1] / "presets"
_AXES = {"x": (1.0, 0, 0), "y": (0, 1.0, 0), "z": (0, 0, 1.0)}
# right, up, forward of the turn by a quarter (or half) that lifts the named axis to +y and moves
# everything else as little as possible.
_LIFTS = {"y": "x,y,-z", "-y": "x,-y,z", "z": "x,z,y", "-z": "x,-z,-y", "x": "-y,x,-z", "-x": "y,-x,-z"}
_SYNTAX = "a preset of 'hmdwarp list axes', or world=right,up,forward head=right,up,forward (world=x,z,y head=x,-y,z)"
_PARTS = re.compile(r"\b(world|head)\s*=\s*([^\s;]+)")


@attrs.frozen(eq=False)
class Axes:
    """Axes of a file, relative to OpenXR's, of the world and of the head.

    A rotation carries points of the head into the world in both, so both have the same handedness:
    orientation_openxr = world @ orientation_file @ head.T, where both are matrices.
    """

    world: NDArray[np.float64]  # (3, 3), rows are OpenXR's right, up and back in the file's world axes
    head: NDArray[np.float64]  # (3, 3), the same in the axes of the file's head
    # xyzw, a turn of the world alone that follows (gravity set upright; the head's own axes stay)
    tilt: NDArray[np.float64] | None = None
    name: str = ""  # the preset they come from
    metres_per_unit: float | None = None  # of files with these axes, if they state it

    def __attrs_post_init__(self) -> None:
        if np.linalg.det(self.world) * np.linalg.det(self.head) < 0:
            what = "one of the two is left-handed and the other right-handed"
            raise InputError(f"--axes {self.words()}: {what}; a rotation keeps the hand, so turn one axis around")

    def words(self) -> str:
        """Return them as `parse_axes` takes them, for instance "world=x,z,y head=x,-y,z"."""
        bases = ((basis[0], basis[1], -basis[2]) for basis in (self.world, self.head))
        world, head = (",".join(map(axis_word, rows)) for rows in bases)
        return f"world={world} head={head}"

    def label(self) -> str:
        """Return the preset's name, or the axes themselves."""
        return f"{self.name} ({self.words()})" if self.name else self.words()

    def up(self) -> str:
        """Return the world's up as an axis of the file, for instance "z"."""
        return axis_word(self.world[1])

    def in_openxr(self, orientation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return converted quaternions (n, 4)."""
        converted = orientation.copy()
        self.apply(None, converted)
        return converted

    def apply(self, position: NDArray[np.float64] | None, orientation: NDArray[np.float64]) -> None:
        """Convert positions (n, 3) and quaternions (n, 4), in place.

        Under a change of basis B a rotation about v by an angle becomes one about B v by det(B)
        times the angle; a left-handed file (det -1) needs no other treatment. Where the head's
        basis is another one, a fixed turn of the head follows.
        """
        if not np.array_equal(self.world, np.eye(3)):
            orientation[:, :3] = orientation[:, :3] @ (round(np.linalg.det(self.world)) * self.world).T
            if position is not None:
                position[:] = position @ self.world.T
        if not np.array_equal(self.world, self.head):
            from scipy.spatial.transform import Rotation

            turn = Rotation.from_matrix(self.world @ self.head.T).as_quat()
            orientation[:] = quaternions.multiply(orientation, turn)
        if self.tilt is not None:
            orientation[:] = quaternions.multiply(self.tilt, orientation)
            if position is not None:
                position[:] = quaternions.rotate(self.tilt, position)


def preset_names() -> list[str]:
    """Return the names of the presets, sorted."""
    return sorted(p.stem for p in _PRESETS.glob("*.toml"))


@attrs.frozen
class Preset:
    """Axes that many files share, by name."""

    name: str
    summary: str
    axes: Axes
    source: str


def load_preset(name: str) -> Preset:
    """Load axes by name. Errors: UnknownNameError with the nearest known name."""
    if name not in preset_names():
        raise unknown_name("axes preset", name, preset_names())
    data = Table(tomllib.loads((_PRESETS / f"{name}.toml").read_text(encoding="utf-8")))
    scale = data.number("metres_per_unit") if "metres_per_unit" in data else None
    axes = Axes(_basis(str(data.text("world"))), _basis(str(data.text("head"))), name=name, metres_per_unit=scale)
    preset = Preset(name, data.text("summary"), axes, data.text("source"))
    data.refuse_unread()
    return preset


def parse_axes(text: str) -> Axes:
    """Parse `--axes`: a preset, or "world=right,up,forward head=right,up,forward".

    One of world and head, or three axes alone, hold for both. Errors: InputError, UnknownNameError.
    """
    text = text.strip().lower()
    found: dict[str, str] = dict(_PARTS.findall(text))
    if found:
        if _PARTS.sub("", text).strip(" ,;"):
            raise InputError(f"--axes '{text}': expected {_SYNTAX}")
        world = _basis(found.get("world", found.get("head", "")))
        return Axes(world, _basis(found.get("head", found.get("world", ""))))
    if "," in text:
        return Axes(_basis(text), _basis(text))
    if not re.fullmatch(r"[a-z][a-z0-9 _-]*", text):
        raise InputError(f"--axes '{text}': expected {_SYNTAX}")
    return load_preset(re.sub(r"[ _]", "-", text)).axes


def parse_up(text: str) -> Axes:
    """Parse `--up`: an axis (y, z, -z, ..), three axes "right,up,forward", or three numbers.

    An axis: world and head are both turned so that it becomes +y; for z that is (x, y, z) -> (x, z,
    -y). Three axes: all of them stated, left-handed ones included. Three numbers: the direction
    that is really up in a y-up file whose gravity is tilted; only the world is turned, by the
    smallest angle.
    Errors: InputError.
    """
    text = text.strip().lower().removeprefix("+")
    if text in _LIFTS:
        return parse_axes(_LIFTS[text])
    fields = [f.strip() for f in text.split(",")]
    if len(fields) != 3:
        wanted = "an axis (y, z, -z, x ...), three as right,up,forward (x,z,y), or three numbers (0.04,0.95,0.3)"
        raise InputError(f"--up '{text}': expected {wanted}")
    try:
        direction = np.array([float(f) for f in fields])
    except ValueError:
        return parse_axes(",".join(fields))
    return Axes(np.eye(3), np.eye(3), tilt=upright(direction))


def _basis(words: str) -> NDArray[np.float64]:
    rows = []
    for word in words.split(","):
        sign, letter = (-1.0, word[1:]) if word.startswith("-") else (1.0, word.removeprefix("+"))
        if letter not in _AXES:
            raise InputError(f"axis '{word}': expected x, y or z, with or without a sign")
        rows.append(np.array(_AXES[letter]) * sign)
    basis = np.array(rows)
    if basis.shape != (3, 3) or abs(abs(np.linalg.det(basis)) - 1) > 1e-9:
        raise InputError(f"--axes '{words}': expected three different ones, right,up,forward, for instance x,z,y")
    basis[2] *= -1  # OpenXR's z points back
    return basis


def axis_word(direction: NDArray[np.float64]) -> str:
    """Return the axis that a direction (3,) points along most, for instance "-z"."""
    k = int(np.abs(direction).argmax())
    return ("-" if direction[k] < 0 else "") + "xyz"[k]


def upright(up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the smallest turn, xyzw, that carries a direction (3,) to +y. Errors: InputError."""
    length = float(np.linalg.norm(up))
    if not (math.isfinite(length) and length > 1e-6):
        raise InputError(f"--up {up.tolist()}: expected a direction that is not zero")
    up = up / length
    # The half-way quaternion from up to +y; straight down has no smallest turn, x is taken.
    half = np.array([-up[2], 0.0, up[0], 1.0 + up[1]]) if up[1] > -1 + 1e-12 else np.array([1.0, 0, 0, 0])
    return np.asarray(half / np.linalg.norm(half))
