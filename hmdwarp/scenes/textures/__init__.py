"""Painted textures of the library's scenes, by name; the same bytes every time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from .._mesh import Texture
from . import _gallery, _prints, _sheets, _surfaces
from ._gallery import ripples
from ._noise import Image
from ._sun_floor import sun_floor

__all__ = ["ripples", "sun_floor", "textures_named"]

_PAINTERS: dict[str, Callable[[], Image]] = {
    "books": _prints.book_spines,
    "bricks": _surfaces.bricks,
    "dials": _prints.dials,
    "fabric": _surfaces.fabric,
    "facade": _surfaces.facade,
    "flag": _prints.flag,
    "floor-normals": ripples,
    "foliage": _surfaces.foliage,
    "grass": _surfaces.grass,
    "hud": _sheets.head_up,
    "leaded": _sheets.leaded_glass,
    "map": _surfaces.globe,
    "marble": _gallery.marble,
    "mesh": _surfaces.perforated,
    "paintings": _gallery.paintings,
    "pane": partial(_sheets.dusty_glass, ("WARP", "AND", "FIELD")),
    "pane-plain": partial(_sheets.dusty_glass, (), seed=810),
    "pickets": _sheets.pickets,
    "planks": _surfaces.planks,
    "plaster": _surfaces.plaster,
    "posters": _prints.posters,
    "roof": _surfaces.roof,
    "speckle": _surfaces.speckle,
    "wallpaper": _surfaces.wallpaper,
    "wood": _surfaces.wood,
}
_CLAMPED = {"flag", "hud", "paintings"}
_LINEAR = {"floor-normals"}


def textures_named(*names: str) -> list[Texture]:
    """Return the textures of these names; each is painted when its image is first used."""
    return [Texture(name, _PAINTERS[name], srgb=name not in _LINEAR, repeat=name not in _CLAMPED) for name in names]
