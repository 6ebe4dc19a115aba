"""What results are made with, as one hash: the program, the options, and files by their content."""

from __future__ import annotations

import enum
import functools
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import attrs

from .declared import HOW
from .documents import json_in
from .errors import InputError
from .named_files import BAG, BESIDE, GLTF, content_of, opened
from .resources import __version__
from .resources import folder as resource_folder

# What neither draws nor measures a picture: a change there leaves most results as they are.
_NOT_OF_RESULTS = ("cli/", "display/", "report/", "experiments/sweep/", "experiments/thesis/thesis")
# How files of a scene name another file.
_NAMING = {".xml": r'name="filename"\s+value="([^"]+)"'}
_NAMING |= {
    ending: rf"^\s*{begins}(.*)$"
    for ending, begins in ((".obj", "mtllib"), (".mtl", "map_kd"), (".ply", "comment texturefile"))
}


def identity_of(kind: str, what: Any) -> str:
    """Return the hash of the program, of a kind of case, and of what it runs.

    what: options and plain values; a file counts by its name and content.
    Errors: OSError and InputError for a file that cannot be read.
    """
    made_with = {"hmdwarp": __version__, "program": program_hash(), "kind": kind, "what": _content(what)}
    text = json.dumps(made_with, sort_keys=True, allow_nan=True)
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:32]


@functools.cache
def program_hash(left_out: tuple[str, ...] = _NOT_OF_RESULTS) -> str:
    """Return a hash of the program's files that results depend on, wherever it is installed.

    left_out: beginnings of paths in the package; () for all of the program.
    """
    package, shaders = Path(__file__).resolve().parents[1], resource_folder("shaders")
    found = hashlib.sha256()
    patterns = [(package, f"**/*.{ending}") for ending in ("py", "toml", "sql", "xz")]
    for base, pattern in (*patterns, (shaders, "**/*.*")):
        for path in sorted(base.glob(pattern)):
            name = path.relative_to(base).as_posix()
            if path.is_file() and not name.startswith(("_data/", *left_out)):
                found.update(name.encode() + b"\0" + path.read_bytes())
    return found.hexdigest()[:16]


def files_at(place: str | Path) -> list[Path]:
    """Return the files that a place stands for: one, those that a scene names, those of a folder.

    What a scene names outside its folder is left out.
    """
    path = Path(place)
    if path.is_dir():
        return sorted(each for each in path.rglob("*") if each.is_file())
    found = [path]
    for each in found:  # it grows: the materials of a scene name its pictures
        names = (name for name in _named_by(*_state(each)) if not {"..", "/"} & {*Path(name).parts})
        beside = dict.fromkeys(path.parent / name for name in names)
        found += [other for other in beside if other not in found and is_place(other) and other.is_file()]
    return sorted(found)


def _state(path: Path) -> tuple[Path, int, int]:
    """Return what changes with a file's content: so that no case reads it again."""
    about = path.stat()
    return path, about.st_size, about.st_mtime_ns


@functools.lru_cache(maxsize=256)
def _named_by(path: Path, size: int, mtime_ns: int) -> list[str]:
    """Return the names of files in a file of a scene, relative to the scene's folder."""
    kind, uris = path.suffix.lower(), list[Any]()
    if kind == ".gltf":
        with suppress(InputError, AttributeError, TypeError):  # loading the scene says what is wrong
            header = json_in(path, GLTF)
            uris = [one.get("uri") for part in ("buffers", "images") for one in header.get(part, [])]
        return [unquote(uri) for uri in uris if isinstance(uri, str) and not uri.startswith("data:")]
    if kind not in _NAMING:
        return []
    found = re.findall(_NAMING[kind], content_of(path, BESIDE).decode("utf-8", "replace"), re.IGNORECASE | re.MULTILINE)
    return [name.strip() for name in found]


def hash_of_files(place: str | Path) -> str:
    """Return a hash of the names and contents of files_at(place)."""
    path = Path(place)
    return _hash_of_files(tuple(map(_state, files_at(path))), path if path.is_dir() else path.parent)


@functools.lru_cache(maxsize=256)
def _hash_of_files(files: tuple[tuple[Path, int, int], ...], base: Path) -> str:
    found = hashlib.sha256()
    for path, _, _ in files:
        found.update(path.relative_to(base).as_posix().encode(errors="surrogatepass") + b"\0")
        with opened(path, BAG) as stream:
            found.update(hashlib.file_digest(stream, "sha256").digest())  # type: ignore[arg-type]
    return found.hexdigest()


def _content(value: Any) -> Any:
    """Return plain data of options and values, with files by content."""
    if attrs.has(type(value)):
        names = [each.name for each in attrs.fields(type(value)) if each.init and each.name not in HOW]
        return {"": type(value).__name__, **{name: _content(getattr(value, name)) for name in names}}
    if isinstance(value, Mapping):
        return {str(key): _content(each) for key, each in value.items()}
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, str | Path):
        return {"file": Path(value).name, "content": hash_of_files(value)} if is_place(value) else str(value)
    if isinstance(value, Iterable):
        return [_content(each) for each in value]
    return value if value is None or isinstance(value, bool | int | float) else repr(value)


def is_place(value: str | Path) -> bool:
    """Return whether a text names a file, or a path a file or folder.

    A bare name without an ending, such as `walk`, is one that hmdwarp knows.
    """
    try:
        if isinstance(value, Path):
            return value.exists()
        named = Path(value)
        return "\0" not in value and (bool(named.suffix) or named.name != value) and named.is_file()
    except (OSError, ValueError):  # a text too long to be a name
        return False
