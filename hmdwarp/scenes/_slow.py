"""What makes a scene slow to draw, told before anything is drawn."""

from __future__ import annotations

from collections.abc import Callable

import attrs

from ._scene import Scene


@attrs.frozen
class _Load:
    """Something that a scene may have too much of."""

    what: str
    count: Callable[[Scene], int]
    # From here on one line is said of it.
    many: int
    # Why it costs, and what to do about it.
    remedy: str


# Each costs 5 to 20 ms of CPU time for one eye and picture where Mesa's llvmpipe draws (two cores,
# 320x400); a GPU draws triangles far faster, but sorts, skins and calls no faster.
_LOADS = (
    _Load(
        "triangles",
        lambda scene: scene.triangle_count,
        250_000,
        "simplify the meshes in the tool that made them, as a software renderer takes 1 s for ten million",
    ),
    _Load(
        "transparent triangles",
        lambda scene: sum(len(mesh.triangles) for mesh in scene.meshes if mesh.material.see_through),
        20_000,
        "each eye's picture sorts them all and its layer draws them three times; simplify them, make opaque what need "
        "not be seen through, or draw them into the picture alone (--effects no-transparency)",
    ),
    _Load(
        "moving vertices",
        lambda scene: sum(len(mesh.positions) for mesh in scene.meshes if mesh.deformation is not None),
        50_000,
        "skins are bent on the CPU for each instant that is drawn; simplify what moves, or leave its animation out",
    ),
    _Load(
        "moving bodies",
        lambda scene: len(scene.bodies),
        100,
        "each is drawn by itself; join those that move together under one node",
    ),
    _Load(
        "textures",
        lambda scene: len(scene.textures),
        500,
        "each is drawn by itself; join small ones into one picture (a texture atlas)",
    ),
)


def slow_in(scene: Scene) -> tuple[str, ...]:
    """Return a line for each thing that the scene has so much of that drawing it takes long.

    Each line has the count and what to do about it.
    """
    counted = ((load, load.count(scene)) for load in _LOADS)
    return tuple(f"{count:,} {load.what}: {load.remedy}" for load, count in counted if count >= load.many)
