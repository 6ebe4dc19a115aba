"""What `hmdwarp doctor` says of a real runtime, without starting anything."""

from __future__ import annotations

import subprocess
import sys

from .monado import UNSEEN, WOBBLING


def lines() -> dict[str, str]:
    """By the name of what was looked at."""
    done = subprocess.run(
        [sys.executable, "-m", "hmdwarp", "doctor"], check=True, capture_output=True, text=True, timeout=120
    )
    rows = [line for line in done.stdout.splitlines() if line[:1].isalpha()]
    return {row[10:26].strip(): row for row in rows}


def test_before_and_while_a_service_runs(runtime, no_screen):
    monado = runtime(WOBBLING, UNSEEN)
    down = lines()
    assert "service does not answer" in down["OpenXR runtime"]
    assert down["live"].startswith("optional") and "no display" in down["live"]
    monado.start()
    up = lines()
    assert (
        up["OpenXR runtime"].startswith("ok")
        and "Monado" in up["OpenXR runtime"]
        and "Simulated HMD" in up["OpenXR runtime"]
    )
    assert up["live"].startswith("ok") and "takes the headset" in up["live"]
