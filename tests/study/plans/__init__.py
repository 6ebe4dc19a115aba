"""Small studies, scales and simulated people that the tests share, each a file beside this one."""

from __future__ import annotations

from pathlib import Path

PLANS = Path(__file__).parent


def text_of(name: str, *changes: tuple[str, str]) -> str:
    """The text of NAME.toml, with each thing found replaced by another."""
    text = (PLANS / f"{name}.toml").read_text(encoding="utf-8")
    for found, put in changes:
        assert found in text, found
        text = text.replace(found, put)
    return text
