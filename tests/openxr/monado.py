"""Monado's service as a process that tests start, kill, stop and start again.

`python -m openxr.monado CMD...` runs CMD beside one.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from display.programs import Process

RUNTIME = "/usr/share/openxr/1/openxr_monado.json"
# A head that wobbles by itself; one that stays where openxr.remote_head puts it; pictures go
# nowhere, at 20 a second; or on the screen.
WOBBLING = {"SIMULATED_ENABLE": "1"}
REMOTE = {"P_OVERRIDE_ACTIVE_CONFIG": "remote", "SIMULATED_ENABLE": "0"}
UNSEEN = {"XRT_COMPOSITOR_NULL": "1"}
ON_SCREEN = {"XRT_COMPOSITOR_NULL": "0", "XRT_COMPOSITOR_FORCE_XCB": "1"}


def listens(socket: Path) -> bool:
    """Whether somebody takes connections there: the file is there a moment before that.

    Source: proc(5), /proc/net/unix; the fourth column is __SO_ACCEPTCON.
    """
    lines = map(str.split, Path("/proc/net/unix").read_text(encoding="utf-8").splitlines()[1:])
    return any(fields[-1] == str(socket) and int(fields[3], 16) & 0x10000 for fields in lines)


class Monado:
    """One service after the other on one runtime folder.

    folder: for its socket and what it says. settings: its environment variables, beside ours.
    """

    def __init__(self, folder: Path, settings: Mapping[str, str]) -> None:
        self.folder, self.settings = folder, dict(settings)
        self.process: Process | None = None

    @property
    def environment(self) -> dict[str, str]:
        """What a program must have in its environment to find this runtime."""
        return {"XDG_RUNTIME_DIR": str(self.folder), "XR_RUNTIME_JSON": RUNTIME}

    def start(self) -> Monado:
        """Start it, wait until it answers, and return this."""
        assert self.process is None, "this service is running already"
        socket = self.folder / "monado_comp_ipc"
        socket.unlink(missing_ok=True)  # a service that was ended leaves it behind, and would be taken for running
        # It reads commands from stdin, and ends at once when that is closed.
        environment = {**os.environ, **self.environment, "XRT_NO_STDIN": "1", **self.settings}
        self.process = Process(self.folder / "monado.log", "monado-service", env=environment)
        self.process.until(lambda: listens(socket), "it listened")
        return self

    def kill(self) -> None:
        """It is gone at once, if there is one."""
        if self.process is not None:
            self.process.kill()
            self.process = None


def main(command: list[str]) -> int:
    """Run a command beside a service with the settings that are in the environment."""
    for name, value in {**UNSEEN, **({} if "P_OVERRIDE_ACTIVE_CONFIG" in os.environ else WOBBLING)}.items():
        os.environ.setdefault(name, value)
    with tempfile.TemporaryDirectory() as folder:
        monado = Monado(Path(folder), {})
        try:
            monado.start()
            return subprocess.run(command, check=False, env={**os.environ, **monado.environment}).returncode
        finally:
            monado.kill()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
