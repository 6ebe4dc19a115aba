"""Tables of refusals: what is put in place of what in a text that is right, and what is said of it.

    found -> put => says            in one line, or `=> says` in the next
    found -> put => says @ text     of the line where that text stands in the wrong file

A ⏎ begins a new line. Without @ what is said is of the line where `put` begins, or of that with a »
in it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from hmdwarp.errors import InputError


def table(text: str) -> list[str]:
    """The entries."""
    return re.sub(r"\n +=>", " =>", text.strip("\n")).splitlines()


def check_refused(entry: str, text: str, read: Callable[[str], object], path: str | Path) -> None:
    """Whether the reader refuses the changed text in one line, as the entry says, with its line."""
    change, _, said = entry.partition(" => ")
    found, put = (side.replace("⏎", "\n") for side in re.split(" -> ?", change))
    says, _, where = (side.replace("⏎", "\n") for side in said.partition(" @ "))
    assert found in text and says, entry
    wrong = text.replace(found, put.replace("»", ""), 1)
    at = wrong.index(where) if where else text.index(found) + max(put.find("»"), 0)
    with pytest.raises(InputError) as caught:
        read(wrong)
    told = str(caught.value)
    assert says in told and "\n" not in told, told
    assert told.startswith(f"{path}:{wrong[:at].count(chr(10)) + 1}: "), told
