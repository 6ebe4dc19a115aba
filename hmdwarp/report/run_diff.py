"""What differs between two replays: set-up, figures, refreshes, pictures."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..options.documents import json_in
from ..options.named_files import LIST, PICTURE_FILE, RESULTS, opened, text_in
from .output import FRAME_COLUMNS, TIMED_COLUMNS, TIMED_KEYS, validate_summary
from .page import Page, Picture, Section, Sentences, Text, fact, machine_pairs
from .run_texts import counted

_FIGURES = ("quality", "regions", "filled", "against", "link", "coding", "second_eye", "gaze", "measured")
_MAGNIFY = 16
DIFF_PAGE = "diff.html"
# Of what is not a metric: the same program on another machine may add in another order.
_ROUNDING = 1e-9


def digests(rows: Sequence[Mapping[str, Any]], pictures: Mapping[str, NDArray[Any]]) -> dict[str, str]:
    """Return the `digests` of summary.json: of frames.csv without its times, and of each picture.

    rows: keyed as frames.csv. pictures: as written, by their path in the folder.
    """
    columns = [name for name in FRAME_COLUMNS if name not in TIMED_COLUMNS]
    found = hashlib.sha256()
    for row in rows:
        found.update(json.dumps([row.get(name) for name in columns], default=str).encode() + b"\n")
    of_pictures = {name: hashlib.sha256(picture.tobytes()).hexdigest() for name, picture in pictures.items()}
    return {"frames.csv": found.hexdigest(), **dict(sorted(of_pictures.items()))}


@attrs.frozen(eq=False)
class StoredRun:
    """A replay's folder, or its summary.json alone."""

    place: Path
    summary: Mapping[str, Any]
    # As it was named: the folder, or its summary.json.
    named: Path

    @classmethod
    def of(cls, place: Path) -> Self:
        """Read it. Errors: InputError where there is no summary of a replay."""
        path = place if place.suffix == ".json" else place / "summary.json"
        summary = json_in(path, RESULTS)
        try:
            validate_summary(summary)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
        if "digests" not in summary:
            raise InputError(f"{path}: no digests: expected a replay of hmdwarp 0.2 or newer; run it again")
        return cls(path.parent, summary, place)

    def rows(self) -> list[dict[str, str]]:
        """Return the rows of frames.csv, none where the file is not kept."""
        path = self.place / "frames.csv"
        return list(csv.DictReader(text_in(path, LIST).splitlines())) if path.exists() else []

    def picture(self, name: str) -> NDArray[np.uint8] | None:
        """Return a picture, None where it is not kept."""
        from PIL import Image

        path = self.place / name
        if not path.exists():
            return None
        with opened(path, PICTURE_FILE, self.place) as file:
            return np.asarray(Image.open(file).convert("RGB"))


@attrs.frozen(eq=False)
class PictureDiff:
    """A picture of both runs that differs."""

    name: str
    # "" where the pictures differ beyond the tolerance in what can be shown.
    why: str = ""
    share: float = 0.0
    largest: int = 0
    pictures: tuple[NDArray[np.uint8], ...] = ()


@attrs.frozen(eq=False)
class RunDiff:
    """What differs between two runs, times left out."""

    first: StoredRun
    second: StoredRun
    # (key, value of the first, value of the second)
    setup: list[tuple[str, Any, Any]]
    figures: list[tuple[str, Any, Any]]
    # Of frames.csv: what differs in its first row that differs, and how many do.
    refreshes: list[str]
    pictures: list[PictureDiff]
    # What does not make them differ, but may explain it.
    notes: list[str]

    @property
    def is_equal(self) -> bool:
        """Whether nothing differs by more than the tolerances."""
        return not (self.setup or self.figures or self.refreshes or self.pictures)

    def lines(self) -> list[str]:
        """Return what differs, a sentence each."""
        pairs = [f"{part}: {key} was {', is '.join(_texts(a, b))}" for part, key, a, b in self._entries()]
        pictures = [
            f"picture: {one.name} " + (one.why or f"differs in {100 * one.share:.2g} % of pixels, by at most "
                                       f"{one.largest} of 255")
            for one in self.pictures
        ]  # fmt: skip
        return [*pairs, *(f"refresh: {text}" for text in self.refreshes), *pictures]

    def _entries(self) -> Iterator[tuple[str, str, Any, Any]]:
        yield from (("set-up", *entry) for entry in self.setup)
        yield from (("figure", *entry) for entry in self.figures)

    def entry(self) -> dict[str, Any]:
        """Return it as plain data, for JSON."""
        keys = ("name", "first", "second")
        return {
            "equal": self.is_equal,
            "setup": [dict(zip(keys, entry, strict=True)) for entry in self.setup],
            "figures": [dict(zip(keys, entry, strict=True)) for entry in self.figures],
            "refreshes": self.refreshes,
            "pictures": [
                {"name": one.name, "why": one.why, "share": one.share, "largest": one.largest} for one in self.pictures
            ],
            "notes": self.notes,
        }

    def page(self, command: str) -> str:
        """Return the page: what differs in words, and each picture beside its difference."""
        shown = [one for one in self.pictures if one.pictures]
        labels = (str(self.first.named), str(self.second.named), f"difference, {_MAGNIFY} times as large")
        blocks = [
            Picture.of(f"{one.name}: {label}", picture, f"{label} of {one.name}")
            for one in shown
            for label, picture in zip(labels, one.pictures, strict=True)
        ]
        summary = self.second.summary
        return Page(
            kind="diff",
            title="hmdwarp: two runs",
            heading=("Two runs", "equal" if self.is_equal else "they differ"),
            facts=[fact("was", self.first.named), fact("is", self.second.named)],
            command=command,
            remarks=self.notes,
            sections=(
                Section("What differs", [Sentences(self.lines()) if self.lines() else Text("Nothing but times.")]),
                Section("Pictures", blocks),
            ),
            made_with=machine_pairs(summary["hmdwarp"], summary["machine"], summary["clock"]),
        ).html()


def diff_runs(first: StoredRun, second: StoredRun, tolerance: Mapping[str, float], levels: float = 0.0) -> RunDiff:
    """Return what differs between two replays by more than the tolerances.

    tolerance: of metrics in their units, by name. levels: of pictures, of 255.
    Errors: InputError for files that cannot be read.
    """
    setup: list[tuple[str, Any, Any]] = []
    figures: list[tuple[str, Any, Any]] = []
    notes: list[str] = []
    for key, a, b in _leaves(first.summary, second.summary):
        if not _is_close(a, b, next((tolerance[part] for part in key.split(".") if part in tolerance), 0.0)):
            (figures if key.split(".")[0] in _FIGURES else setup).append((key, a, b))
    for name, key in (("driver", "gl_version"), ("renderer", "gl_renderer")):
        a, b = (run.summary["machine"].get(key) for run in (first, second))
        if a != b:
            notes.append(f"another {name}: was {a}, is {b}; pictures may differ in their last digits")
    if first.summary["hmdwarp"] != second.summary["hmdwarp"]:
        notes.append(f"another version: was {first.summary['hmdwarp']}, is {second.summary['hmdwarp']}")
    ours, theirs = first.summary["digests"], second.summary["digests"]
    refreshes = [] if ours["frames.csv"] == theirs["frames.csv"] else _refreshes(first, second, tolerance, notes)
    names = [name for name in dict.fromkeys([*ours, *theirs]) if name != "frames.csv"]
    pictures = [_picture(first, second, name, levels) for name in names if ours.get(name) != theirs.get(name)]
    return RunDiff(first, second, setup, figures, refreshes, [one for one in pictures if one is not None], notes)


def _leaves(a: Any, b: Any, key: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the values of both by their keys, but for times and what names the machine."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        for name in dict.fromkeys([*a, *b]):
            if name not in TIMED_KEYS:
                yield from _leaves(a.get(name), b.get(name), f"{key}.{name}" if key else str(name))
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for number, (one, other) in enumerate(zip(a, b, strict=True)):
            yield from _leaves(one, other, f"{key}.{number}")
    else:
        yield key, a, b


def _is_close(a: Any, b: Any, tolerance: float) -> bool:
    if isinstance(a, int | float) and isinstance(b, int | float):
        return a == b or math.isclose(a, b, rel_tol=_ROUNDING, abs_tol=tolerance)
    return bool(a == b)


def _number(text: str | None) -> float | str | None:
    try:
        return float(text) if text else text
    except ValueError:
        return text


def _refreshes(first: StoredRun, second: StoredRun, tolerance: Mapping[str, float], notes: list[str]) -> list[str]:
    ours, theirs = first.rows(), second.rows()
    if not ours or not theirs:
        missing = (first if not ours else second).named
        notes.append(f"frames.csv differs; {missing} has none, so that nothing can be said of single refreshes")
        return []
    if len(ours) != len(theirs):
        return [f"frames.csv had {len(ours)} rows, has {len(theirs)}"]
    found = []
    for a, b in zip(ours, theirs, strict=True):
        apart = [
            f"{name} was {', is '.join(_texts(_number(a.get(name)), _number(b.get(name))))}"
            for name in FRAME_COLUMNS
            if name not in TIMED_COLUMNS
            and not _is_close(_number(a.get(name)), _number(b.get(name)), tolerance.get(name, 0.0))
        ]
        if apart:
            found.append(f"{a['frame']} ({float(a['time_s']):.3f} s), eye {a['eye']}: {', '.join(apart)}")
    return [] if not found else [f"{counted(len(found), 'row')} of {len(ours)} differ, the first is {found[0]}"]


def _picture(first: StoredRun, second: StoredRun, name: str, tolerance: float) -> PictureDiff | None:
    a, b = first.picture(name), second.picture(name)
    if a is None or b is None:
        is_listed = all(name in run.summary["digests"] for run in (first, second))
        missing = (first if a is None else second).named
        return PictureDiff(name, f"differs, and is not kept in {missing}" if is_listed else f"is not in {missing}")
    if a.shape != b.shape:
        return PictureDiff(name, f"had {a.shape[1]}x{a.shape[0]} pixels, has {b.shape[1]}x{b.shape[0]}")
    apart = np.abs(a.astype(np.int16) - b).max(axis=2)
    if apart.max(initial=0) <= tolerance:
        return None
    magnified = np.minimum(apart * _MAGNIFY, 255).astype(np.uint8)
    shown = (a, b, np.repeat(magnified[..., None], 3, axis=2))
    return PictureDiff(name, "", float((apart > tolerance).mean()), int(apart.max()), shown)


def _texts(*values: Any) -> list[str]:
    """Return values that differ with six digits, with all where those are equal."""
    texts = [f"{value:.6g}" if isinstance(value, float) else str(value) for value in values]
    texts = [str(value) for value in values] if len(set(texts)) == 1 else texts
    return ["not there" if value is None else text for value, text in zip(values, texts, strict=True)]
