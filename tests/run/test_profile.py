"""replay --profile: where the CPU time of a replay goes."""

from __future__ import annotations

import json
import resource
import time

from replays import small

from hmdwarp.run import replay
from hmdwarp.run.profile import ALIKE, COMPARED, DRAWING, SET_UP, SHOWING, TRUTH, WORKERS, Profile


def burn(seconds: float) -> None:
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def test_a_part_within_another_is_not_in_the_other():
    """And what no part has is in the one that was entered."""
    profile = Profile()
    before = profile.seconds()[SET_UP]
    profile.enter("beside")
    with profile.part(SHOWING):
        burn(0.02)
        with profile.stage("warp"):
            burn(0.05)
    with profile.part(TRUTH), profile.stage("warp"):
        burn(0.03)
    found = profile.seconds()
    assert found["warp"] >= 0.05 and found[SHOWING] >= 0.02 and found[TRUTH] >= 0.03
    assert sum(found.values()) - found[WORKERS] >= 0.1 + before
    assert {event["name"] for event in json.loads(profile.events())} == {SHOWING, "warp", TRUTH}


def test_a_replay_says_where_its_time_went(tmp_path):
    """The parts sum to what the process and its children took."""
    said: list[str] = []
    replay(small(tmp_path / "out", profile=True, against="none"), say=said.append)
    lines = [line.split(" | ") for line in said[-1].splitlines()[2:]]
    seconds = {line[0].removeprefix("| "): float(line[1]) for line in lines}
    assert {SET_UP, DRAWING, "warp", TRUTH, COMPARED, ALIKE, WORKERS} <= set(seconds)
    whole = seconds.pop("all")
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert whole <= time.process_time() + children.ru_utime + children.ru_stime + 0.01
    assert abs(sum(seconds.values()) - whole) <= 0.006 * len(seconds)  # each is rounded to 0.01
    events = json.loads((tmp_path / "out" / "profile.json").read_text(encoding="utf-8"))
    assert {event["name"] for event in events} >= {DRAWING, "warp", TRUTH, ALIKE} and events[0]["dur"] > 0
