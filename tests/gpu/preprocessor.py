"""Just enough of GLSL's preprocessor to tell which side of each #if a set of defines takes."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

_DIRECTIVE = re.compile(r"^\s*#\s*(if|ifdef|ifndef|elif|else|endif|define|undef)\b\s*(.*?)\s*(?://.*)?$")
_NAME = re.compile(r"[A-Za-z_]\w*")


@dataclass
class Sides:
    """Lines (as flattened) of conditionals: the sides there are, and those a variant takes. A
    missing #else is a side too."""

    known: set[tuple[object, str]] = field(default_factory=set)
    taken: set[tuple[object, str]] = field(default_factory=set)


def value_of(expression: str, defines: dict[str, str]) -> bool:
    """An #if expression of integers, names, defined(), comparisons and && || !.

    Unknown names are 0, as in C.
    """
    text = re.sub(
        r"defined\s*\(\s*(\w+)\s*\)|defined\s+(\w+)", lambda m: str(int((m[1] or m[2]) in defines)), expression
    )
    for _ in range(8):  # defines made of defines
        text = _NAME.sub(lambda m: f"({defines[m[0]]})" if m[0] in defines else "0", text)
    text = re.sub(r"!(?!=)", " not ", text.replace("&&", " and ").replace("||", " or "))
    if not re.fullmatch(r"[\d\s()<>=!+\-*/%andort]*", text):
        raise ValueError(f"this reader does not know '#if {expression}'")
    return bool(eval(text))  # noqa: S307 - digits and operators only


def opens(word: str, rest: str, defines: dict[str, str]) -> bool:
    """Whether `#word rest` opens its side."""
    return value_of(rest, defines) if word == "if" else (rest in defines) == (word == "ifdef")


def walk(lines: list[str], origins: list[object], sides: Sides) -> dict[str, str]:
    """Add to `sides` what this text has and takes; returns the names defined at its end."""
    defines: dict[str, str] = {}
    stack: list[list] = []  # [origin of the #if, is live outside, has taken a side, is live, has #else]
    for line, origin in zip(lines, origins, strict=True):
        match = _DIRECTIVE.match(line)
        if not match:
            continue
        word, rest = match.groups()
        live = all(level[3] for level in stack)
        if word in ("if", "ifdef", "ifndef"):
            truth = live and opens(word, rest, defines)
            stack.append([origin, live, truth, truth, False])
            sides.known.add((origin, f"#{word} {rest}"))
            sides.taken |= {(origin, f"#{word} {rest}")} if truth else set()
        elif word in ("elif", "else"):
            start, outside, had, _, _ = stack[-1]
            truth = outside and not had and (word == "else" or value_of(rest, defines))
            stack[-1] = [start, outside, had or truth, truth, word == "else"]
            sides.known.add((origin, f"#{word} {rest}".strip()))
            sides.taken |= {(origin, f"#{word} {rest}".strip())} if truth else set()
        elif word == "endif":
            start, outside, had, _, has_else = stack.pop()
            if not has_else:
                sides.known.add((start, "none of its sides"))
                sides.taken |= {(start, "none of its sides")} if outside and not had else set()
        elif live and word == "define":
            name = _NAME.match(rest)[0]
            defines[name] = rest[len(name) :].strip() or "1"
        elif live:
            defines.pop(rest, None)
    return defines
