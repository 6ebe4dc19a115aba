"""Painted textures of the library's scenes, by name; the same bytes every time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from .._mesh import Texture
from . import _pictures, _surfaces
from ._pictures import ripples
from ._surfaces import Image, sun_floor

__all__ = ["ripples", "sun_floor", "textures_named"]

_PAINTERS: dict[str, Callable[[], Image]] = {
    "books": _pictures.book_spines,
    "bricks": _surfaces.bricks,
    "dials": _pictures.dials,
    "fabric": _surfaces.fabric,
    "facade": _surfaces.facade,
    "flag": _pictures.flag,
    "floor-normals": ripples,
    "foliage": _surfaces.foliage,
    "grass": _surfaces.grass,
    "hud": _pictures.head_up,
    "label-1": partial(_pictures.label, "PAGE 1 OF 2"),
    "label-2": partial(_pictures.label, "PAGE 2 OF 2"),
    "leaded": _pictures.leaded_glass,
    "map": _surfaces.globe,
    "marble": _pictures.marble,
    "mesh": _surfaces.perforated,
    "page-1": _pictures.page,
    "page-2": partial(_pictures.page, seed=981),
    "paintings": _pictures.paintings,
    "pane": partial(_pictures.dusty_glass, ("WARP", "AND", "FIELD")),
    "pane-plain": partial(_pictures.dusty_glass, (), seed=810),
    "pickets": _pictures.pickets,
    "planks": _surfaces.planks,
    "plaster": _surfaces.plaster,
    "posters": _pictures.posters,
    "roof": _surfaces.roof,
    "speckle": _surfaces.speckle,
    "wallpaper": _surfaces.wallpaper,
    "wood": _surfaces.wood,
}
_CLAMPED = {"flag", "hud", "label-1", "label-2", "page-1", "page-2", "paintings"}
_LINEAR = {"floor-normals"}


def textures_named(*names: str) -> list[Texture]:
    """Return the textures of these names; each is painted when its image is first used."""
    return [Texture(name, _PAINTERS[name], srgb=name not in _LINEAR, repeat=name not in _CLAMPED) for name in names]
