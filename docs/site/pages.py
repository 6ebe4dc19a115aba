"""Make the pages of the site that are no file of docs/: those beside it, examples, reference.

A hook of MkDocs (docs/site/mkdocs.yml). The reference has a page for each package that names in
`__all__` what is public; what it does not define itself is linked to where that stands.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
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

    found = pkgutil.walk_packages(hmdwarp.__path__, "hmdwarp.")
    names = [module.name for module in found if module.ispkg and "._" not in module.name]
    packages = [package for package in map(importlib.import_module, names) if getattr(package, "__all__", None)]
    homes = {package.__name__ for package in packages}
    pages = {f"reference/{package.__name__}.md": _page(package, homes) for package in [hmdwarp, *packages]}
    lines = [
        f"- [{package.__name__}]({package.__name__}.md): {_first_line(package)}" for package in [hmdwarp, *packages]
    ]
    pages["reference/index.md"] = "\n".join(["# Reference", "", *lines])
    return pages


def _page(package: ModuleType, homes: set[str]) -> str:
    """Return the page of one package: its own public things in full, others as links."""
    own, others, constants = [], [], []
    for name in sorted(package.__all__):
        thing = getattr(package, name)
        home = _home(thing, homes)
        if not (inspect.isclass(thing) or inspect.isfunction(thing)):
            constants.append(f"- `{name}`: {_constant(thing)}")
        elif home in (package.__name__, None):
            own.append(f"::: {thing.__module__}.{thing.__qualname__}")
        else:
            others.append(f"- [`{name}`]({home}.md#{thing.__module__}.{thing.__qualname__}): {_first_line(thing)}")
    parts = [f"# {package.__name__}", inspect.getdoc(package) or ""]
    parts += ["\n".join(lines) for lines in (others, constants) if lines]
    return "\n\n".join([*parts, *own])


def _home(thing: Any, homes: set[str]) -> str | None:
    """Return the innermost package with a page that a class or function is defined in."""
    module = getattr(thing, "__module__", "")
    while module and module not in homes:
        module = module.rpartition(".")[0]
    return module or None


def _constant(value: Any) -> str:
    simple = isinstance(value, str | int | float | tuple) and len(repr(value)) < 80
    return f"`{value!r}`" if simple else f"a `{type(value).__name__}`"


def _first_line(thing: Any) -> str:
    return (inspect.getdoc(thing) or "").partition("\n")[0].removeprefix("hmdwarp: ")
