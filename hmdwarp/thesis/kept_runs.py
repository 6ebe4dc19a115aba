"""Figures and pictures of finished runs on disk, so that a killed command goes on where it was."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..report import jpeg_bytes, write_bytes, write_json
from ..resources import folder as resource_folder
from .run_kinds import Figures, Run

KEPT = "kept"
PICTURE, TRUTH, TIMELINE = "shown", "truth", "timeline"
# What neither draws nor measures a picture: a change there leaves the figures as they are.
_NOT_OF_PICTURES = ("cli", "display", "doctor", "report", "study", "thesis")


@attrs.frozen(eq=False)
class KeptRuns:
    """The folder of finished runs; each is used again only if it was made with the same things.

    made_with: everything besides the run itself that its figures depend on.
    """

    folder: Path
    made_with: Mapping[str, Any]

    def load(self, run: Run, *, with_picture: bool) -> Figures | None:
        """Return the figures of a run, or None if it has to be run (again)."""
        with suppress(OSError, ValueError, RecursionError):
            data = json.loads(self._path(run).read_bytes())
            if isinstance(data, dict) and data.get("made_with") == self._made_with(run):
                return data["figures"] if data["pictures"] or not with_picture else None
        return None

    def keep(self, run: Run, figures: Figures, pictures: Mapping[str, NDArray[np.uint8] | str]) -> None:
        """Write a run's figures, after its pictures (PICTURE and TRUTH, TIMELINE as SVG, or none).

        Errors: InputError or MachineError for a place that cannot be written.
        """
        for kind, picture in pictures.items():
            content = picture.encode() if isinstance(picture, str) else jpeg_bytes(picture)
            write_bytes(self.picture(run, kind), content)
        data = {"made_with": self._made_with(run), "figures": figures, "pictures": sorted(pictures)}
        write_json(self._path(run), data)

    def picture(self, run: Run, kind: str) -> Path:
        """Return the path of a picture."""
        return self.folder / f"{self._name(run)}-{kind}.{'svg' if kind == TIMELINE else 'jpg'}"

    def _path(self, run: Run) -> Path:
        return self.folder / f"{self._name(run)}.json"

    def _made_with(self, run: Run) -> dict[str, Any]:
        return json.loads(json.dumps({"run": {"kind": type(run).__name__, **attrs.asdict(run)}, **self.made_with}))

    def _name(self, run: Run) -> str:
        """Name a run by its kind and what it is made of; sizes have folders of their own."""
        return f"{type(run).__name__}-{hashlib.sha256(repr(run).encode()).hexdigest()[:16]}"


def fingerprint() -> str:
    """Return a hash of the program's files that pictures and their figures depend on."""
    package = Path(__file__).resolve().parents[1]
    shaders = resource_folder("shaders")
    files = [
        (path, path.relative_to(base).as_posix())
        for base, pattern in ((package, "**/*.py"), (shaders, "**/*.*"))
        for path in sorted(base.glob(pattern))
        if path.is_file() and path.relative_to(base).parts[0] not in _NOT_OF_PICTURES
    ]
    of_thesis = [Path(__file__).with_name(f"{name}.py") for name in ("hole_kinds", "picture_runs", "stream_runs")]
    found = hashlib.sha256()
    for path, name in [*files, *((path, path.name) for path in of_thesis)]:
        found.update(name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()[:16]
