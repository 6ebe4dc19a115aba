"""Hypothesis strategies that several folders share: poses, fields of view, sizes.

Everyday values and the bad ones nearby.
"""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

from hmdwarp.geometry import Fov, Pose, View

METRES = st.floats(-10, 10)
FAR_ORIGIN = st.sampled_from([0.0, 1.0, -1e3, 1e6, -1e6])


def vectors(values: st.SearchStrategy[float] = METRES) -> st.SearchStrategy[tuple[float, float, float]]:
    """Three numbers."""
    return st.tuples(values, values, values)


def _turned(axis: tuple[float, float, float], angle: float) -> np.ndarray:
    axis = np.array(axis) + (0, 0, 1e-9)  # so that (0, 0, 0) has a direction
    return np.append(axis / np.linalg.norm(axis) * math.sin(angle / 2), math.cos(angle / 2))


# Uniform on the sphere of quaternions, and near the bad places: no turn, half turns (w = 0), both
# signs of q.
UNIFORM_QUATERNIONS = st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).normal(size=4))
SMALL_TURNS = st.builds(_turned, vectors(), st.sampled_from([0.0, 1e-300, 1e-12, 1e-8, 1e-4]))
HALF_TURNS = st.builds(_turned, vectors(), st.sampled_from([math.pi, math.pi - 1e-8, math.pi + 1e-8, 2 * math.pi]))
QUATERNIONS = st.one_of(UNIFORM_QUATERNIONS, SMALL_TURNS, HALF_TURNS)


def poses(
    metres: st.SearchStrategy[float] = METRES, quaternions: st.SearchStrategy[np.ndarray] = QUATERNIONS
) -> st.SearchStrategy[Pose]:
    """Poses with each coordinate from `metres`."""
    return st.builds(Pose, vectors(metres), quaternions)


def _fov(left: float, right: float, down: float, up: float) -> Fov:
    return Fov(-left, right, -down, up)


# Each side 10 to 65 degrees from the axis: what headsets have; and views that do not hold their own
# axis, as in tiled displays.
FOVS = st.one_of(
    st.builds(_fov, *[st.floats(math.radians(10), math.radians(65))] * 4),
    st.builds(
        lambda start, span: Fov(start, start + span, start / 2, start / 2 + span),
        st.floats(0.05, 0.6),
        st.floats(0.2, 0.8),
    ),
)
SIZES = st.tuples(st.integers(1, 4096), st.integers(1, 4096))


def views(metres: st.SearchStrategy[float] = METRES) -> st.SearchStrategy[View]:
    """One eye anywhere, turned anyhow."""
    return st.builds(View, poses(metres), FOVS)


@st.composite
def neighbouring_views(draw: st.DrawFn, origins: st.SearchStrategy[float] = FAR_ORIGIN) -> tuple[View, View]:
    """Two eyes a plausible head motion apart, near the world's origin or 1e6 m from it, with fields
    of view of their own.
    """
    origin = np.array(draw(vectors(origins)))
    step = np.array(draw(vectors(st.one_of(st.just(0.0), st.floats(-0.3, 0.3)))))
    base = Pose(origin, draw(QUATERNIONS))
    turn = Pose((0, 0, 0), _turned(draw(vectors()), draw(st.one_of(st.just(0.0), st.floats(-0.5, 0.5)))))
    moved = Pose(origin + step, (base @ turn).orientation_xyzw)
    return View(base, draw(FOVS)), View(moved, draw(FOVS))
