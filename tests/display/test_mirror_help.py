"""The window beside a headset: a study's help is there beside a question alone."""

from __future__ import annotations

import subprocess
import sys

import needs

from .programs import ROOT
from .virtual_screen import PATIENCE_S, VirtualScreen

PROGRAM = """
import glfw
from hmdwarp.display import CONTROLS as LIVE
from hmdwarp.display.openxr.mirror_window import Mirror
from hmdwarp.display import Presenter
from hmdwarp.gpu.context import Gpu
from hmdwarp.study.dialogs.dialog_panels import CONTROLS
from hmdwarp.study.dialogs.dialog_panels import message_panel

class Noting(Presenter):
    def notice(self, label):
        self.last = label
        return super().notice(label)

def laid(controls, *does):
    mirror = Mirror(controls)
    gpu = Gpu(mirror.gl)
    presenter = Noting(gpu)
    for key in does:
        if key in ("H", "ESCAPE"):
            mirror._key(None, getattr(glfw, f"KEY_{key}"), 0, glfw.PRESS, 0)
            continue
        mirror._drawn_ns = 0  # due
        mirror.show(presenter, None, key)
        is_help = isinstance(presenter.last, str) and "\\t" in presenter.last
        print("help" if is_help else "panel" if presenter.last else "nothing", end=" ")
    print()
    presenter.close(); gpu.close(); mirror.close()

panel = message_panel("Ready?", "Sit comfortably.", "Enter: begin")
laid(CONTROLS, "", "H", "", panel, "H", panel, "", panel)
laid(LIVE, "", "H", "", "H", "", "H", "", "ESCAPE", "")
"""


@needs.programs("Xvfb")
def test_in_a_study_no_help_lies_over_what_the_headset_shows(tmp_path):
    with VirtualScreen(tmp_path) as screen:
        environment = {**screen.environment, "PYTHONPATH": str(ROOT), "PYGLFW_LIBRARY_VARIANT": "x11"}
        command = [sys.executable, "-W", "error", "-c", PROGRAM]
        done = subprocess.run(command, check=False, capture_output=True, text=True, env=environment, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr
    of_study, live = done.stdout.splitlines()
    assert of_study.split() == ["nothing", "nothing", "panel", "help", "nothing", "panel"]
    assert live.split() == ["nothing", "help", "nothing", "help", "nothing"]
