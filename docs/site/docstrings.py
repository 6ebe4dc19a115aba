"""Read docstrings as this project writes them: an extension of griffe for the site's reference.

Fields are commented where they stand, and a line opens with `Errors:` or `Source:`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from typing import Any

import griffe

OPENERS = re.compile(r"(?<!\n)\n(?=(?:Errors|Raises|Source|Returns): )")
SHORT = 60  # characters of a default that is worth showing


class HouseStyle(griffe.Extension):
    """Lists the fields of a class with their comments, and makes openers paragraphs."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        """Give a line that opens with Errors or Source a paragraph of its own."""
        if obj.docstring:
            obj.docstring.value = OPENERS.sub("\n\n", obj.docstring.value)

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        """List all fields in the docstring of their class, instead of one heading for each."""
        fields = {cls.path: (cls, _fields(cls)) for cls in _classes(pkg)}
        for cls, found in fields.values():
            if found:
                text = cls.docstring.value if cls.docstring else ""
                cls.docstring = griffe.Docstring("\n".join([text, "", *map(_item, found.values())]), parent=cls)
        for cls, found in fields.values():
            for name in found.keys() & cls.members.keys():
                del cls.members[name]


def _classes(parent: griffe.Object) -> Iterator[griffe.Class]:
    """Yield all classes below a module or a class, at any depth."""
    for member in list(parent.members.values()):
        if isinstance(member, griffe.Class):
            yield member
        if isinstance(member, griffe.Module | griffe.Class):
            yield from _classes(member)


def _fields(cls: griffe.Class) -> dict[str, griffe.Attribute]:
    """Return what a class declares as data, those of its bases first."""
    return {
        name: member
        for owner in [*reversed(cls.mro()), cls]
        for name, member in owner.members.items()
        if isinstance(member, griffe.Attribute) and "property" not in member.labels and not name.startswith("_")
    }


def _item(field: griffe.Attribute) -> str:
    """Return one item of a list: name, type, default, comment."""
    default, text = _declared(str(field.value)) if field.value is not None else ("", "")
    default = f" = {default}" if 0 < len(default) < SHORT else ""
    annotation = f": {field.annotation}" if field.annotation is not None else ""
    text = text or (field.docstring.value if field.docstring else _comment(field))
    return f"- `{field.name}{annotation}{default}` {text}".rstrip()


def _declared(value: str) -> tuple[str, str]:
    """Return the default and the help text of a field, by what it is set to: a value, or a call."""
    try:
        call = ast.parse(value, mode="eval").body
    except SyntaxError:  # the repr of a slot of a compiled class
        return "", ""
    name = ast.unparse(call.func) if isinstance(call, ast.Call) else ""
    if name == "group":
        return "", ""
    if name not in ("attrs.field", "option"):
        return value, ""
    known = dict(zip(("default", "help"), call.args, strict=False)) if name == "option" else {}
    known |= {keyword.arg: keyword.value for keyword in call.keywords}
    default, text = (ast.unparse(known[key]) if key in known else "" for key in ("default", "help"))
    default = "" if default == "attrs.NOTHING" else default
    return default, ast.literal_eval(text) if text[:1] in ("'", '"') else ""


def _comment(field: griffe.Attribute) -> str:
    """Return the comment beside the last line of a field, or else that above it."""
    if not (field.lineno and field.endlineno):
        return ""
    lines = field.lines_collection[field.filepath]
    beside = re.search(r"  # (?!noqa|type:)(.*)", lines[field.endlineno - 1])
    if beside:
        return beside[1]
    first, above = field.lineno - 1, []
    while first and lines[first - 1].lstrip().startswith("# "):
        first -= 1
        above.insert(0, lines[first].strip()[2:])
    return " ".join(above)
