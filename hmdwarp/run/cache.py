"""True pictures and their figures, kept by what determines them: nothing is made twice."""

from __future__ import annotations

import io
import json
import os
import threading
import zipfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..metrics import QualityJob, QualityResult
from ..options.identity import identity_of
from ..report import write_bytes, write_error
from .options import CacheOptions

T = TypeVar("T")
Arrays = Mapping[str, NDArray[Any]]
_ROOM = 0.9  # of the bound, which is left when the oldest entries have gone
_ENDING = ".npz"
_DAMAGED = (zipfile.BadZipFile, OSError, EOFError, KeyError, TypeError, ValueError)


class Cache:
    """A folder of arrays, each entry under the hash of what determines it.

    The hash covers the program too: what another version made is never found, and goes when room is
    needed. An entry that is damaged counts as missing, and the first one is noted.

    about: what determines every entry, besides what key() is given. notes: takes a sentence.
    Errors: InputError or MachineError for a folder that cannot be written, from put() too.
    """

    def __init__(self, options: CacheOptions, about: Any, notes: list[str]) -> None:
        assert options.folder is not None
        self._folder, self._most, self._notes = options.folder, options.most_mb * 1e6, notes
        self._about, self._lock = identity_of("cache", about), threading.Lock()
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise write_error(error, self._folder) from error
        self._bytes = sum(size for _, size, _ in self._entries())
        self._damaged = 0

    def key(self, kind: str, *what: Any) -> str:
        """Return the hash of an entry; what: options, plain values, and arrays by their content."""
        return identity_of(kind, [self._about, *map(_hashed, what)])

    def get(self, key: str, read: Callable[[Arrays], T]) -> T | None:
        """Return what read() makes of an entry; None for one that is missing or damaged."""
        path = self._path(key)
        try:
            with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as found:
                made = read(found)
        except FileNotFoundError:
            return None
        except _DAMAGED:
            if not self._damaged:
                self._notes.append(f"{self._folder}: an entry is damaged ({path.name}): made again")
            self._damaged += 1
            return None
        with suppress(OSError):  # another run removed it since
            os.utime(path)
        return made

    def put(self, key: str, arrays: Arrays) -> None:
        """Keep an entry; from any thread. The longest unused ones go where there is no room."""
        stream, path = io.BytesIO(), self._path(key)
        np.savez(stream, **arrays)  # type: ignore[arg-type]
        content = stream.getvalue()
        waiting = path.with_name(f".{os.getpid()}-{threading.get_ident()}{_ENDING}")
        write_bytes(waiting, content)
        waiting.replace(path)
        with self._lock:
            self._bytes += len(content)
            if self._bytes > self._most:
                self._make_room()

    def _make_room(self) -> None:
        entries = sorted(self._entries())
        self._bytes = sum(size for _, size, _ in entries)
        for _, size, path in entries:
            if self._bytes <= _ROOM * self._most:
                return
            path.unlink(missing_ok=True)
            self._bytes -= size

    def _entries(self) -> list[tuple[int, int, Path]]:
        """Return when each entry was last used, its bytes and its place."""
        found = []
        for path in self._folder.glob(f"*{_ENDING}"):
            with suppress(OSError):  # another run removed it
                about = path.stat()
                found.append((about.st_mtime_ns, about.st_size, path))
        return found

    def _path(self, key: str) -> Path:
        return self._folder / f"{key}{_ENDING}"


def _hashed(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        content = blake2b(np.ascontiguousarray(value).data, digest_size=16).hexdigest()
        return [value.dtype.str, *value.shape, content]
    return value


def key_of_job(cache: Cache, job: QualityJob, pixels_per_degree: float, by: str) -> str:
    """Return the key of a job's figures; by: what finds FLIP, SSIM and flicker."""
    pairs = [(pair.shown, pair.truth, pair.view) for pair in (job.now, job.previous) if pair is not None]
    places = job.covered, job.truth_inverse_depth, job.rendered, job.rendered_size, job.regions
    return cache.key("figures", pixels_per_degree, by, len(pairs), *(part for pair in pairs for part in pair), *places)


def figures_in(found: Arrays) -> QualityResult:
    """Return the figures of an entry. Errors: KeyError and ValueError for a damaged one."""
    values, regions = json.loads(found["figures"].tobytes())
    return QualityResult(values, found["error_map"], regions)


def figures_as_arrays(result: QualityResult) -> Arrays:
    """Return the entry of figures."""
    assert result.error_map is not None
    text = json.dumps([result.values, result.regions]).encode()
    return {"figures": np.frombuffer(text, np.uint8), "error_map": result.error_map}
