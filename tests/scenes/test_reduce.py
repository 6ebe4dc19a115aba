"""A reduced scene keeps outlines, seams, materials and bodies."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from mirrored import shapes_of

import hmdwarp.scenes
from hmdwarp.base import SceneError
from hmdwarp.client.effects import effects
from hmdwarp.scenes import Ball, Body, Material, Mesh, Scene, Texture, load_scene, unlit


def patch(corner, edge_u, edge_v, cell_m: float = 0.25) -> Mesh:
    """A parallelogram with vertices every `cell_m`, its front where edge_u x edge_v points."""
    corner, edge_u, edge_v = (np.asarray(vector, float) for vector in (corner, edge_u, edge_v))
    lengths = np.linalg.norm(edge_u), np.linalg.norm(edge_v)
    u, v = (np.linspace(0, 1, max(1, round(length / cell_m)) + 1) for length in lengths)
    vv, uu = (grid.reshape(-1, 1) for grid in np.meshgrid(v[::-1], u, indexing="ij"))
    positions = corner + uu * edge_u + vv * edge_v
    normals = np.tile(np.cross(edge_u, edge_v) / np.prod(lengths), (len(uu), 1))
    index = np.arange(len(uu)).reshape(len(v), len(u))
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    return Mesh("made", positions, normals, np.hstack([uu, vv]) * lengths, np.full_like(normals, 0.5), triangles)


def box(centre, size, cell_m: float = 0.3) -> Mesh:
    """The six patches of a box of full `size`, as one."""
    x, y, z = np.diag(np.asarray(size, float))
    low = np.asarray(centre, float) - (x + y + z) / 2
    faces = ((low + z, x, y), (low + x, -x, y), (low + x + z, -z, y), (low, z, y), (low + y + z, x, -z), (low, x, z))
    sides = [patch(*face, cell_m=cell_m) for face in faces]
    starts = np.cumsum([0, *(len(side.positions) for side in sides[:-1])])
    rows = {name: np.concatenate([getattr(side, name) for side in sides]) for name in ("positions", "normals", "uv")}
    triangles = np.concatenate([side.triangles + start for side, start in zip(sides, starts, strict=True)])
    return Mesh("made", **rows, light=np.full_like(rows["normals"], 0.5), triangles=triangles)


def mesh_of(surface: Mesh, light=(0.5, 0.5, 0.5), **fields) -> Mesh:
    return attrs.evolve(surface, light=np.broadcast_to(light, surface.positions.shape), **fields)


def scene_of(*meshes: Mesh, **fields) -> Scene:
    return Scene("made", "", meshes, **fields)


def area(mesh: Mesh) -> float:
    a, b, c = (mesh.positions[mesh.triangles[:, k]].astype(np.float64) for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def open_edges(*meshes: Mesh) -> float:
    """Metres of edges that belong to one triangle only, meshes put together by position."""
    sides: dict[frozenset, int] = {}
    for mesh in meshes:
        places = [tuple(p) for p in mesh.positions]
        for triangle in mesh.triangles:
            for k in range(3):
                side = frozenset((places[triangle[k]], places[triangle[(k + 1) % 3]]))
                sides[side] = sides.get(side, 0) + 1
    ends = [tuple(side) for side, count in sides.items() if count == 1]
    return float(sum(np.linalg.norm(np.subtract(*pair)) for pair in ends))


FEW = 6  # of a sheet's 384 triangles; two would do, but the last slivers do not go
SHEET = patch((0, 0, 0), (4, 0, 0), (0, 3, 0))


def reduced(scene: Scene, share: float, **more) -> Scene:
    return hmdwarp.scenes.reduced(scene, share, least=0, **more)


def test_flat_even_surfaces_become_few_triangles_and_keep_their_outline():
    (kept,) = reduced(scene_of(mesh_of(SHEET)), 0.01).meshes
    assert len(kept.triangles) <= FEW
    assert area(kept) == pytest.approx(12, rel=1e-6)


def test_light_and_texture_that_bend_keep_vertices_where_they_bend():
    shadow = 0.2 + 0.8 * (SHEET.positions[:, :1] > 2)
    lit = mesh_of(SHEET, shadow * np.ones(3))
    (kept,) = reduced(scene_of(lit), 0.1).meshes
    edge = kept.positions[:, 0]
    assert ((edge >= 1.9) & (edge <= 2.3)).sum() >= 4  # both sides of the shadow's edge, at both ends of it
    assert area(kept) == pytest.approx(12, rel=1e-6)


def test_a_box_of_six_patches_stays_closed():
    whole = mesh_of(box((0, 0, 0), (1, 2, 3), cell_m=0.2))
    (kept,) = reduced(scene_of(whole), 0.02).meshes
    assert len(kept.triangles) <= 0.03 * len(whole.triangles)
    assert area(kept) == pytest.approx(22, rel=1e-5)
    assert open_edges(kept) == 0


def test_meshes_that_meet_still_meet():
    floor, wall = (
        mesh_of(patch((0, 0, 0), (0, 0, 2), (2, 0, 0))),
        mesh_of(patch((0, 0, 0), (0, 2, 0), (0, 0, 2)), (0.9, 0.2, 0.1)),
    )
    kept = reduced(scene_of(floor, wall), 0.1).meshes
    assert len(kept) == 2
    assert open_edges(*kept) == pytest.approx(12, rel=1e-6)  # three sides each; the fourth they share


def test_parts_that_move_apart_are_not_held_together():
    still, moving = mesh_of(SHEET), mesh_of(SHEET, body=1)
    kept = reduced(scene_of(still, moving, bodies=(Body("door", None),)), 0.01).meshes
    assert [mesh.body for mesh in kept] == [0, 1]
    assert all(len(mesh.triangles) <= FEW for mesh in kept)


@pytest.fixture(scope="module")
def balls() -> tuple[Scene, Scene]:
    """The scene of spheres, whole and with a fifth of its triangles."""
    scene = load_scene("spheres")
    return scene, reduced(scene, 0.2)


def test_every_vertex_is_one_of_the_original_ones_with_all_it_had(balls):
    scene, kept = balls
    for mesh, original in zip(kept.meshes, scene.meshes, strict=True):
        names = ("positions", "normals", "uv", "light", "albedo")
        known = {tuple(row) for row in np.concatenate([getattr(original, name) for name in names], axis=1)}
        assert {tuple(row) for row in np.concatenate([getattr(mesh, name) for name in names], axis=1)} <= known
    assert 0.19 <= kept.triangle_count / scene.triangle_count <= 0.201


def test_a_reduced_ball_keeps_its_shape(balls):
    scene, kept = balls
    for mesh, ball in zip(kept.meshes, shapes_of("spheres", Ball), strict=False):
        middles = mesh.positions[mesh.triangles].mean(axis=1)
        distance = np.linalg.norm(middles - ball.centre, axis=1)
        # The triangles go where most area is, so the smallest ball gets fewest: about 370 of its
        # 9216. Of 370 equal ones each has edges of 0.28 radii and its middle 0.013 radii inside;
        # three times that and a little, for they are not equal. Those without area at the poles
        # have theirs on the ball, within a float's rounding.
        assert distance.min() > 0.95 * ball.radius
        assert distance.max() < (1 + 1e-6) * ball.radius
        assert area(mesh) == pytest.approx(4 * np.pi * ball.radius**2, rel=0.03)


def test_see_through_and_head_locked_meshes_are_left_out():
    glass = mesh_of(SHEET, material=Material(see_through=True))
    hud, mirror = (
        mesh_of(SHEET, material=Material(head_locked=True)),
        mesh_of(SHEET, material=Material(reflectivity=0.5)),
    )
    kept = reduced(scene_of(glass, hud, mirror), 0.5)
    assert len(kept.meshes) == 1
    assert not effects.of(kept)


class Waving:
    def __init__(self, rest):
        self.rest = rest

    def positions(self, time_ns):
        return self.rest + time_ns * 1e-9

    def velocities(self, time_ns):
        return np.ones_like(self.rest)


def test_a_flag_waves_with_the_vertices_it_has_left():
    flag = mesh_of(SHEET)
    (kept,) = reduced(scene_of(attrs.evolve(flag, deformation=Waving(flag.positions))), 0.1).meshes
    assert np.array_equal(kept.deformation.positions(0), kept.positions)
    assert np.allclose(kept.deformation.positions(2_000_000_000), kept.positions + 2)
    assert kept.deformation.velocities(0).shape == kept.positions.shape


@pytest.mark.parametrize("share", [0, -0.2, 1.5, float("nan")])
@pytest.mark.parametrize("of", ["share", "texture"])
def test_a_share_that_is_none_is_refused(of, share):
    with pytest.raises(SceneError, match="expected more than 0 and at most 1"):
        reduced(scene_of(mesh_of(SHEET)), **{"share": 1, of: share})


def test_a_scene_of_few_triangles_keeps_them_all():
    scene = load_scene("planes")
    assert hmdwarp.scenes.reduced(scene, 0.2).triangle_count == scene.triangle_count


def painted(image: np.ndarray, **fields) -> Texture:
    return Texture("painted", image.astype(np.uint8), **fields)


def test_a_smaller_texture_is_the_mean_of_the_light_of_its_texels():
    """A quarter on each axis: of 16 texels, 0 and 255 by turns, light is a half, and sRGB 188.

    The mean of the bytes would be 128, which is what a linear texture gets, and coverage in alpha.
    """
    board = np.where(np.indices((8, 16)).sum(axis=0) % 2, 255, 0)[..., None] * np.ones(4)
    for srgb, wanted in ((True, 188), (False, 128)):
        (made,) = reduced(scene_of(mesh_of(SHEET), textures=[painted(board, srgb=srgb)]), 1, texture=0.25).textures
        assert made.image.shape == (2, 4, 4)
        assert made.srgb == srgb
        assert (made.image == (wanted, wanted, wanted, 128)).all()


def test_texels_stay_in_their_places_and_a_texture_keeps_one():
    parts = np.zeros((6, 4, 3))
    parts[:3, 2:], parts[3:, :2] = (255, 0, 0), (0, 0, 255)
    scene = scene_of(mesh_of(SHEET), textures=[painted(parts, repeat=False)])
    (made,) = reduced(scene, 1, texture=0.4).textures
    assert np.array_equal(made.image, [[(0, 0, 0), (255, 0, 0)], [(0, 0, 255), (0, 0, 0)]])
    assert not made.repeat
    (least,) = reduced(scene, 1, texture=0.01).textures
    assert least.image.shape == (1, 1, 3)


def test_at_full_scale_textures_are_the_scenes_own_and_nothing_is_painted_before_it_is_used():
    calls = []

    def paint() -> np.ndarray:
        calls.append(1)
        return np.full((4, 4, 3), 200, np.uint8)

    scene = scene_of(mesh_of(SHEET), textures=[Texture("late", paint)])
    assert reduced(scene, 1).textures[0] is scene.textures[0]
    made = reduced(scene, 1, texture=0.5).textures[0]
    assert not calls
    assert (made.image == 200).all()
    assert made.image is made.image
    assert len(calls) == 1


def test_unlit_is_the_material_alone():
    lit = mesh_of(SHEET, (0.1, 0.2, 0.3), albedo=np.broadcast_to((0.2, 0.8, 0.6), SHEET.positions.shape))
    assert np.allclose(unlit(scene_of(lit)).meshes[0].light, (0.2, 0.8, 0.6))


def test_where_the_albedo_is_not_known_the_hue_of_what_is_baked_stands_for_it():
    dark = mesh_of(SHEET, (0.02, 0.04, 0.01))
    made = unlit(scene_of(dark)).meshes[0].light[0]
    assert made / made.sum() == pytest.approx(np.array([2, 4, 1]) / 7)
    assert made @ (0.2126, 0.7152, 0.0722) == pytest.approx(0.5)
    black = unlit(scene_of(mesh_of(SHEET, (0, 0, 0)))).meshes[0].light[0]
    assert (black == 0.5).all()
