"""Files that are wrong in one place: each is refused in one line, with the line of the fault.

refused/NAME.txt is of plans/NAME.toml, or of the scale of that name. Its first line says what reads
it, each other one what is put in place of what, and what is said of it:

    found -> put => says            in one line, or `=> says` in the next
    found -> put => says @ text     of the line where that text stands in the wrong file

A ⏎ begins a new line. Without @ what is said is of the line where `put` begins, or of that with a »
in it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from hmdwarp.base import InputError
from hmdwarp.study.design import design_from_text
from hmdwarp.study.respondents import model_from_text
from hmdwarp.study.scales import FOLDER as SCALES
from hmdwarp.study.scales import load_scale

from .plans import PLANS


def scale_from_text(text: str, path: str) -> object:
    Path(path).write_text(text, encoding="utf-8")
    return load_scale(path)


READERS = {
    "plan": design_from_text,
    "plan, unchecked": lambda text, path: design_from_text(text, path, checked=False),
    "scale": scale_from_text,
    "model": model_from_text,
}


def entries_of(text: str) -> Iterator[tuple[str, str, str, str]]:
    """(entry, what is found, what is put there, what is said of it)."""
    for entry in re.sub(r"\n +=>", " =>", text.strip("\n")).splitlines():
        change, _, said = entry.partition(" => ")
        found, put = (side.replace("⏎", "\n") for side in re.split(" -> ?", change))
        yield entry, found, put, said.replace("⏎", "\n")


@pytest.mark.parametrize("file", sorted(Path(__file__).with_name("refused").iterdir()), ids=lambda file: file.stem)
def test_wrong_input_is_refused_with_its_line(file, tmp_path):
    reader, _, entries = file.read_text(encoding="utf-8").partition("\n\n")
    name, path = f"{file.stem}.toml", str(tmp_path / "wrong.toml")
    right = next(folder / name for folder in (PLANS, SCALES) if (folder / name).exists()).read_text(encoding="utf-8")
    READERS[reader](right, path)
    (tmp_path / "small.png").write_text("no picture at all", encoding="utf-8")
    for entry, found, put, said in entries_of(entries):
        says, _, where = said.partition(" @ ")
        assert found in right and says, entry
        wrong = right.replace(found, put.replace("»", ""), 1)
        at = wrong.index(where) if where else right.index(found) + max(put.find("»"), 0)
        with pytest.raises(InputError) as caught:
            READERS[reader](wrong, path)
        told = str(caught.value)
        assert says in told and "\n" not in told, (entry, told)
        assert told.startswith(f"{path}:{wrong[:at].count(chr(10)) + 1}: "), (entry, told)
