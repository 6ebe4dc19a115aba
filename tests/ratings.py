"""ColorVideoVDP in tests: with it, or without it."""

from __future__ import annotations

import importlib.util

import needs
import pytest

_HERE = all(importlib.util.find_spec(name) is not None for name in ("pycvvdp", "torch"))
with_cvvdp = pytest.mark.skipif(not _HERE, reason=needs.missing("ColorVideoVDP", "pip install 'hmdwarp[jod]'"))
without_cvvdp = pytest.mark.skipif(_HERE, reason="ColorVideoVDP is installed")
# Importing torch and its friends warns about what they use of each other.
quiet = pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning", "ignore::UserWarning")
