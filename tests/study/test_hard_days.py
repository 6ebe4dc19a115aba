"""What a laboratory does to a session, through the real command."""

from __future__ import annotations

from datetime import timedelta

import pytest

from hmdwarp.study.design import Show, load_design, steps_of
from hmdwarp.study.store import INTERRUPTED, SIMULATED, Store

from . import tiny
from .store.sessions import SetClock

pytestmark = pytest.mark.slow


def test_a_session_is_resumed_on_a_day_before_it_began(tmp_path):
    """As after a machine's clock was mended: no onset is negative, and it is told."""
    study, model = tiny.write(tmp_path)
    tiny.ran(*tiny.session(study, model, "other"))
    with Store(tmp_path / "tiny-simulated-data", clock=SetClock()) as store:
        store._clock.instant += timedelta(days=365 * 70)
        design = load_design(str(study))
        session = store.begin(design, None, "one", SIMULATED)
        step = next(step for step in steps_of(design, session.order, session.part) if not isinstance(step, Show))
        store.finish_step(session, step.key)
        store.end(session, INTERRUPTED)
    said = tiny.program(*tiny.session(study, model, "one", "--resume"))
    assert said.returncode == 0, said.stderr
    assert "set back by" in said.stdout and "onsets count" in said.stdout
    with Store(tmp_path / "tiny-simulated-data") as store:
        contents = store.contents()
    mine = {session.id for session in contents.sessions if session.code == "one"}
    onsets = [showing.actual.get("onset_s") for showing in contents.showings if showing.session in mine]
    onsets = [onset for onset in onsets if onset is not None]  # a machine with other work shows no picture in 0.2 s
    assert onsets and 0 <= min(onsets) <= max(onsets) < 1000 and onsets == sorted(onsets)
