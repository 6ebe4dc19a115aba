"""What a real runtime reports, as a headset's file."""

from __future__ import annotations

import subprocess
import sys

from hmdwarp.headsets import load_headset


def test_the_connected_headset_becomes_a_file(monado, no_screen, tmp_path):
    out = tmp_path / "simulated.toml"
    asked = [sys.executable, "-m", "hmdwarp", "headset", "from-openxr", "--out", str(out)]
    subprocess.run(asked, check=True, timeout=120)
    found = load_headset(str(out))
    # Monado's simulated HMD: two eyes that look straight ahead.
    assert "Monado" in found.source and min(found.eye_size_px) > 100 and found.refresh_hz > 10
    assert max(map(abs, found.cants_deg)) < 1 and found.overlap_deg > 30
    # It has a mask too: a triangle in each corner, an eighth of the view along each side.
    assert all(0.02 < eye.hidden_share < 0.05 for eye in found.eyes)
