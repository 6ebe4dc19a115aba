"""Make the pages of the site that are no file of docs/: those beside it, examples, reference.

A hook of MkDocs (docs/site/mkdocs.yml). The reference has what `hmdwarp` names as public: a page of
its own names, and one of each module among them.
"""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
TOP = "CONTRIBUTING.md", "CHANGELOG.md"  # beside docs/, so their links are turned
sys.path.insert(0, str(ROOT))


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages to those that MkDocs found in docs/."""
    pages = {name: _turned(ROOT / name) for name in TOP}
    pages["recordings.md"] = (ROOT / "recordings" / "README.md").read_text(encoding="utf-8")
    pages["examples.md"] = _examples()
    pages |= _reference()
    for name, text in pages.items():
        files.append(File.generated(config, name, content=text))
    return files


def _turned(path: Path) -> str:
    """Return a page that stands beside docs/, its links as from within."""
    text = path.read_text(encoding="utf-8")
    text = re.sub(r"(\]\(|src=\")docs/", r"\1", text)
    return text.replace("](recordings/README.md)", "](recordings.md)").replace("](README.md)", "](index.md)")


def _examples() -> str:
    """Return one page with all scripts of examples/, by their two lines of header."""
    parts = ["# Examples", "Each runs as it is; `python examples/NAME.py FOLDER` writes into that folder."]
    for script in sorted((ROOT / "examples").glob("*.py")):
        shows, writes, _, *code = script.read_text(encoding="utf-8").splitlines()
        header = " ".join(line.removeprefix("# ") for line in (shows, writes))
        parts += [f"## {script.stem}", header, "\n".join(["```python", *code, "```"])]
    return "\n\n".join(parts)


# --- reference ----------------------------------------------------------------------------------


def _reference() -> dict[str, str]:
    """Return {file: text} of the reference, its table of contents included."""
    import hmdwarp

    public = {name: getattr(hmdwarp, name) for name in hmdwarp.__all__}
    modules = {f"hmdwarp.{name}": thing for name, thing in public.items() if inspect.ismodule(thing)}
    modules = {"hmdwarp": hmdwarp, **modules}
    lines = [f"- [{name}]({name}.md): {_first_line(module)}" for name, module in modules.items()]
    pages = {f"reference/{name}.md": _page(name, module) for name, module in modules.items()}
    return {**pages, "reference/index.md": "\n".join(["# Reference", "", *lines])}


def _page(title: str, module: ModuleType) -> str:
    """Return the page of a module: its public things in full, modules as links."""
    full, links, constants = [], [], []
    for name in sorted(module.__all__):
        thing = getattr(module, name)
        if inspect.ismodule(thing):
            links.append(f"- [`{name}`]({title}.{name}.md): {_first_line(thing)}")
        elif inspect.isclass(thing) or inspect.isfunction(thing):
            full.append(f"::: {thing.__module__}.{thing.__qualname__}")
        else:
            constants.append(f"- `{name}`: {_constant(thing)}")
    about = re.sub(r"\s*Names are in __init__\.pyi;[^.]*\.", "", inspect.getdoc(module) or "")
    parts = [f"# {title}", about]
    return "\n\n".join([*parts, *("\n".join(lines) for lines in (links, constants) if lines), *full])


def _constant(value: Any) -> str:
    simple = isinstance(value, str | int | float | tuple) and len(repr(value)) < 80
    return f"`{value!r}`" if simple else f"a `{type(value).__name__}`"


def _first_line(thing: Any) -> str:
    return (inspect.getdoc(thing) or "").partition("\n")[0].removeprefix("hmdwarp: ")
