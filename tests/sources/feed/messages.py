"""Messages of the feed, one of each kind, for tests."""

from __future__ import annotations

import attrs
import numpy as np

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.feed.message import DEPTH_EXACT, HEVC, Ask, FrameMessage, token_of
from hmdwarp.sources.feed.parts import Wanted, packed

HEAD = Pose((0.1, 1.6, -1e-9), (0.1, 0.2, 0.3, 0.9))
VIEWS = tuple(View(HEAD @ Pose((x, 0, 0)), Fov(-0.8, 0.7, -0.6, 0.65), Pose((x, 0, 0))) for x in (-0.03, 0.03))
RNG = np.random.default_rng(1)
ASK = Ask(7, -5, 2**62, 12, 6, (4, 3), HEAD, VIEWS, token_of("secret"))
COLOURS = tuple(RNG.random((3, 4, 4)).astype(np.float16) for _ in VIEWS)
FRAME = FrameMessage(7, 1, 2, 3, 4, 5, VIEWS, COLOURS, tuple(RNG.random((3, 4)).astype(np.float32) for _ in VIEWS))
BYTES = attrs.evolve(FRAME, colours=tuple(RNG.integers(0, 256, (3, 4, 4), np.uint8) for _ in VIEWS))
_CODED = {"colours": (b"colour", b"of two"), "inverse_depths": (b"depth", b""), "colour": HEVC, "depth": DEPTH_EXACT}
CODED = attrs.evolve(FRAME, **_CODED, coded_size=(4, 3), begins=False, place=9)
WANTED = Wanted((("velocity", 1), ("peeled", 2)), (4, 2), tuple(view.fov for view in VIEWS))
OF_EYE = {
    "velocity": [RNG.random((3, 4, 4)).astype(np.float16)],
    "ids": [RNG.integers(0, 9, (3, 4), np.uint16), RNG.random((9, 16))],
    "peeled": [packed(RNG.random((3, 4, 4)).astype(np.float16)), packed(RNG.random((3, 4)).astype(np.float32))],
}
LAYERED = attrs.evolve(FRAME, layers=(OF_EYE, {name: OF_EYE[name] for name in ("ids",)}))
