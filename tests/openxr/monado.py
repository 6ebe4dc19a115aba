"""Monado's service as a process that tests start, kill, stop and start again.

`python -m openxr.monado CMD...` runs CMD beside one.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

RUNTIME = "/usr/share/openxr/1/openxr_monado.json"
# A head that wobbles by itself; one that stays where openxr.remote_head puts it; pictures go
# nowhere, at 20 a second; or on the screen.
WOBBLING = {"SIMULATED_ENABLE": "1"}
REMOTE = {"P_OVERRIDE_ACTIVE_CONFIG": "remote", "SIMULATED_ENABLE": "0"}
UNSEEN = {"XRT_COMPOSITOR_NULL": "1"}
ON_SCREEN = {"XRT_COMPOSITOR_NULL": "0", "XRT_COMPOSITOR_FORCE_XCB": "1"}
START_S = 600.0  # against hanging


def listens(socket: Path) -> bool:
    """Whether somebody takes connections there: the file is there a moment before that.

    Source: proc(5), /proc/net/unix; the fourth column is __SO_ACCEPTCON.
    """
    lines = map(str.split, Path("/proc/net/unix").read_text(encoding="utf-8").splitlines()[1:])
    return any(fields[-1] == str(socket) and int(fields[3], 16) & 0x10000 for fields in lines)


class Monado:
    """One service after the other on one runtime folder.

    Use as a context manager; it is started by `start`.

    folder: for its socket and what it says. settings: its environment variables, beside ours.
    """

    def __init__(self, folder: Path, settings: Mapping[str, str]) -> None:
        self.folder, self.settings = folder, dict(settings)
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def environment(self) -> dict[str, str]:
        """What a program must have in its environment to find this runtime."""
        return {"XDG_RUNTIME_DIR": str(self.folder), "XR_RUNTIME_JSON": RUNTIME}

    @property
    def log(self) -> Path:
        """What it said, all services of this folder."""
        return self.folder / "monado.log"

    def start(self) -> None:
        """Start it and wait until it answers."""
        assert self._process is None, "this service is running already"
        socket = self.folder / "monado_comp_ipc"
        socket.unlink(missing_ok=True)  # a service that was ended leaves it behind, and would be taken for running
        # It reads commands from stdin, and ends at once when that is closed.
        environment = {**os.environ, **self.environment, "XRT_NO_STDIN": "1", **self.settings}
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(
                ["monado-service"], env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT
            )
        until = time.monotonic() + START_S
        while not listens(socket):
            if self._process.poll() is not None or time.monotonic() > until:
                self.kill()
                raise RuntimeError(f"monado-service did not start:\n{self.log.read_text(errors='replace')[-4000:]}")
            time.sleep(0.02)

    def pause(self) -> None:
        """It hangs: it is there and answers nothing."""
        self._send(signal.SIGSTOP)

    def resume(self) -> None:
        """It goes on."""
        self._send(signal.SIGCONT)

    def kill(self) -> None:
        """It is gone at once, if there is one."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def _send(self, number: signal.Signals) -> None:
        assert self._process is not None, "no service is running"
        self._process.send_signal(number)

    def __enter__(self) -> Monado:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()


def main(command: list[str]) -> int:
    """Run a command beside a service with the settings that are in the environment."""
    for name, value in {**UNSEEN, **({} if "P_OVERRIDE_ACTIVE_CONFIG" in os.environ else WOBBLING)}.items():
        os.environ.setdefault(name, value)
    with tempfile.TemporaryDirectory() as folder, Monado(Path(folder), {}) as monado:
        monado.start()
        return subprocess.run(command, check=False, env={**os.environ, **monado.environment}).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
