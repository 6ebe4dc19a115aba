"""Several numbers in one cell of a table: vectors as Unity, Unreal, NumPy and Python print them."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from typing import Any

from ..assumptions import By
from ..options import Euler
from ..stated import Defect
from .columns import names_rotation
from .made import Made, rows_text

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PLAIN = re.compile(rf"(?:{_NUMBER}|[-+]?(?:nan|inf))$", re.IGNORECASE)
_LABELLED = re.compile(rf"([A-Za-z]+)[\"']*\s*[=:]\s*({_NUMBER})")
_UNREAL = re.compile(rf"(?:X|P|Pitch)={_NUMBER},?\s*(?:Y|Yaw)={_NUMBER},?\s*(?:Z|R|Roll)={_NUMBER}")
_COMMAS = re.compile(r"[-+]?\d+,\d+(?:[,;]\s+[-+]?\d+,\d+)+$")  # (0,1, 1,6): decimal commas
# Brackets, quotes or labels about numbers, or numbers apart by another sign than the cells are.
_SUSPECT = re.compile(
    rf"[(\[{{]\s*{_NUMBER}[\s,;]|[A-Za-z]\s*=\s*[-+.\d]|[({{][\"'\s]*[A-Za-z]+[\"']*\s*:|\"\s*{_NUMBER}[\s,;]+{_NUMBER}[^\"]*\"|[;\t][^;\t,]*\d,[^;\t,]+,[^;\t]*\d"
    rf"|,\s*{_NUMBER}\s+{_NUMBER}\s+{_NUMBER}"
)
_SAMPLE, _PREAMBLE, _LONGEST = 5, 200, 500  # rows, lines, characters that are looked at
_LABELS = {3: "xyz", 7: ("x", "y", "z", "q0", "q1", "q2", "q3")}
# FRotator::Quaternion of Unreal turns about x (roll) and y (pitch) against its axes.
_ROTATOR = {"r": "x", "p": "y", "y": "z", "roll": "x", "pitch": "y", "yaw": "z"}
_UNREAL_EULER = Euler("xyz", True, (-1, -1, 1))
_NAMELESS = Defect(
    "cells-nameless", "no header names its vectors", "three numbers taken as the position, four as the rotation"
)


def holds_vectors(lines: list[str]) -> bool:
    """Return whether the first rows hold several numbers in a cell."""
    rows = list(itertools.islice((line[:_LONGEST] for line in lines[:_PREAMBLE] if _is_row(line)), _SAMPLE))
    return bool(rows) and sum(_SUSPECT.search(row) is not None for row in rows) * 2 > len(rows)


def table_of_cells(text: str) -> Made | None:
    """Return one column for each number of the cells; None where cells cannot be separated."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    begin = next((i for i, line in enumerate(lines) if _is_row(line)), None)
    if begin is None:
        return None
    separator = _separator(lines[begin])
    first = [_parts(cell) for cell in _cells(lines[begin], separator)]
    header = [_header_name(cell) for cell in _cells(lines[begin - 1], separator)] if begin else []
    named = len(header) == len(first)
    names: list[str] = []
    for i, parts in enumerate(first):
        name, labels = header[i] if named else (_shape_name(len(parts), i), "")
        names += _names(name, labels, parts)
    if max(map(len, first)) < 2 or len(set(names)) < len(names):
        return None
    rows = [[text for cell in _cells(line, separator) for _, text in _parts(cell)] for line in lines[begin:]]
    unreal = _UNREAL.search(lines[begin]) is not None
    facts: dict[str, Any] = {} if named else {"columns_by": By.NOBODY}
    if unreal and any(_is_rotator([label for label, _ in parts]) for parts in first):
        facts |= {"euler": _UNREAL_EULER, "order_by": By.FORMAT}
    defects = () if named else (_NAMELESS,)
    return Made("unreal" if unreal else "vectors", rows_text(rows), tuple(names), defects, facts=facts)


def _is_row(line: str) -> bool:
    """Return whether a line holds numbers, and no names or a remark."""
    bare = line[:_LONGEST].strip()
    if not bare or bare.startswith(("#", "%", "//")):
        return False
    words = re.findall(r"[A-Za-z_]\w*", bare)
    return len(_LABELLED.findall(bare)) > 1 or len(re.findall(rf"(?<![\w.]){_NUMBER}(?![\w.])", bare)) > len(words)


def _separator(row: str) -> str | None:
    outside = re.sub(r'"[^"]*"|\([^()]*\)|\[[^\[\]]*\]|\{[^{}]*\}', "", re.sub(r"\[[^\[\]]*\]", "", row))
    return next((mark for mark in ";\t," if mark in outside), None)


def _cells(line: str, separator: str | None) -> Iterator[str]:
    """Yield the cells of a line; brackets and quotes hold theirs together."""
    depth, quoted, begin = 0, False, 0
    for i, sign in enumerate(line):
        quoted ^= sign == '"'
        depth += (sign in "([{") - (sign in ")]}")
        if depth <= 0 and not quoted and (sign == separator or (separator is None and sign.isspace())):
            if separator is not None or line[begin:i].strip():
                yield line[begin:i]
            begin = i + 1
    if line[begin:].strip():
        yield line[begin:]


def _parts(cell: str) -> list[tuple[str, str]]:
    """Return label and number of each part; a cell of one value is a part without a label."""
    bare = cell.strip().strip('"').strip()
    if re.fullmatch(r"[-+]?\d*,\d+", bare):
        return [("", bare.replace(",", "."))]
    labelled = _LABELLED.findall(bare)
    if len(labelled) > 1:
        return [(label.lower(), number) for label, number in labelled]
    inner = re.sub(r"^[A-Za-z_][\w.]*\s*(?=[(\[{])|[()\[\]{}<>]", " ", bare).strip()
    if _COMMAS.match(inner):
        return [("", part.replace(",", ".")) for part in re.split(r"[,;]\s+", inner)]
    found = [part for part in re.split(r"[;,\s]+", inner) if part]
    if len(found) > 1 and all(_PLAIN.match(part) for part in found):
        return [("", part) for part in found]
    return [("", bare.replace(",", " "))]


def _header_name(cell: str) -> tuple[str, str]:
    """Return a column's name, and the letters that it lists: Rotation (x, y, z, w)."""
    bare = cell.strip().strip('"').strip("# ")
    letters = re.search(r"[(\[{]((?:\s*[A-Za-z]\s*[,;\s])+\s*[A-Za-z])\s*[)\]}]$", bare)
    if letters is None:
        return bare, ""
    return bare[: letters.start()].strip(), "".join(re.findall("[A-Za-z]", letters[1])).lower()


def _shape_name(count: int, place: int) -> str:
    return {1: "time" if place == 0 else f"column {place + 1}", 3: "position", 4: "rotation"}.get(count, f"{place + 1}")


def _is_rotator(labels: list[str]) -> bool:
    return set(labels) in ({"p", "y", "r"}, {"pitch", "yaw", "roll"})


def _names(name: str, letters: str, parts: list[tuple[str, str]]) -> list[str]:
    count, labels = len(parts), [label for label, _ in parts]
    if count == 1:
        return [name]
    if _is_rotator(labels):
        turned = name if names_rotation(name) else f"{name}.rotation"
        return [f"{turned}.{_ROTATOR[label]}" for label in labels]
    if not all(labels):
        numbered = [f"q{i}" for i in range(4)] if count == 4 and names_rotation(name) else map(str, range(count))
        labels = list(letters if len(letters) == count else _LABELS.get(count, numbered))
    return [f"{name}.{label}" for label in labels]
