"""The command line in this process, for tests that need no process of their own."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest


def hmdwarp(*arguments: object, folder: Path | None = None, page: bool = True) -> subprocess.CompletedProcess[str]:
    """Run a command in `folder`, in a terminal of 80 columns, with nothing to read from.

    page: whether a run's report.html is drawn; its plots take longer than a small run.
    """
    from hmdwarp.cli import main

    words = ["hmdwarp", *map(str, arguments)]
    handlers = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    out, err = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, Path(os.devnull).open(encoding="utf-8") as nothing:
        patch.setattr(sys, "argv", words)
        patch.setattr(sys, "stdin", nothing)
        patch.setenv("COLUMNS", "80")
        if folder is not None:
            patch.chdir(folder)
        if not page:
            for name in ("run_summary.render_report", "live_log.render_live_report"):
                patch.setattr(f"hmdwarp.run.{name}", lambda *_, **__: "no page")
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as left:
                main()
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
    return subprocess.CompletedProcess(words, left.value.code or 0, out.getvalue(), err.getvalue())
