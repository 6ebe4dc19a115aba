"""Text in a row of cells: how wide it is, cut, padded, wrapped. Some characters take two cells, some none.

A fragment is (style, text), as prompt_toolkit has them; a row is a list of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import attrs
from prompt_toolkit.utils import get_cwidth

Fragment = tuple[str, str]
Row = list[Fragment]
_ESCAPES = re.compile(r"\x1b(\[[0-9;?]*[ -/]*[@-~]|\][^\x07\x1b]*(\x07|\x1b\\)?|.)")


@attrs.frozen
class Glyphs:
    """What bars and rules are drawn with."""

    full: str = "█"
    empty: str = "░"
    line: str = "─"
    dot: str = "·"
    mid: str = "┼"
    more: str = "…"
    degree: str = "°"


ASCII = Glyphs(full="#", empty=".", line="-", dot=".", mid="+", more="~", degree=" deg")


def plain(text: str) -> str:
    """Without colours, bells and whatever else would move the cursor; tabs and new lines become blanks."""
    text = _ESCAPES.sub("", text)
    return "".join(" " if c in "\t\n\r" else c for c in text if c.isprintable() or c in "\t\n\r")


def cut(text: str, width: int, more: str) -> str:
    """At most `width` cells of it; `more`, one cell wide, stands where something is missing."""
    if get_cwidth(text) <= width:
        return text
    kept = ""
    for character in text:
        if get_cwidth(kept) + get_cwidth(character) > width - 1:
            break
        kept += character
    return kept + more if width > 0 else ""


def end_of(text: str, width: int, more: str) -> str:
    """The last `width` cells of it: a line that is being typed shows its end."""
    if get_cwidth(text) <= width:
        return text
    while text and get_cwidth(text) > width - 1:
        text = text[1:]
    return more + text


def fitted(row: Iterable[Fragment], width: int, more: str, fill: str = "") -> Row:
    """The row exactly `width` cells wide: cut, or padded with blanks of style `fill`."""
    left, out = width, []
    for style, text in row:
        piece = cut(text, left, more)
        if piece:
            out.append((style, piece))
        left -= get_cwidth(piece)
        if piece != text:
            break
    return [*out, (fill, " " * left)] if left > 0 else out


def spread(left: Row, right: Row, width: int, more: str, fill: str = "") -> Row:
    """`left` and `right` at both ends of a row; where there is no room for both, `right` stays whole."""
    room = width - sum(get_cwidth(text) for _, text in right)
    return fitted([*fitted(left, max(0, room), more, fill), *right], width, more, fill)


def wrapped(text: str, width: int, rows: int, more: str) -> list[str]:
    """At most `rows` lines of at most `width` cells, broken between words where that can be done; what is left out is marked."""
    lines, words = [""], text.split()
    for place, word in enumerate(words):
        longer = f"{lines[-1]} {word}" if lines[-1] else word
        if get_cwidth(longer) <= width or not lines[-1]:
            lines[-1] = longer
        elif len(lines) == rows:
            lines[-1] = cut(lines[-1] + " " + " ".join(words[place:]), width, more)
            break
        else:
            lines.append(word)
    return [cut(line, width, more) for line in lines]
