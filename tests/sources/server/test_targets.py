"""What a burst of frames leaves behind: as many targets as are used, and pictures as before."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download
from hmdwarp.sources.server import Server
from hmdwarp.sources.server.targets import IDLE_AFTER, MOST_IDLE, MOST_IDLE_BYTES

SIZE, VIEW = (256, 256), View(Pose((0, 1.6, 0)), Fov.symmetric(1.0, 1.0))


@pytest.fixture
def server(serve):
    made = serve("planes")
    yield made


def burst(server: Server, number: int) -> None:
    """Draw so many frames before the first is taken back."""
    frames = []
    for each in range(number):
        frames.append(server.draw_frame([VIEW], each, SIZE))
        # llvmpipe keeps what it draws at the same time for as long as it likes.
        server.gpu.gl.finish()
    for frame in frames:
        server.recycle(frame)


def rest(server: Server, hand_outs: int = 2 * IDLE_AFTER) -> None:
    """Hand out one target at a time; what a hand-out needed stays for IDLE_AFTER more."""
    pool = server.pool(SIZE)
    for _ in range(hand_outs):
        pool.release(pool.acquire())


def test_targets_of_a_burst_are_freed_and_the_others_keep_their_pictures(server):
    pool, held = server.pool(SIZE), server.draw_frame([VIEW], 0, SIZE)
    picture = download(held.eyes[0].colour)
    burst(server, 16)
    assert (pool.live, pool.made) == (1, 17)
    rest(server)
    assert (pool.live, pool.made) == (1, 2)
    np.testing.assert_array_equal(download(held.eyes[0].colour), picture)
    # GL gives names of freed textures to new ones, which need framebuffers of their own.
    frames = [server.draw_frame([VIEW], each, SIZE) for each in range(16)]
    for frame in frames:
        np.testing.assert_array_equal(download(frame.eyes[0].colour), picture)
        server.recycle(frame)
    server.recycle(held)


def test_of_what_many_sizes_needed_a_bounded_part_is_kept(server):
    """As `serve` trims, after each frame that a client requests."""
    held = server.draw_frame([VIEW], 0, SIZE)
    picture = download(held.eyes[0].colour)
    server.recycle(held)
    sizes = [(8 + number, 9) for number in range(3 * MOST_IDLE)] + [(1024, 256 + number) for number in range(24)]
    for size in [*sizes, SIZE]:
        frame = server.draw_frame([VIEW], 0, size, needs=Needs(velocity=1, overlay=1))
        server.recycle(frame)
        server.trim()
        assert len(server._pools) <= MOST_IDLE + 8
        assert sum(pool.bytes for pool in server._pools.values()) <= MOST_IDLE_BYTES + 6 * 8 * size[0] * size[1]
        assert len(server._framebuffers._depth) <= MOST_IDLE + 1
    np.testing.assert_array_equal(download(frame.eyes[0].colour), picture)
