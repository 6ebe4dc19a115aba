"""Surfaces cut along the cells of a grid, against areas that are known without cutting."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from lit_rooms import in_atlas, wall

from hmdwarp.cloudlight.voxels import VoxelGrid, voxel_surfaces
from hmdwarp.scenes import Scene, load_scene

GREY = (0.6, 0.6, 0.6)


def scene_of(*quads) -> Scene:
    meshes = [attrs.evolve(mesh, texture=-1) for mesh in in_atlas(quads, 0.5)]
    return Scene("trial", "for tests", meshes)


def covered(scene: Scene, size: int):
    """(grid, pieces, areas by x, y, z of the cell)."""
    grid = VoxelGrid.around(scene, size)
    pieces = voxel_surfaces(scene, grid)
    areas = np.zeros((size,) * 3)
    np.add.at(areas, np.unravel_index(pieces.cells, areas.shape, order="F"), pieces.areas)
    return grid, pieces, areas


@pytest.mark.parametrize("name", ["lantern", "sunroom"])
def test_no_area_is_lost_or_made(name):
    """The triangles' own areas, summed: float64 rounds thousands of pieces by less than 1e-9."""
    scene = load_scene(name)
    corners = np.concatenate([m.positions[m.triangles] for m in scene.meshes if m.light_uv is not None])
    a, b, c = corners.astype(np.float64).transpose(1, 0, 2)
    known = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    grid, pieces, _ = covered(scene, 32)
    assert pieces.areas.sum() * grid.cell_m**2 == pytest.approx(known, rel=1e-9)


def test_a_square_fills_cells_whole_halves_at_its_sides_and_quarters_at_its_corners():
    """It is 13 cells wide, from the middle of a cell to that of another, by the grid's rule."""
    grid, pieces, areas = covered(scene_of(wall((0, 0.5, 0), (1, 0, 0), (0, 0, -1), GREY)), 16)
    along = np.array([0, 0.5, *[1.0] * 12, 0.5, 0])
    assert grid.cell_m == pytest.approx(2 / 13)
    assert np.allclose(areas.sum(axis=1), np.outer(along, along))
    assert len(pieces) == 14 * 14
    assert np.allclose(pieces.normals, (0, 1, 0)) and np.allclose(pieces.places[:, 1], 0.5)
    assert np.allclose(pieces.albedo, GREY, atol=1e-7)


def test_a_slanted_square_covers_each_cell_as_a_fine_raster_of_it_does():
    """A cell gets its share of 2000 x 2000 points; one of about 200 cells has about 20000, whose
    even spacing leaves at most a row along each side in doubt: 4 x 141 of them, 3 %."""
    right, up = np.array((0.7, 0.3, 0.1)), np.array((-0.2, 0.5, 0.6))
    grid, pieces, areas = covered(scene_of(wall((0.1, 0.2, 0.3), tuple(right), tuple(up), GREY)), 16)
    share = (np.arange(2000) + 0.5) / 1000 - 1
    points = (0.1, 0.2, 0.3) + share[:, None, None] * right + share[None, :, None] * up
    cell = np.floor((points.reshape(-1, 3) - grid.low) / grid.cell_m).astype(int)
    counted = np.zeros_like(areas)
    np.add.at(counted, tuple(cell.T), 1.0)
    whole = 4 * np.linalg.norm(np.cross(right, up)) / grid.cell_m**2
    assert np.abs(areas - counted / 2000**2 * whole).max() < 0.03 * whole / 200 * 2
    assert pieces.areas.sum() == pytest.approx(whole)


def test_a_scene_where_nothing_is_lit_has_no_pieces():
    grid = VoxelGrid.around(load_scene("planes"), 8)
    assert len(voxel_surfaces(load_scene("planes"), grid)) == 0 and np.isfinite(grid.low).all()
