"""Photons: on the wire and in the books of both sides; and their power, against known light."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lit_rooms import GREY, Fixed, box, cube, scene_of, wall

from hmdwarp.cloudlight.photons import (
    CUBE_BYTES,
    BundleRoom,
    BundleSender,
    Cube,
    PhotonTracer,
    TracedPhotons,
    kernel,
    kernel_factors,
    light_keys,
    octahedral,
    packed,
    shared_exponent,
    unpacked,
)
from hmdwarp.cloudlight.radiosity import of_atlas, transport_of
from hmdwarp.frames.layers import Update
from hmdwarp.scenes import Background, Lamp, lamps_at, load_scene

POWERS = st.floats(0, 6e4, width=32)


def content(cube: Cube, *bundles: bytes, whole: bool = True) -> np.ndarray:
    return np.frombuffer(cube.packed(whole=whole) + b"".join(bundles), np.uint8).copy()


def light_of(words: np.ndarray) -> np.ndarray:
    """As OpenGL reads RGB9_E5: a mantissa times 2 to the exponent less 15 and 9."""
    parts = np.stack([words & 511, words >> 9 & 511, words >> 18 & 511], axis=1)
    return np.ldexp(parts.astype(float), (words.astype(int) >> 27)[:, None] - 24)


@given(st.lists(st.tuples(POWERS, POWERS, POWERS), min_size=1, max_size=20))
def test_a_power_is_right_to_half_a_step_of_its_largest_part(powers):
    """Nine bits of the largest are 256 steps or more; below 2^-16 steps are of 2^-24."""
    powers = np.array(powers)
    read = light_of(shared_exponent(powers))
    assert (np.abs(read - powers) <= powers.max(axis=1, keepdims=True) / 512 + 2.0**-25).all()


def test_sent_bundles_are_read_back():
    """Places to half a step of the cube, 1 / 131070 of its edge."""
    chance = np.random.default_rng(5)
    cube = Cube(np.array((-2.0, 0.5, 7.0)), 5.5)
    places, powers = chance.uniform(0, 1, (300, 3)), chance.uniform(0, 0.01, (300, 3))
    normals = octahedral(np.repeat(np.eye(3), 100, axis=0))
    data = content(
        cube, packed((7, 3), places, normals, powers), packed((2, 1), *(x[:0] for x in (places, normals, powers)))
    )
    assert len(data) == CUBE_BYTES + 10 + 12 * 300 + 10
    whole, read, bundles = unpacked(data)
    assert whole and np.array_equal(read.low, cube.low) and read.edge == cube.edge
    assert [sent for sent, _ in bundles] == [(7, 3), (2, 1)] and len(bundles[1][1]) == 0
    words = bundles[0][1]
    steps = np.stack([words[:, 0] & 65535, words[:, 0] >> 16, words[:, 1] & 65535], axis=1)
    assert np.abs(steps / 65535 - places).max() <= 0.5001 / 65535
    assert np.array_equal(np.stack([words[:, 1] >> 16 & 255, words[:, 1] >> 24], axis=1), normals)
    assert np.array_equal(light_of(words[:, 2]), light_of(shared_exponent(powers)))


class Network:
    """A sender of bundles that hold the light they show, and a receiver; frames may get lost."""

    def __init__(self, bundles: int) -> None:
        self.book, self.room, self.under_way = BundleSender(bundles), BundleRoom(), []

    def send(self, lights: list[int], most: int, now: int) -> Update:
        self.book.settle(now)
        told = [bytes([light]) for light in lights]
        sent = []
        for bundle in self.book.stale(told)[:most]:
            entered = self.book.sent(bundle, told[bundle], empty=lights[bundle] == 0)
            if entered is not None:
                sent.append((entered, lights[bundle]))
        self.under_way.append([(one, light) for one, light in sent])
        return Update(np.zeros(0, np.uint8), tuple(one for one, _ in sent))

    def receive(self, number: int) -> None:
        for sent, light in self.under_way[number]:
            self.room.take(sent, photons(sent[0], light))


def photons(bundle: int, light: int) -> np.ndarray:
    """As many as the light says, each with its number and the bundle's."""
    return np.full((light, 3), 1000 * bundle + light, np.uint32)


@settings(max_examples=60)
@given(st.data())
def test_all_bundles_end_up_current_after_loss_and_overtaking(data):
    """Light 0 is a bundle without photons. After the last change, a few rounds without loss."""
    count = 5
    net = Network(count)
    waiting: list[int] = []
    every = [data.draw(st.lists(st.integers(0, 4), min_size=count, max_size=count)) for _ in range(4)]
    lights = every[-1]
    for now in range(12):
        lights = every[now // 3]
        update = net.send(lights, data.draw(st.integers(1, 3)), now)
        arrives = data.draw(st.booleans())
        net.book.heard(update, arrives, now + data.draw(st.integers(1, 4)))
        if arrives:
            waiting.append(now)
        for number in data.draw(st.permutations(waiting)) if data.draw(st.booleans()) else []:
            net.receive(number)  # some of them again
    for now in range(12, 12 + 2 * count + 6):
        net.book.heard(net.send(lights, 1, now), True, now + 1)
        net.receive(now)
    for number in reversed(waiting):
        net.receive(number)
    now_there = [photons(bundle, light) for bundle, light in enumerate(lights)]
    assert np.array_equal(net.room.words(), np.concatenate(now_there))
    assert net.book.whole and not net.book.stale([bytes([light]) for light in lights])
    net.book.settle(100)
    assert net.book.remembered == 0, "what is no longer under way"


# --- traced photons against light that is known without them --------------------------------------


COLOUR = (1.5, 1.0, 0.5)
POINT = (np.array((0.3, 0.2, -0.4, 1.0)), COLOUR)
SUN = (np.array((0.3, 0.9, -0.2, 0.0)), COLOUR)
WHITE_SKY = Background((1.0, 1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))


def tracer_of(scene, paths=256, bundles=64) -> PhotonTracer:
    return PhotonTracer(transport_of(scene), scene.background, paths, bundles)


def traced(tracer, light, direct=False) -> TracedPhotons:
    every = tracer.trace(light, range(tracer.bundles), direct=direct)
    return TracedPhotons(*(np.concatenate([getattr(bundle, name) for bundle in every]) for name in FIELDS))


FIELDS = [field.name for field in attrs.fields(TracedPhotons)]


@pytest.mark.parametrize("albedo", [GREY, (0.7, 0.5, 0.2), (0.0, 0.0, 0.0)])
def test_in_a_furnace_the_power_of_all_photons_is_that_of_the_lamp_times_the_sum_of_albedos(albedo):
    """4 pi colour (a + a^2 + ...) = 4 pi colour a / (1 - a): nothing gets out of a closed box.

    A path leaves k photons or more with the chance a^k, a the largest of the three, and its k-th
    has (a_c / a)^k of the first one's power: the variance of the sum follows. Four standard
    deviations of the mean over all paths.
    """
    tracer, albedo = tracer_of(scene_of(cube(albedo), 0.25)), np.array(albedo)
    powers = traced(tracer, POINT).powers.sum(axis=0)
    most, k = max(albedo.max(), 1e-9), np.arange(1, 60)
    for channel, (one, colour) in enumerate(zip(albedo, COLOUR, strict=True)):
        mean, share = one / (1 - one), one / most
        both = share ** (k[:, None] + k) * most ** np.maximum(k[:, None], k)
        bound = 4 * np.sqrt(max(both.sum() - mean**2, 0) / (tracer.paths * tracer.bundles))
        assert powers[channel] == pytest.approx(4 * np.pi * colour * mean, abs=4 * np.pi * colour * bound)


@pytest.mark.parametrize("height", [1.0, 1.6])
def test_the_density_of_photons_on_a_plane_under_a_point_is_the_cosine_law(height):
    """colour cos / d^2. A kernel k of radius h over photons of power p has the variance E p int k^2
    with int k^2 = 4 / (3 pi h^2), and spreads light by h^2 / 6 on each axis: bias h^2 / 12 of the
    Laplacian. Four standard deviations, the bias, and a tenth of it for what comes after it."""
    plane = scene_of([wall((0, 0, 0), (4, 0, 0), (0, 0, -4), GREY)], 0.5)
    tracer, radius = tracer_of(plane), 0.3
    photons = traced(tracer, (np.array((0.0, height, 0.0, 1.0)), (1.0, 1.0, 1.0)), direct=True)

    def law(away):
        return height / (height**2 + away**2) ** 1.5

    power, step = 4 * np.pi / (tracer.paths * tracer.bundles), 1e-3
    for away in np.linspace(0, 2, 9):
        for turn in np.linspace(0, 6, 5):
            here = np.array((away * np.cos(turn), 0, away * np.sin(turn)))
            distance = np.linalg.norm(photons.places - here, axis=1)
            found = float(photons.powers[:, 0] @ kernel(distance, radius))
            second = (law(away + step) - 2 * law(away) + law(abs(away - step))) / step**2
            first = (law(away + step) - law(abs(away - step))) / (2 * step)
            laplacian = second + (first / away if away else second)
            noise = np.sqrt(law(away) * power * 4 / (3 * np.pi * radius**2))
            bias = abs(laplacian) * radius**2 / 12
            assert found == pytest.approx(law(away), abs=4 * noise + 1.1 * bias)


def test_sun_and_sky_bring_what_falls_on_a_square():
    """A square of 2 m facing up gets colour cos times its area of a sun, and 1 for each square
    metre of a white sky. 16,000 paths, half of which come from below: 4 / sqrt(8192) = 4 %, less
    as they are spread evenly: 2 %."""
    floor = scene_of([wall((0, 0, 0), (1, 0, 0), (0, 0, -1), (0, 0, 0))], 0.5, background=WHITE_SKY)
    tracer = tracer_of(floor)
    power = traced(tracer, SUN, direct=True).powers.sum(axis=0)
    assert np.allclose(power, 4 * 0.9 / np.linalg.norm(SUN[0][:3]) * np.array(COLOUR), rtol=0.02)
    assert np.allclose(traced(tracer, None).powers.sum(axis=0), 4.0, rtol=0.02)


@pytest.mark.parametrize(("name", "time_ms"), [("lantern", 700), ("sunroom", 1000)])
def test_photons_bring_as_much_as_radiosity_finds(name, time_ms):
    """Of 16,000 photons half the number counts for the spread of paths: 2 %; and 1 % for rays."""
    scene = load_scene(name)
    transport, lamps = transport_of(scene), lamps_at(scene, time_ms * 1_000_000)
    wanted = transport.patches.areas @ transport.indirect(transport.direct(lamps))
    found = np.zeros(3)
    for light, _ in light_keys(lamps, scene.background):
        found += traced(tracer_of(scene, bundles=256), light).powers.sum(axis=0)
    assert np.allclose(found, wanted, rtol=0.03)


@pytest.mark.parametrize("radius", [0.7, 1.0, 2.0])
def test_kernels_keep_all_power_and_evenly_lit_surfaces_are_even(radius):
    """TracedPhotons spread evenly, 3x3 on a texel of half a metre. Factors are found for parts of a
    quarter of the radius and repeat over half of that at borders: there they are up to 1/8 short of
    what a kernel that is half beside the surface asks for, on a quarter of the surfaces at most."""
    scene = scene_of([*cube(), *box((-0.6, -1, -0.6), (0, 0, 0), GREY)], 0.5)
    patches = transport_of(scene).patches
    offsets = [(x, y) for x in (-1 / 3, 0, 1 / 3) for y in (-1 / 3, 0, 1 / 3)]
    places = np.concatenate([patches.at(x, y) for x, y in offsets])
    texels = np.concatenate([patches.texels + 0.5 + (x, y) for x, y in offsets])
    normals, areas = np.tile(patches.normals, (9, 1)), np.tile(patches.areas, 9) / 9
    own = of_atlas(kernel_factors(transport_of(scene), radius), texels)[:, 0]
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    same = (normals @ normals.T > 0.9) & (np.abs(((places[:, None] - places[None]) * normals).sum(axis=2)) < 0.01)
    spread = own[:, None] * (kernel(apart, radius) * same) * own[None]
    light, given = spread @ areas, areas @ spread
    assert np.abs(light - 1).mean() < 0.03 and np.abs(light - 1).max() < 0.125
    assert np.abs(given - 1).mean() < 0.03


def test_no_light_no_photons():
    room = scene_of(cube(), 0.5, [Lamp(Fixed((0, 0, 0)), (0.0, 0.0, 0.0))], WHITE_SKY)
    keys = light_keys(lamps_at(room, 0), room.background)
    (off, _), (sky, _) = keys  # a lamp that is off may be switched on: it keeps its place
    tracer = tracer_of(room, 16, 4)
    assert sky is None and not len(traced(tracer, off, direct=True))
    assert not len(traced(tracer, None)), "no light of the sky comes in"
    outside = (np.array((5.0, 0.0, 0.0, 1.0)), COLOUR)
    assert not len(traced(tracer, outside, direct=True)), "nor any through the backs of walls"
    assert not len(traced(tracer_of(scene_of([], 0.5), 16, 4), POINT, direct=True))
    assert light_keys([], WHITE_SKY) == []
