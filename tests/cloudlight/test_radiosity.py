"""Indirect light against solutions that are known without patches."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from lit_rooms import GREY, box, cube, in_atlas, placed, scene_of, wall

from hmdwarp.base import SceneError
from hmdwarp.cloudlight.radiosity import RAYS, direct_light, transport_of
from hmdwarp.scenes import Lamp, Pendulum, Scene, lamps_at, scenes


def test_a_furnace_glows_everywhere_alike(tmp_path):
    """In a closed box under first light e everywhere, rho e / (1 - rho) comes back: each row of
    form factors sums to 1, so only float32 rounds, and 1 / (1 - rho) times."""
    transport = transport_of(scene_of(cube(), 0.5), tmp_path)
    assert len(transport.patches) == 6 * 16
    assert np.allclose(transport.form_factors.sum(axis=1), 1, atol=1e-12)
    first = np.full((96, 3), 0.7)
    assert np.allclose(transport.indirect(first), 0.7 * 0.6 / 0.4, rtol=1e-5)


def test_light_is_neither_made_nor_lost(tmp_path):
    """What lamps give, all surfaces absorb. Rays find form factors within 1 %: the error of even
    points falls nearly as 1 / RAYS, times the edges that cut a patch's view into tens of pieces."""
    transport = transport_of(
        scene_of([*cube((0.7, 0.5, 0.2)), *box((-0.6, -1, -0.6), (0, 0, 0), GREY)], 0.25), tmp_path
    )
    direct = transport.direct([(np.array((0.5, 0.6, 0.3, 1.0)), (1.0, 1.0, 1.0))])
    given, absorbed, _ = balance(transport, direct)
    assert RAYS >= 512
    assert np.allclose(absorbed, given, rtol=0.01)


def balance(transport, direct) -> list[np.ndarray]:
    """What lamps give, what all surfaces absorb, and the light of each."""
    light, areas = direct + transport.indirect(direct), transport.patches.areas
    return [areas @ direct, areas @ ((1 - transport.patches.albedo) * light), light]


def test_parallel_squares_light_each_other_by_the_known_form_factor(tmp_path):
    """Howell's catalogue C-11 for squares of side 1 at distance 1: 0.19982. Points spread evenly
    err by a few / RAYS; 4 / 512 of all rays are 0.008."""
    known = (2 / np.pi) * (0.5 * np.log(4 / 3) + 2 * np.sqrt(2) * np.arctan(np.sqrt(0.5)) - np.pi / 2)
    assert known == pytest.approx(0.19982, abs=1e-5)
    below = wall((0, 0, 0), (0.5, 0, 0), (0, 0, -0.5), (0.8, 0.8, 0.8))
    above = wall((0, 1, 0), (0.5, 0, 0), (0, 0, 0.5), (0.5, 0.5, 0.5))
    transport = transport_of(scene_of([below, above], 1.0), tmp_path)
    assert transport.form_factors == pytest.approx(np.array([[0, known], [known, 0]]), abs=0.008)
    got = transport.indirect(np.array([[1.0] * 3, [0.0] * 3]))[:, 0]
    # Two unknowns solved by hand: E0 = F rho1 E1, E1 = F rho0 (1 + E0).
    lit = known * 0.8 / (1 - 0.8 * 0.5 * known**2)
    order = np.argsort(transport.patches.centres[:, 1])
    assert got[order] == pytest.approx([known * 0.5 * lit, lit], abs=0.008)


@pytest.mark.parametrize("place", [(5.0, 0, 0), (0, 1.05, 0), (1.0, 0.3, 0.2)], ids=["outside", "in a wall", "on it"])
def test_no_light_comes_through_a_wall(tmp_path, place):
    """And a lamp on a surface gives finite light."""
    transport = transport_of(scene_of(cube(), 0.5), tmp_path)
    light = transport.indirect(transport.direct([(np.array((*place, 1.0)), (1.0, 1.0, 1.0))]))
    assert np.isfinite(light).all()
    if abs(np.array(place)).max() > 1:
        assert (light == 0).all()


def test_form_factors_are_kept(tmp_path):
    quads = cube()
    first = transport_of(scene_of(quads, 1.0), tmp_path)
    (kept,) = tmp_path.iterdir()
    assert np.array_equal(transport_of(scene_of(quads, 1.0), tmp_path).form_factors, first.form_factors)
    whole = kept.read_bytes()
    other = tmp_path / "other.npz"
    np.savez(other, form_factors=np.eye(2), sky=np.zeros((2, 3)))
    for damaged in (b"no archive", whole[: len(whole) // 2], whole[:-1], b"", other.read_bytes()):
        kept.write_bytes(damaged)
        assert np.array_equal(transport_of(scene_of(quads, 1.0), tmp_path).form_factors, first.form_factors)
        assert kept.read_bytes() != damaged  # mended


def test_scenes_that_lamps_cannot_light_are_refused():
    plain = attrs.evolve(in_atlas(cube(), 1.0)[0], texture=-1)
    lamp = Lamp(Pendulum((0, 1, 0), 0.5, 0.5, 2.0), (1, 1, 1))
    with pytest.raises(SceneError, match="has a place in the light atlas and deforms"):
        Scene("trial", "for tests", [attrs.evolve(plain, deformation=object())], lamps=[lamp])
    with pytest.raises(SceneError, match="5 lamps: expected at most 4"):
        Scene("trial", "for tests", [], lamps=[lamp] * 5)
    with pytest.raises(SceneError, match="outside the light atlas of 64x64"):
        transport_of(scene_of([wall((0, 0, 0), (9, 0, 0), (0, 0, -9), GREY)], 0.2))
    flat = attrs.evolve(plain, positions=np.zeros_like(plain.positions))
    with pytest.raises(SceneError, match=f"mesh '{flat.name}': a triangle has no area"):
        transport_of(Scene("trial", "for tests", [flat], lamps=[lamp]))


@pytest.mark.parametrize("time_ms", [300, 1000, 1500, 2500])
def test_a_patch_of_sun_has_its_whole_power_wherever_its_edges_are(time_ms):
    """Against 400 points a patch. An edge is placed within 1/21 of a texel, 17 mm, on either side
    of a patch of sun some 2 m wide: 2 % if all edges erred alike."""
    scene = scenes.get("sunroom").build()
    transport, lamps = transport_of(scene), lamps_at(scene, time_ms * 1_000_000)
    middles = (np.arange(20) + 0.5) / 20 - 0.5
    fine = sum(
        direct_light(transport.blockers, transport.patches.at(x, y), transport.patches.normals, lamps) / 400
        for x in middles
        for y in middles
    )
    power, wanted = (transport.patches.areas @ light for light in (transport.direct(lamps), fine))
    assert power == pytest.approx(wanted, rel=0.02)


@pytest.mark.parametrize("time_ms", [900, 2500])
def test_moving_surfaces_light_as_if_they_stood_still(time_ms):
    """The same rays, but those between what stands still end at the door after they were cast: few
    that pass an edge within the rounding of a float32 may differ, of 512 each."""
    scene, time_ns = attrs.evolve(scenes.get("doorway").build(), origin_m=(0.5, 0, -0.25)), time_ms * 1_000_000
    moving, still = transport_of(scene, time_ns=time_ns), transport_of(placed(scene, time_ns))
    assert [mesh.is_moving for mesh in (moving, still)] == [True, False]
    assert np.array_equal(moving.patches.texels, still.patches.texels)
    assert np.abs(moving.form_factors - still.form_factors).max() <= 2 / RAYS
    assert (moving.form_factors != still.form_factors).mean() < 1e-5
    lamps = lamps_at(scene, time_ns)
    got, wanted = (each.indirect(each.direct(lamps)) for each in (moving, still))
    # Solved bounce by bounce here, at once there.
    assert np.allclose(got, wanted, rtol=1e-3, atol=1e-4 * wanted.max())


def test_no_light_passes_a_shut_door():
    """And what an open one lets through is neither made nor lost, as in
    test_light_is_neither_made_nor_lost: where the door stands flush with the doorway, a little ends
    in the crack between two surfaces that touch, 2 % of what there is."""
    scene = scenes.get("doorway").build()
    (bright, colour), _ = lamps_at(scene, 0)
    found = []
    for time_ns in (0, 2_500_000_000):
        transport = transport_of(scene, time_ns=time_ns)
        given, absorbed, light = balance(transport, transport.direct([(bright, colour)]))
        assert np.allclose(absorbed, given, rtol=0.02)
        beyond = (transport.patches.centres[:, 2] > -1.99) & (transport.patches.bodies == 0)
        found.append(light[beyond])
    assert (found[0] == 0).all() and found[1].min() > 0
