"""A furnished room by daylight with a view: near, mid and far things, thin things, fine texture everywhere."""

from __future__ import annotations

import numpy as np

from ...geometry import Pose
from .._model import Background, Scene, SceneSource, Texture, scenes
from . import _paint, _print
from ._bake import Daylight, Occluders, lamp_light
from ._pieces import GLOWING, INSIDE, Piece, Pieces, merged, surface_points
from ._room_furniture import build_furniture
from ._room_outside import build_outside, daylight
from ._room_shell import HIGH, LOW, WINDOW, build_shell
from ._room_sun import GAIN, sun_floor
from ._room_things import CEILING_LAMP, DESK_LAMP, FLOOR_LAMP, PENDANT, build_things

SUMMARY = (
    "a furnished room with a window view: fine texture, thin, near (0.4 m) and far (beyond 20 m) things, baked light"
)
SEED = 20
ELEVATION, AZIMUTH = np.radians(36), np.radians(38)  # of the sun, azimuth from -z towards +x
TOWARDS_SUN = np.array([np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION), -np.cos(ELEVATION) * np.cos(AZIMUTH)])
SUN = (2.0, 1.75, 1.4)
SKY_BACKGROUND = Background((0.13, 0.30, 0.66), (0.68, 0.78, 0.90), (0.30, 0.34, 0.22))


def build() -> Scene:
    """The room; the same to the last bit every time."""
    rng = np.random.default_rng(SEED)
    pieces = Pieces()
    build_shell(pieces)
    build_furniture(pieces, rng)
    build_things(pieces, rng)
    build_outside(pieces, rng)
    textures = _textures(pieces)
    index = {texture.name: i for i, texture in enumerate(textures)}
    meshes = merged(pieces, _lights(pieces), index.__getitem__)
    walk = ((-1.6, 0.8, -1.6), (1.6, 2.2, 1.6))
    return Scene("room", SUMMARY, meshes, textures, SKY_BACKGROUND, viewpoint=Pose((0.0, 1.6, 0.0)), walk_bounds_m=walk)


def _textures(pieces: list[Piece]) -> list[Texture]:
    boards = _paint.planks()
    pictures = {
        "planks": boards,
        "wood": _paint.wood(),
        "bricks": _paint.bricks(),
        "wallpaper": _paint.wallpaper(),
        "plaster": _paint.plaster(),
        "fabric": _paint.fabric(),
        "speckle": _paint.speckle(),
        "foliage": _paint.foliage(),
        "grass": _paint.grass(),
        "roof": _paint.roof(),
        "facade": _paint.facade(),
        "mesh": _paint.perforated(),
        "map": _paint.globe(),
        "books": _print.book_spines(),
        "posters": _print.posters(),
    }
    clamped = Texture(
        "sun-floor", sun_floor(boards, pieces, TOWARDS_SUN, np.random.default_rng(SEED + 1)), repeat=False
    )
    return [*(Texture(name, image) for name, image in pictures.items()), clamped]


def _lights(pieces: list[Piece]) -> list[np.ndarray]:
    """Baked light of every vertex, piece by piece."""
    inside = [piece for piece in pieces if piece.place == INSIDE]
    baked = iter(_indoor_light(inside))
    lights = []
    for piece in pieces:
        if piece.place == INSIDE:
            lights.append(next(baked) * (1 + GAIN if piece.texture == "sun-floor" else 1))
        elif piece.place == GLOWING:
            lights.append(np.ones((len(piece.surface.positions), 3)))
        else:
            lights.append(daylight(piece.surface, two_sided=piece.double_sided))
    return lights


def _indoor_light(inside: list[Piece]) -> list[np.ndarray]:
    rng = np.random.default_rng(SEED + 2)
    loose = np.concatenate([surface_points(p.surface, 0.05, rng) for p in inside if p.shades])
    walls = np.concatenate([surface_points(p.surface, 0.06, rng) for p in inside if not p.shades])
    room = Occluders(LOW, HIGH, loose, walls)
    counts = [len(p.surface.positions) for p in inside]
    points = np.concatenate([p.surface.positions for p in inside]).astype(np.float32)
    normals = np.concatenate([p.surface.normals for p in inside]).astype(np.float32)
    two_sided = np.repeat([p.double_sided for p in inside], counts)
    painted = np.repeat([p.texture == "sun-floor" for p in inside], counts)
    day = Daylight(WINDOW, (2.2, 2.45, 2.8), SUN, TOWARDS_SUN)
    upwards = normals[:, 1:2] * 0.5 + 0.5
    light = (
        np.array((0.36, 0.32, 0.27), np.float32) * (1 - upwards) + np.array((0.33, 0.34, 0.36), np.float32) * upwards
    )
    light = light + day.sky_light(room, points, normals, two_sided)
    for lamp, colour in (
        (PENDANT - (0, 0.06, 0), (0.36, 0.25, 0.14)),
        (FLOOR_LAMP, (0.50, 0.33, 0.17)),
        (DESK_LAMP, (0.22, 0.17, 0.11)),
        ((-1.1, 0.25, -2.5), (0.75, 0.62, 0.46)),  # what the sun's patch on the floor throws back
        (CEILING_LAMP, (0.42, 0.38, 0.32)),
    ):
        light = light + lamp_light(room, points, normals, two_sided, lamp=lamp, colour=colour)
    light *= room.ambient(points, normals)[:, None]
    light += np.where(painted[:, None], 0, day.sun_light(room, points, normals, two_sided))
    return np.split(light, np.cumsum(counts)[:-1])


scenes.register(SceneSource("room", SUMMARY, build))
