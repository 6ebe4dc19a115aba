"""A session of a study in a headset that goes away in the middle of a trial.

A clear line, nothing lost, and the trial is shown again.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from study import tiny

from hmdwarp.errors import InputError
from hmdwarp.study.store import Contents, Store

from .live_runs import LONG_S
from .monado import UNSEEN, WOBBLING

pytestmark = pytest.mark.usefixtures("no_screen")


def contents(folder: Path) -> Contents | None:
    if not (folder / "study.sqlite3").exists():
        return None
    try:
        with Store(folder) as store:
            return store.contents()
    except InputError:  # the file is there, what it holds is not yet
        return None


def until_showing(folder: Path, key: str, process: subprocess.Popen) -> None:
    until = time.monotonic() + LONG_S
    while not ((now := contents(folder)) and any(showing.key == key for showing in now.showings)):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until, f"{key} was not shown within {LONG_S:g} s"
        time.sleep(0.02)


def test_the_headset_goes_in_mid_trial(runtime, tmp_path):
    study, model = tiny.write(tmp_path, pause=0.0, again=0.0, missing=0.0)
    text = study.read_text().replace("rate = 20\n", "reconnect = 1\n").replace("seconds = 0.2", "seconds = 5")
    # Two of its conditions: one trial before the one that is cut, and none after it.
    lines = text[: text.index("[[family]]")].splitlines()
    study.write_text("\n".join(line for line in lines if '"late"' not in line and '"turned"' not in line))
    command = [
        sys.executable, "-m", "hmdwarp", "study", "run", str(study), "--participant", "one", "--simulate",
        str(model),
    ]  # fmt: skip
    command += ["--source", "openxr", "--console", "none"]
    monado = runtime(WOBBLING, UNSEEN)
    monado.start()
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        try:
            until_showing(tmp_path / "tiny-simulated-data", "trial/2", process)
            time.sleep(2.0)  # its wait before the first picture is over
            monado.kill()
            said = process.communicate(timeout=LONG_S)[0]
        finally:
            process.kill()
    assert process.returncode == 3, said
    assert "--resume" in said and "Traceback" not in said
    before = contents(tmp_path / "tiny-simulated-data")
    assert [session.status for session in before.sessions] == ["interrupted"]
    assert [showing.complete for showing in before.showings if showing.key == "trial/2"] == [False]
    monado.start()
    done = subprocess.run(
        [*command, "--resume"], check=False, capture_output=True, text=True, timeout=2 * LONG_S, env=os.environ
    )
    assert done.returncode == 0, done.stdout + done.stderr
    after = contents(tmp_path / "tiny-simulated-data")
    assert [session.status for session in after.sessions] == ["complete"]
    assert [showing.complete for showing in after.showings if showing.key == "trial/2"] == [False, True]
    assert after.answers[: len(before.answers)] == before.answers
    assert len({answer.key for answer in after.answers}) == len(after.answers)
