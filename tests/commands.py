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


def status_of(words: list[str]) -> int:
    """Run `hmdwarp WORDS` here; how signals are handled is as it was afterwards."""
    from hmdwarp.cli import main

    handlers = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as left:
            patch.setattr(sys, "argv", ["hmdwarp", *words])
            main()
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    return left.value.code or 0


def hmdwarp(*arguments: object, folder: Path | None = None, page: bool = True) -> subprocess.CompletedProcess[str]:
    """Run a command in `folder`, in a terminal of 80 columns, with nothing to read from.

    page: whether a run's report.html is drawn; its plots take longer than a small run.
    """
    words, out, err = [*map(str, arguments)], io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, Path(os.devnull).open(encoding="utf-8") as nothing:
        patch.setattr(sys, "stdin", nothing)
        patch.setenv("COLUMNS", "80")
        if folder is not None:
            patch.chdir(folder)
        if not page:
            for name in ("run_summary.render_report", "live_log.render_live_report"):
                patch.setattr(f"hmdwarp.run.{name}", lambda *_, **__: "no page")
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = status_of(words)
    return subprocess.CompletedProcess(words, status, out.getvalue(), err.getvalue())
