"""A small study with a real store: two people, a third who withdraws, and a pilot."""

from __future__ import annotations

import copy
import functools
import shutil
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from hmdwarp.poses import PoseTrack
from hmdwarp.poses.writing import write_native
from hmdwarp.study.design import design_from_text
from hmdwarp.study.store import PERSON, PILOT, Store

from ..made_up import LATE_OR_WARPED
from ..store.sessions import SetClock, go_through

NASTY = 'says "ouch"\tand;\nthen, näïve – \u2028 =1+1 🙂 Maria Withdrawn'


# A clock on a day that must be nowhere in an export; two seconds pass with every look.
day = functools.partial(SetClock, datetime(2031, 7, 23, 16, 41, 7, tzinfo=UTC), 2)


def write_trace(path: Path, seed: int, samples: int = 40) -> PoseTrack:
    """A head that turns and walks, at about 90 Hz, with a clock that begins anywhere."""
    rng = np.random.default_rng(seed)
    times = 10**15 * (seed + 1) + np.cumsum(rng.integers(10_500_000, 11_700_000, samples))
    turn = np.linspace(0, 0.5, samples)
    quaternions = np.stack([0 * turn, np.sin(turn / 2), 0 * turn, np.cos(turn / 2)], axis=1)
    position = rng.normal(0, 0.01, (samples, 3)) + (0, 1.6, 0)
    track = PoseTrack(times, position, quaternions, origin=f"Recorder of {path.stem}", notes=("2031-07-23",))
    with path.open("w", encoding="utf-8") as stream:
        write_native(track, stream)
    return track


def sit(store: Store, design, code: str, origin: str = PERSON, seed: int = 0, until: int | None = None):
    """A session: every answer is told by the seed. until: trials before it is stopped."""
    session = store.begin(
        design, None, code, origin, facts={"hmdwarp": "0.0", "headset": "test-hmd", "trace": f"secret-of-{code}"}
    )
    rng = np.random.default_rng(seed)

    def value(step):
        is_rating, values = step.scale.kind == "rating", step.scale.values()
        if is_rating and (step.trial, seed) == (2, 1):
            return None
        one = values[rng.integers(len(values))]
        return (one, step.scale.least) if is_rating and step.trial == 1 else one

    def actual(step):
        return {
            "latency_ms_median": 401.5 + step.trial, "pictures": 90, "seconds": 1.5, "hole_share_mean": None,
            "warp": "forward", "size": "96x120",
        }  # fmt: skip

    def trace(path, step):
        write_trace(path, 100 * seed + step.trial)

    go_through(store, session, value, trace, of=design, until=99 if until is None else until, actual=actual)
    store.record(session, "remark", "trial/1", by="experimenter", text=f"{NASTY} {code}")
    complete = until is None
    return store.end(
        session, "complete" if complete else "stopped", why="" if complete else "asked for by the participant"
    )


@pytest.fixture(scope="session")
def design():
    return design_from_text(LATE_OR_WARPED, "late.toml")


@pytest.fixture(scope="session")
def kept(tmp_path_factory, design):
    """The folder of the store, closed, and its clock."""
    folder, clock = tmp_path_factory.mktemp("kept") / "data", day()
    with Store(folder, create=True, clock=clock) as made:
        sit(made, design, "Alpha-1", seed=1)
        sit(made, design, "Beta-2", seed=2, until=2)
        sit(made, design, "Gamma-3", seed=3)
        sit(made, design, "Pilot-4", PILOT, seed=4)
    return folder, clock


@pytest.fixture
def store(tmp_path, kept):
    folder, clock = kept
    shutil.copytree(folder, tmp_path / "data")
    with Store(tmp_path / "data", clock=copy.copy(clock)) as made:
        yield made
