"""Scenes in pieces: what is unpacked is what was packed, and all pieces are the scene."""

from __future__ import annotations

import functools

import attrs
import numpy as np
import pytest

from hmdwarp.cloudlight.radiosity import receivers_of
from hmdwarp.scenes import (
    COARSEST,
    FULL,
    Background,
    Mesh,
    Pieces,
    Scene,
    blocking,
    indirect_atlas,
    load_scene,
    partial_scene,
    pieces_of,
    with_lamps_stopped,
)


@functools.cache
def cut(name: str) -> Pieces:
    return Pieces(load_scene(name))


ARRAYS = ("positions", "uv", "light", "triangles")
UNDER_LAMPS = ("normals", "light_uv", "albedo")


@pytest.mark.parametrize("name", ["planes", "gallery", "parade", "cockpit"])
def test_all_pieces_are_the_scene(name):
    scene = load_scene(name)
    pieces = pieces_of(scene, 1.0, 1.0, lit=True)
    assert pieces is pieces_of(scene, 1.0, 1.0, lit=True)
    assert pieces.scene is scene
    for mesh, parts in pieces.cut:
        if not parts:
            assert not mesh.is_surface or mesh.material.reflectivity or not len(mesh.triangles)
            continue
        corners = np.concatenate([part.positions[part.triangles] for part in parts])
        whole = mesh.positions[mesh.triangles]
        assert sorted(map(bytes, corners.astype(np.float32))) == sorted(map(bytes, whole.astype(np.float32)))


@pytest.mark.parametrize("name", ["planes", "gallery", "parade", "lantern", "doorway"])
def test_unpacking_restores_what_was_packed(name):
    pieces = cut(name)
    for index, mesh in enumerate(pieces.meshes):
        number = pieces.number_of_mesh(index)
        ((found, got),) = pieces.meshes_in(number, pieces.things[number])
        assert found == index and got.texture == mesh.texture and got.body == mesh.body
        arrays = ARRAYS + UNDER_LAMPS * pieces.under_lamps(mesh)
        assert all(np.array_equal(getattr(got, array), getattr(mesh, array)) for array in arrays)
    for index, got in pieces.meshes_in(0, pieces.things[0]):
        assert all(np.array_equal(getattr(got, array), getattr(pieces.stand_ins[index], array)) for array in ARRAYS)
    assert len(pieces.things) == pieces.count
    for texture, scale in pieces.levels:
        number = pieces.number_of_level(texture, scale)
        assert pieces.meshes_in(number, pieces.things[number]) == []
        *which, image = pieces.level_in(number, pieces.things[number])
        assert which == [texture, scale]
        if scale == FULL:
            assert np.array_equal(image, pieces.scene.textures[texture].image)


def test_stand_ins_are_few_and_the_first_to_cross_is_small():
    pieces = cut("parade")
    standing = sum(len(mesh.triangles) for mesh in pieces.stand_ins if mesh is not None)
    assert standing <= 2000 < pieces.scene.triangle_count / 10
    first = sum(len(pieces.things[number]) for number in pieces.first)
    assert first < pieces.whole_bytes / 50
    assert {0, *(pieces.number_of_level(texture, COARSEST) for texture, _ in pieces.levels)} == set(pieces.first)


@pytest.mark.parametrize("name", ["parade", "lantern", "doorway"])
def test_a_blank_scene_holds_nothing_of_what_is_sent(name):
    pieces = cut(name)
    blank = pieces.blank()
    standing = [mesh for mesh in pieces.stand_ins if mesh is not None]
    assert len(blank.meshes) == len(pieces.meshes) + len(pieces.at_start) + len(standing)
    assert all(not mesh.positions.any() and not mesh.light.any() and not mesh.triangles.any() for mesh in blank.meshes)
    lit = [mesh for mesh in blank.meshes if mesh.light_uv is not None]
    assert bool(lit) == bool(pieces.scene.lamps)
    assert not any(getattr(mesh, lamp).any() for mesh in lit for lamp in UNDER_LAMPS)
    assert all((texture.image == 128).all() for texture in blank.textures)


def test_light_crosses_at_the_start_where_there_are_lamps():
    """Packed, which loses nothing."""
    assert cut("parade").light is None
    lantern = cut("lantern")
    assert np.array_equal(lantern.light, indirect_atlas(lantern.scene, 0))
    dark = Pieces(attrs.evolve(lantern.scene, lamps=()))
    assert 1000 < lantern.start_bytes - dark.start_bytes < lantern.light.nbytes
    assert lantern.whole_bytes > dark.whole_bytes


@pytest.mark.parametrize("name", ["lantern", "doorway"])
def test_blockers_of_all_meshes_are_those_of_the_scene(name):
    """Bodies where they are at that instant; a triangle without area stops nothing."""
    scene = load_scene(name)
    for time_ns in (0, 1_500_000_000):
        stopped = with_lamps_stopped(scene, time_ns)
        found = blocking(stopped, time_ns, [*scene.meshes][::-1])
        wanted = receivers_of(stopped, time_ns).blockers.rows
        assert sorted(map(bytes, found)) == sorted(map(bytes, wanted)) and len(found) > 10
    lit = next(mesh for mesh in scene.meshes if mesh.light_uv is not None)
    flat = attrs.evolve(lit, triangles=np.zeros_like(lit.triangles))
    assert len(blocking(scene, meshes=[flat])) == 0


def test_an_empty_scene_has_no_pieces():
    empty = Scene(
        "empty", "nothing", meshes=[Mesh("none", *np.zeros((2, 0, 3)), np.zeros((0, 2)), *np.zeros((2, 0, 3)))]
    )
    for scene in (empty, Scene("sky", "sky alone", meshes=(), background=Background.uniform((1, 1, 1)))):
        pieces = Pieces(scene)
        assert pieces.meshes == [] and pieces.meshes_in(0, pieces.things[0]) == [] and pieces.first == [0]
        assert pieces.whole_bytes < 100


def test_a_full_share_returns_the_scene_itself():
    scene = load_scene("gallery")
    assert partial_scene(scene, 1.0, 1.0, lit=True) is scene
    fewer = partial_scene(scene, 0.3, 0.5, lit=True)
    kinds = [mesh.material for mesh in scene.meshes if mesh.material.reflectivity]
    assert [mesh.material for mesh in fewer.meshes if mesh.material.reflectivity] == kinds
    assert fewer.triangle_count < 0.6 * scene.triangle_count
