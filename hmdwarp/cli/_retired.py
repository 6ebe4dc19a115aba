"""Command lines that were removed: what to use instead, for one release."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path


def entries() -> dict[str, str]:
    """Return what to use instead of each removed command, option and value (`retired.toml`)."""
    return tomllib.loads(Path(__file__).with_name("retired.toml").read_text(encoding="utf-8"))


def instead_of(arguments: Sequence[str]) -> str | None:
    """Return one sentence on the first removed name in a command line; None where it has none."""
    words = [part for word in arguments for part in (word.split("=", 1) if word.startswith("--") else [word])]
    for key, instead in entries().items():
        if _holds(words, key.split()):
            return f"{key.removeprefix('* ')} was removed: {instead}"
    return None


def _holds(words: Sequence[str], key: Sequence[str]) -> bool:
    """Return whether the command comes first, and the option anywhere, its value right after."""
    start = next((at for at, word in enumerate(key) if word.startswith("--")), len(key))
    command, option = key[:start], key[start:]
    if len(words) < len(command) or not all(map(fnmatchcase, words, command)):
        return False
    return any(len(words) >= at + len(option) and all(map(fnmatchcase, words[at:], option)) for at in range(len(words)))
