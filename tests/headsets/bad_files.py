"""A headset's file with a fault in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from hmdwarp.base import InputError
from hmdwarp.headsets import load_headset


def refusal(folder: Path, text: str | bytes, name: str = "mine.toml") -> str:
    """Return what is said of a file with that text after its path: one line."""
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as caught:
        load_headset(str(path))
    assert str(caught.value).startswith(f"{path}:") and "\n" not in str(caught.value)
    return str(caught.value).removeprefix(f"{path}:")
