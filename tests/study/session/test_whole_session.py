"""A whole session: when what is shown, what is kept of it, and what of it nobody may see.

What happens in it, in order: transcripts/whole.txt.
"""

from __future__ import annotations

import getpass
import re
import socket

import numpy as np
import pytest
from run.offscreen import PERIOD_NS, RATE_HZ

from hmdwarp.poses import load_trace
from hmdwarp.study.actual import FLAGS, NUMBERS, TEXTS
from hmdwarp.study.session import runner

from .conftest import LEAD_S, hurry
from .sessions import LATENCIES_MS, NAMES, contents, run, study, whole

PERIOD_MS = PERIOD_NS * 1e-6


@pytest.fixture(scope="module")
def one(gpu, tmp_path_factory):
    """A session with everything in it, and what came of it."""
    with pytest.MonkeyPatch.context() as patch:
        hurry(patch)
        path = whole(tmp_path_factory.mktemp("whole"))
        ran = run(patch, gpu, path)
    assert ran.error is None
    return path, ran


def test_every_trial_shows_its_planned_condition(one):
    """A frame is shown at the first refresh at or after its latency. A refresh is shown two periods
    after it is asked for. So a frame's age lies within one period above the larger of the two.
    """
    path, _ = one
    planned = {**dict(zip(NAMES, LATENCIES_MS, strict=True)), "practice": 0.0}
    showings = contents(path).showings
    assert sorted(showing.condition for showing in showings) == sorted([*NAMES, "practice"])
    for showing in showings:
        actual, latency = showing.actual, max(planned[showing.condition], 2 * PERIOD_MS)
        assert {*NUMBERS, *FLAGS, *TEXTS} == set(actual)
        assert latency - 1e-6 <= actual["latency_ms_median"] <= latency + PERIOD_MS + 1e-6
        assert actual["latency_ms_sd"] < 1e-6  # the display's clock is even
        assert actual["seconds"] == pytest.approx(0.1, abs=PERIOD_MS * 1e-3 * 1.01)
        assert actual["rate_hz"] == pytest.approx(RATE_HZ)
        assert actual["missed"] == actual["lost_s"] == actual["tracking_lost_share"] == 0
        assert (actual["source"], actual["scene"], actual["size"]) == ("offscreen", "planes", "96x120")
        assert actual["warp"] == ("rotation" if showing.condition == NAMES[1] else "none")
        assert 0 <= actual["hole_share_mean"] <= 1
        assert actual["angular_speed_deg_s_median"] > 0


def test_trials_carry_when_they_began(one):
    """By the display's clock."""
    path, ran = one
    shown = {showing.key: showing.actual for showing in contents(path).showings}
    pictures = [at_ns for at_ns, is_picture, _ in ran.display.handed if is_picture]
    first = [b for a, b in zip([0, *pictures], pictures, strict=False) if b - a > 1e8]
    onsets = [shown[key]["onset_s"] for key in ("practice", "trial/1", "trial/2")]
    assert np.diff(onsets) == pytest.approx(np.diff(first) * 1e-9, abs=2e-3)
    assert onsets[0] > 0.2  # consent and the black before it


def test_a_pipeline_that_takes_long_to_build_does_not_tell_itself_by_the_wait(monkeypatch, gpu, tmp_path):
    """As long as building takes no longer than LEAD_S, from the panel to the first picture it is
    equally long.
    """

    class Slow(runner.PipelineHost):
        def __init__(self, display, options, scene) -> None:
            super().__init__(display, options, scene)
            if options.warp == "rotation":
                display._at_ns += round(0.6 * LEAD_S * 1e9)

    monkeypatch.setattr(runner, "PipelineHost", Slow)
    handed = run(monkeypatch, gpu, study(tmp_path)).display.handed
    waits = []
    for number in (1, 2):
        title = f"Trial {number} of 2"
        begun = next(k for k, (*_, label) in enumerate(handed) if getattr(label, "title", "") == title)
        first = next(k for k in range(begun, len(handed)) if handed[k][1])
        waits.append((handed[first][0] - handed[begun][0]) * 1e-6)
    assert waits[0] == pytest.approx(waits[1], abs=PERIOD_MS)


def test_no_title_panel_or_line_shows_the_condition(one):
    """Neither names nor settings stand in a title, on a panel or on the console."""
    _, ran = one
    titles = set(ran.display.titles)
    assert "hmdwarp - study small - trial 1 of 2" in titles
    seen = [*titles, *map(repr, ran.display.panels), *map(repr, ran.console.states), *ran.console.said, *ran.said]
    latencies = [rf"\b{latency}\b" for latency in LATENCIES_MS]
    told = re.compile("|".join([*NAMES, *latencies, "rotation", "warp", "latency", "planes"]))
    for text in seen:
        assert not told.search(text.replace("hmdwarp", "")), text


def test_every_recording_has_a_pose_for_each_picture_and_begins_with_the_same_motion(one):
    path, _ = one
    tracks = []
    for showing in contents(path).showings:
        file = path.with_name("small-data") / "traces" / showing.trace
        tracks.append(load_trace(str(file)).track)
        assert len(tracks[-1]) == showing.actual["pictures"]
        assert "hmdwarp study" in file.read_text(encoding="utf-8").partition("\n#")[2]
    for other in tracks[1:]:
        assert np.allclose(tracks[0].position_m, other.position_m, atol=1e-9)


def test_facts_of_the_machine_are_kept_without_personal_names(one):
    path, _ = one
    facts = contents(path).sessions[0].facts
    assert facts["packages"]["numpy"] == np.__version__
    assert facts["gpu"]["renderer"]
    assert facts["seed"] == 5
    assert not {socket.gethostname(), getpass.getuser()} & set(re.findall(r"[\w.-]+", repr(facts)))
