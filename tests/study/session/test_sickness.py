"""The stop rule: what it says of answers. What becomes of a session: test_transcripts.py."""

from __future__ import annotations

import attrs
from together import together

from hmdwarp.study.design import Sickness
from hmdwarp.study.scales import load_scale
from hmdwarp.study.session.runner import counting, why_sick
from hmdwarp.study.store import Answer

FMS = load_scale("fms")
WORSE_BELOW = attrs.evolve(FMS, low_is_good=False)  # the same with 0 as the worst


def answers(*values: float | None) -> list[Answer]:
    return [
        Answer(trial, 1, f"trial/{trial}/fms/fms", 1, "trial", trial, "fms", "fms", value, 1.0, "participant", "")
        for trial, value in enumerate(values, 1)
    ]


RULES = [  # scale, answers, stop_at, rise, whether the session ends
    (FMS, (), 15, None, False),
    (FMS, (14,), 15, None, False),
    (FMS, (15,), 15, None, True),
    (FMS, (15, 14), 15, None, False),  # one that was corrected at the next question
    (FMS, (None,), 15, None, False),
    (FMS, (15, None), 15, None, True),  # "cannot say" decides nothing
    (FMS, (20,), None, None, False),
    (FMS, (2, 7), None, 5, True),
    (FMS, (2, 6), None, 5, False),
    (FMS, (7, 2), None, 5, False),
    (FMS, (None, 2, 7), None, 5, True),
    (WORSE_BELOW, (5,), 5, 4, True),
    (WORSE_BELOW, (6,), 5, 4, False),
    (WORSE_BELOW, (18, 14), 5, 4, True),
    (WORSE_BELOW, (14, 18), 5, 4, False),
]


@together("scale, values, stop_at, rise, is_sick", RULES)
def test_the_rule_ends_a_session(scale, values, stop_at, rise, is_sick):
    assert bool(why_sick(Sickness(scale, stop_at=stop_at, rise=rise), answers(*values))) is is_sick


def test_answers_after_all_trials_and_other_scales_end_nothing():
    afterwards = attrs.evolve(answers(18)[0], key="after/fms/fms", phase="after", trial=0)
    assert not why_sick(Sickness(FMS, stop_at=15), [*answers(3), afterwards])
    assert why_sick(Sickness(FMS, stop_at=15), [*answers(16), afterwards])
    assert why_sick(None, answers(20)) == ""
    assert why_sick(Sickness(FMS, stop_at=1), [attrs.evolve(answers(20)[0], scale="grade")]) == ""


def test_the_newest_revision_counts_in_the_place_of_the_first():
    first, second = answers(16, 3)
    corrected = attrs.evolve(first, id=3, revision=2, value=1.0)
    assert list(counting([first, second, corrected]).values()) == [corrected, second]
    assert why_sick(Sickness(FMS, rise=2), [first, second, corrected])
