"""Photons on the wire, and the books of both sides: whatever is lost or late, the newest stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.cloudlight.photons import (
    CUBE_BYTES,
    LEAST_BUDGET,
    BundleRoom,
    BundleSender,
    Cube,
    PhotonMap,
    bundle_bytes,
    octahedral,
    packed,
    shared_exponent,
    unpacked,
)
from hmdwarp.frames.layers import Update

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


@pytest.mark.parametrize("budget", [LEAST_BUDGET, 1000, 3000, 60_000, 10**7])
def test_any_bundle_fits_a_frame(budget):
    """So none takes longer than a frame; and as few as can be: twice as many would not fit."""
    wanted = PhotonMap(budget)
    assert CUBE_BYTES + bundle_bytes(wanted.paths_of_bundle) <= budget
    assert wanted.paths_of_bundle == 256 or CUBE_BYTES + bundle_bytes(2 * wanted.paths_of_bundle) > budget
    assert wanted.bundles(opened=False) * wanted.paths_of_bundle == wanted.paths
    assert PhotonMap(budget, paths=1).bundles(opened=False) == 1


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


def test_only_what_has_changed_is_sent_and_the_oldest_first():
    net = Network(4)
    net.send([1, 1, 1, 1], 4, 0)
    assert len(net.under_way[0]) == 4
    assert not net.send([1, 1, 1, 1], 4, 1).pieces
    assert {bundle for bundle, _ in net.send([1, 2, 1, 2], 4, 2).pieces} == {1, 3}
    first = [bundle for bundle, _ in net.send([3, 3, 3, 3], 2, 3).pieces]
    assert set(first) == {0, 2}, "those that were sent longest ago"


def test_an_empty_bundle_is_sent_only_where_it_replaces_something():
    net = Network(2)
    assert not net.send([0, 0], 2, 0).pieces
    assert net.send([0, 4], 2, 1).pieces == ((1, 1),)
    assert net.send([0, 0], 2, 2).pieces == ((1, 2),)
    assert not net.send([0, 0], 2, 3).pieces


def test_ten_minutes_take_no_more_memory_than_ten_seconds():
    """At 20 frames a second over a bad link with a round trip of half a second."""
    chance, net = np.random.default_rng(2), Network(16)
    remembered = []
    for now in range(12_000):
        update = net.send([1 + now % 200] * 16, 4, now)
        arrives = chance.random() > 0.1
        net.book.heard(update, arrives, now + 10)
        if arrives:
            net.receive(-1)
        net.under_way.clear()
        remembered.append(net.book.remembered)
    assert max(remembered[200:]) <= 11 * 4
    assert len(net.room.words()) <= 16 * 200
