"""Options of scenes: how a file is read, and what a client knows of what moves."""

from __future__ import annotations

import attrs

from .. import geometry  # a face: help texts load this file, and no NumPy
from ..base import PICTURE, Declared, InputError, Number, are_digits, one_of, option

NONE = "none"
SEED = "seed:"  # of inputs, before its number
FILE_ENDINGS = (".glb", ".gltf", ".obj", ".ply", ".xml")
_UPS = ("y", "z")
# How a client that draws learns of motion: it knows all of it beforehand, goes on from the last
# state with its speed, or stays with it; and how a note says so.
FORESEEN, EXTRAPOLATED, HELD = "foreseen", "extrapolated", "held"
KNOWS = {
    FORESEEN: "is known to the client beforehand, as if recorded",
    EXTRAPOLATED: "is known to the client by the newest state that has arrived, continued at its speed",
    HELD: "is known to the client by the newest state that has arrived, which it holds",
}


@attrs.frozen
class SceneOptions(Declared):
    """How a scene file is read; the scenes of the library take none of it. Errors: InputError."""

    heading = "Scene files"
    scale: float = option(
        1.0,
        "Metres per unit of a scene file, like 0.001 for millimetres.",
        name="scene_scale",
        study=PICTURE,
        valid=Number(least=1e-6, most=1e6),
    )
    up: str = option(
        "y", "What is up in a scene file: y or z.", name="scene_up", study=PICTURE, valid=one_of(*_UPS), limits="y or z"
    )
    # See `place`; None for a free place.
    viewpoint: str | None = option(
        None,
        "Where the viewer stands in a scene file: X,Y,Z or X,Y,Z,YAW (metres, +y up; degrees to the left), or a "
        "camera of the file by name or number (from 0); by default a free place.",
        study=PICTURE,
        numeric=True,
        metavar="PLACE",
    )
    # None for the first one and those that can play with it.
    animation: str | None = option(
        None,
        "Animation of a scene file to play, by name or number (from 0), or none; by default the first, and those "
        "that move other things.",
        study=PICTURE,
        numeric=True,
        metavar="NAME",
    )

    def __attrs_post_init__(self) -> None:
        self.place  # noqa: B018 (raises at once for numbers that make no place)

    @property
    def place(self) -> tuple[float, ...] | None:
        """The viewpoint as x, y, z in metres and yaw in degrees; None where it names a camera.

        Errors: InputError for numbers that are not three or four finite ones.
        """
        parts = [part.strip() for part in (self.viewpoint or "").split(",")]
        try:
            numbers = [float(part.encode("ascii")) for part in parts]
        except ValueError:
            return None
        if len(numbers) == 1 and are_digits(parts[0]):
            return None  # a camera's number
        if len(numbers) not in (3, 4) or not all(abs(number) <= geometry.MOST_M for number in numbers):
            raise InputError(
                f"--viewpoint '{self.viewpoint}': expected X,Y,Z or X,Y,Z,YAW, such as 0,1.6,2,90, or the name or "
                "number of a camera in the file"
            )
        return (*numbers, 0.0)[:4]


def numbered(names: list[str], name: str, kind: str, flag: str, also: str = "") -> int:
    """Return the index of `name` among the names: a name first, else a number from 0.

    also: another word that the option takes. Errors: InputError, with what there is.
    """
    if name in names:
        return names.index(name)
    if are_digits(name) and int(name) < len(names):
        return int(name)
    known = ", ".join(f"{number} '{known}'" for number, known in enumerate(names)) or f"no {kind}"
    wanted = " or ".join(filter(None, ("one of them" if names else "", also)))
    raise InputError(f"{flag} '{name}': the file has {known}{f'; expected {wanted}' if wanted else ''}")


def seed_of(spec: str) -> int:
    text = spec.removeprefix(SEED)
    if not are_digits(text):
        raise InputError(f"--input {spec}: expected seed:N with a whole number N, such as seed:1, or a file")
    return int(text)
