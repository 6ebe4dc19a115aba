"""ColorVideoVDP in tests: with it, or without it."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import needs
import pytest

_HERE = all(importlib.util.find_spec(name) is not None for name in ("pycvvdp", "torch"))
with_cvvdp = pytest.mark.skipif(not _HERE, reason=needs.missing("ColorVideoVDP", "make test-jod"))
without_cvvdp = pytest.mark.skipif(_HERE, reason="ColorVideoVDP is installed")
# Importing torch and its friends warns about what they use of each other.
quiet = pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning", "ignore::UserWarning")


@pytest.fixture
def crashing_torch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Put first a torch whose import ends the process, as beside Mesa's LLVM.

    Returns the line that a run then says.
    """
    for name, text in (("torch", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"), ("pycvvdp", "")):
        (tmp_path / "packages" / name).mkdir(parents=True)
        (tmp_path / "packages" / name / "__init__.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path / "packages")
    return "JOD could not be measured: the process that rates ended (Segmentation fault); the run goes on without it"
