"""Holes are counted exactly, and told a refresh later."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.gpu import Canvas, upload
from hmdwarp.run import HoleCounter


@pytest.fixture
def counter(gpu):
    made = HoleCounter(gpu)
    yield made
    made.close()


def picture(gpu, seed: int, size: tuple[int, int], share: float) -> tuple[Canvas, float]:
    """A canvas and the share of it that is holes.

    Alpha that is not 0 is as small as a half can be: it counts as covered.
    """
    w, h = size
    rng = np.random.default_rng(seed)
    image = rng.random((h, w, 4)).astype(np.float16)
    image[..., 3] = np.where(rng.random((h, w)) < share, 0, rng.choice(np.array([6e-8, 0.5, 1], np.float16), (h, w)))
    canvas = Canvas(gpu.gl, size)
    upload(canvas.texture, image)
    return canvas, np.count_nonzero(image[..., 3] == 0) / (w * h)


@pytest.mark.parametrize("size", [(1, 1), (63, 7), (64, 8), (65, 9), (131, 97)])
@pytest.mark.parametrize("share", [0, 0.01, 0.5, 1])
def test_every_hole_is_counted_once(gpu, counter, size, share):
    canvas, wanted = picture(gpu, 1, size, share)
    counter.count([canvas])
    counter.count([canvas])
    assert counter.shares() == (wanted,)


def test_it_tells_the_refresh_before_of_each_eye(gpu, counter):
    """Of pictures that change, of eyes of two sizes, of one eye instead of two."""
    rounds = [[picture(gpu, 10 * n + eye, (40 + n, 30 - eye), 0.1 * n) for eye in range(2)] for n in range(5)]
    rounds.append([picture(gpu, 99, (20, 20), 0.3)])
    assert counter.shares() is None
    before = None
    for eyes in rounds:
        counter.count([canvas for canvas, _ in eyes])
        assert counter.shares() == before
        assert counter.shares() == before  # may be asked again
        before = tuple(share for _, share in eyes)


def test_a_count_outlives_its_picture(gpu, counter):
    """A change of the size frees the old pictures at once."""
    old, wanted = picture(gpu, 3, (50, 20), 0.2)
    counter.count([old])
    old.release()
    new, _ = picture(gpu, 4, (20, 50), 0.9)
    counter.count([new])
    assert counter.shares() == (wanted,)
