"""What a plan comes to: time, balance, and what to think of. How it is printed: golden/."""

from __future__ import annotations

from itertools import product

from hmdwarp.study.design import design_as_json, design_from_text, load_design, notes, rows_for
from hmdwarp.study.design.orders import presented
from hmdwarp.study.design.plan_text import balance, least_participants, session_phases
from hmdwarp.study.statistics import smallest_p

from ..plans import text_of


def design(*changes: tuple[str, str]):
    return design_from_text(text_of("whole", *changes), "study.toml")


def test_trials_until_done_take_at_most_their_longest_time():
    until = ("seconds = 20\n", 'seconds = "until done"\nlongest = 90\n')
    plan = design(until)
    phases = {phase.name: phase for phase in session_phases(plan, "run-1")}
    assert phases["trials"].content.startswith("6 until done, at most 90 s, each rated")
    assert phases["trials"].at_most and not phases["practice"].at_most
    assert phases["trials"].seconds >= 6 * 90
    assert design_as_json(plan)["trial_until_done"]
    long = design(("seconds = 20\n", 'seconds = "until done"\n'))
    assert long.seconds == 600
    assert any("at most about" in note and "a shorter longest" in note for note in notes(long))


def by_enumeration(n: int) -> float:
    """By going through all 2^n ways n differences can turn out. How many are as extreme as all in
    one direction.
    """
    sums = [sum(rank for rank, sign in enumerate(signs, 1) if sign) for signs in product((0, 1), repeat=n)]
    most = n * (n + 1) // 2
    return sum(abs(total - most / 2) >= most / 2 for total in sums) / len(sums)


def test_with_fewer_people_nothing_can_be_found():
    for n in range(1, 9):
        assert smallest_p(n) == by_enumeration(n)
    for comparisons in (1, 3, 6, 20):
        need = least_participants(comparisons)
        assert comparisons * smallest_p(need) <= 0.05 < comparisons * smallest_p(need - 1)


SAME_FRAMES = ("[trial]", 'guard = 1.2\npredict = "cautious"\n[trial]')  # [common] stands before it


def test_a_comparison_of_several_settings_names_them_and_the_lines_that_leave_one():
    def about(*changes: tuple[str, str]) -> list[str]:
        return [note for note in notes(design(*changes)) if "several settings differ" in note]

    (note,) = about()
    assert "part run-1: 'warped-200' over 'late-200'" in note
    assert 'warp ("mesh" and "none"), guard (1.2 and 1), predict ("cautious" and "none")' in note
    assert 'write guard = 1.2 and predict = "cautious" into [common]' in note
    assert not about(SAME_FRAMES)
    # What the plan sets differently has no line that mends it.
    (note,) = about(SAME_FRAMES, ('latency = 200\nwarp = "mesh"', 'latency = 300\nwarp = "mesh"'))
    assert 'latency (300 and 200), warp ("mesh" and "none"); which' in note and "[common]" not in note
    for name in ("quick", "thesis", "thesis-as-was"):
        assert not [note for note in notes(load_design(name)) if "several settings differ" in note]


def test_a_sound_plan_leaves_little_to_think_of():
    reference = ("reference = true", 'warp = "none"\nreference = true')
    sound = design(reference, ('["grade", "acr"]', '["grade"]'), SAME_FRAMES)
    assert len(notes(sound)) == 3  # run-1 has an odd number; run-2 has no reference, and nothing is compared there


def test_breaks_come_between_trials():
    told = {phase.name: phase for phase in session_phases(design(("every = 6", "every = 2")), "run-1")}
    assert (told["breaks"].steps, told["breaks"].seconds) == (2, 60)
    assert told["breaks"].content.endswith("after every 2 trials")
    each = {phase.name: phase for phase in session_phases(design(("every = 6", "every = 1")), "run-1")}
    assert each["breaks"].content.endswith("after every trial")


def test_balance_is_counted():
    plan, fixed = design(), design(('order = "williams"', 'order = "fixed"'))
    found = balance(rows_for(plan, "run-1"), presented(plan, "run-1"))
    assert (found.orders, found.repeated, found.seams) == (6, 0, (1, 1))  # 3 conditions, 2 repeats
    assert found.places == found.pairs == (4, 4)
    found = balance(rows_for(fixed, "run-1"), presented(fixed, "run-1"))
    assert (found.orders, found.places, found.pairs, found.seams) == (1, (0, 2), (0, 2), (0, 1))
