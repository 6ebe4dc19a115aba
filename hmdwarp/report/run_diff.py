"""What differs between two replays: set-up, figures, refreshes, pictures."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import attrs
import numpy as np

from ..base import InputError
from ..base.documents import json_in
from ..base.named_files import LIST, PICTURE_FILE, RESULTS, opened, text_in
from ..metrics import QUALITY, Figure
from . import page
from .files import LATE, Panel, Pixels, panels_in
from .output import FRAME_COLUMNS, TIMED_COLUMNS, TIMED_KEYS, validate_summary
from .replay_page import metric_charts
from .run_texts import Cell, Line, Table, counted, figure_of

DIFF_PAGE = "diff.html"
# Keys of a summary that hold figures; ROWS: of frames.csv.
SECTIONS = ("quality", "regions", "filled", "against", "link", "coding", "gaze", "jod", "hidden", "input")
ROWS = "rows"
# What other keys say already, and what equal runs may have otherwise.
_LEFT_OUT = frozenset({*TIMED_KEYS, "gate", "interval", "difference", "timeline"})
_MAGNIFY = 16
_SOME = 6  # differing columns of a row, and differing pictures, that are named in text
_WORDS = {True: "better", False: "worse", None: "changed"}
_STYLES = {True: "word holds", False: "word fails", None: "word"}


def digests(rows: Sequence[Mapping[str, Any]], pictures: Mapping[str, Sequence[Panel]]) -> dict[str, Any]:
    """Return the `digests` of summary.json: of frames.csv without its times, and of each picture.

    rows: keyed as frames.csv. pictures: the panels of each file, by its path in the folder. The
    last panel has none: an error map in false colours, whose numbers are in the figures.
    """
    columns = [name for name in FRAME_COLUMNS if name not in TIMED_COLUMNS]
    found = hashlib.sha256()
    for row in rows:
        found.update(json.dumps([row.get(name) for name in columns], default=str).encode() + b"\n")
    of_pictures = {
        name: {label: hashlib.sha256(picture.tobytes()).hexdigest() for label, picture in panels[:-1]}
        for name, panels in sorted(pictures.items())
    }
    return {"frames.csv": found.hexdigest(), **of_pictures}


def is_same(key: str, stored: Any, now: Any, tolerance: float = 0.0) -> bool:
    """Return whether two values are equal but for rounding, or this near."""
    if not all(isinstance(value, int | float) for value in (stored, now)):
        return bool(stored == now)
    # 1e-9: the same program on another machine may add in another order.
    return math.isclose(stored, now, rel_tol=1e-9, abs_tol=tolerance)


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
        digests = summary.get("digests", {"": ""})
        if any(isinstance(one, str) != (name == "frames.csv") for name, one in digests.items()):
            raise InputError(f"{path}: no digests of panels: expected a replay of this hmdwarp; run it again")
        return cls(path.parent, summary, place)

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows of frames.csv, none where the file is not kept."""
        path = self.place / "frames.csv"
        lines = csv.DictReader(text_in(path, LIST).splitlines()) if path.exists() else ()
        return [{name: _number(text) for name, text in line.items()} for line in lines]

    def panels(self, name: str) -> dict[str, Pixels] | None:
        """Return the panels of a picture but for its false colours, None where it is not kept."""
        from PIL import Image

        path, labels = self.place / name, self.summary["digests"].get(name, {})
        if not path.exists():
            return None
        with opened(path, PICTURE_FILE, self.place) as file:
            strip = np.asarray(Image.open(file).convert("RGB"))
        width, height = self.summary["size"]
        found = zip(labels, panels_in(strip, len(labels) + 1, height), strict=False)
        return {label: panel if label == LATE else panel[:, :width] for label, panel in found}


def _number(text: str | None) -> float | str | None:
    try:
        return float(text) if text else None
    except ValueError:
        return text


@attrs.frozen
class _FigureChange:
    """A figure of both runs; None where a run lacks it."""

    key: str
    stored: float | None
    now: float | None

    @property
    def figure(self) -> Figure:
        """How it is written, and which way it gets better."""
        return figure_of(self.key)

    @property
    def size(self) -> float:
        """Change as a share of the larger value; what a run lacks counts as 0."""
        stored, now = self.stored or 0.0, self.now or 0.0
        return abs(now - stored) / max(abs(now), abs(stored), 1e-300)

    @property
    def is_better(self) -> bool | None:
        """Whether it is better now, None where neither way is."""
        higher = self.figure.higher_is_better
        return None if None in (higher, self.stored, self.now) else (self.now > self.stored) == higher  # type: ignore[operator]

    def texts(self) -> tuple[str, str, str]:
        """Return stored, now and change, with as many digits as tell them apart."""
        if self.stored is None or self.now is None:
            return self.figure.text(self.stored), self.figure.text(self.now), "–"
        change = (self.now - self.stored) * self.figure.scale
        digits = max(self.figure.digits, 1 - math.floor(math.log10(abs(change)))) if change else self.figure.digits
        written = attrs.evolve(self.figure, digits=min(digits, 15))
        is_large = self.stored and self.size >= 5e-5
        share = f" ({100 * (self.now - self.stored) / abs(self.stored):+.2f} %)" if is_large else ""
        return written.text(self.stored), written.text(self.now), f"{change:+.{written.digits}f}{share}"

    def entry(self) -> dict[str, Any]:
        values = {"name": self.key, "first": self.stored, "second": self.now, "unit": self.figure.unit}
        change = None if None in (self.stored, self.now) else self.now - self.stored  # type: ignore[operator]
        return values | {"change": change, "verdict": _WORDS[self.is_better]}


def _figures_table(changes: Sequence[_FigureChange]) -> Table:
    """Return changes as the table of every output: terminal, page, step summary."""
    lines = [
        Line((
            Cell(one.key.removeprefix("quality.") + f" [{one.figure.unit}]" * bool(one.figure.unit), "word"),
            *map(Cell, one.texts()),
            Cell(_WORDS[one.is_better], _STYLES[one.is_better]),
        ))
        for one in changes
    ]  # fmt: skip
    heads = [(head, "") for head in ("metric", "stored", "now", "change", "verdict")]
    return Table("", heads, lines, style="figures", label="Figures")


@attrs.frozen(eq=False)
class _PictureDiff:
    """A picture of both runs that differs."""

    name: str
    told: str  # in what it differs
    share: float = 0.0  # of the pixels
    largest: int = 0  # difference, of 255
    pictures: tuple[Pixels, ...] = ()  # stored, now, and the difference


@attrs.frozen(eq=False)
class RunDiff:
    """What differs between two runs, times left out."""

    first: StoredRun
    second: StoredRun
    # (key, value of the first, value of the second)
    setup: list[tuple[str, Any, Any]]
    # Beyond the tolerances, the largest change first.
    figures: list[_FigureChange]
    # All that were compared.
    compared: list[str]
    # How many figures differ, but no more than they may.
    allowed: int
    # Of frames.csv: how many rows differ, and what in the first that does.
    refreshes: list[str]
    pictures: list[_PictureDiff]
    # What does not make them differ, but may explain it.
    notes: list[str]
    within: str = ""  # tolerances, as they were named

    @property
    def is_equal(self) -> bool:
        """Whether nothing differs by more than the tolerances."""
        return not (self.setup or self.figures or self.refreshes or self.pictures)

    def told(self) -> str:
        """Return how much differs in one line: "4 figures worse, 1 better, 2 pictures"."""
        if self.is_equal:
            within = f"identical within {self.within} ({counted(self.allowed, 'figure')} changed)"
            return within if self.allowed else "identical except for timings"
        found = Counter(_WORDS[one.is_better] for one in self.figures)
        counts = [(found[word], word) for word in ("worse", "better", "changed") if found[word]]
        parts = [f"{count if at else counted(count, 'figure')} {word}" for at, (count, word) in enumerate(counts)]
        parts += [counted(len(self.setup), "setting")] * bool(self.setup)
        parts += [counted(len(self.pictures), "picture")] * bool(self.pictures)
        parts += [text.partition(" differ")[0] for text in self.refreshes]
        return f"{', '.join(parts)} ({f'beyond {self.within}' if self.within else 'no tolerance'})"

    def lines(self, *, figures: bool = True) -> list[str]:
        """Return what differs in lines: the set-up, the table of figures, refreshes, pictures."""
        return [
            *(f"{key}: {' -> '.join(_texts(a, b))}" for key, a, b in self.setup),
            *(_figures_table(self.figures).text().splitlines() if figures and self.figures else ()),
            *self.refreshes,
            *_some([f"{one.name}: {one.told}" for one in self.pictures]),
        ]

    def blocks(self) -> list[Any]:
        lines = self.lines(figures=False)
        return [*[_figures_table(self.figures)] * bool(self.figures), *[page.Sentences(lines)] * bool(lines)]

    def entry(self) -> dict[str, Any]:
        return {
            "equal": self.is_equal,
            "setup": [dict(zip(("name", "first", "second"), entry, strict=True)) for entry in self.setup],
            "figures": [one.entry() for one in self.figures],
            "refreshes": self.refreshes,
            "pictures": [attrs.asdict(one, filter=lambda field, _: field.name != "pictures") for one in self.pictures],
            "notes": self.notes,
        }

    def page(self, command: str) -> str:
        """Return the page: the figures, each picture beside its difference, both runs over time."""
        count = len(self.setup) + len(self.figures) + len(self.refreshes) + len(self.pictures)
        labels = ("stored", "now", f"absolute difference, x{_MAGNIFY}")
        choice = page.Choice("view", (("now", "now"), ("blink", "now and stored in turn")), "Middle picture")
        articles = []
        for one in (one for one in self.pictures if one.pictures):
            shown = [
                page.Picture.of(
                    label, picture, f"{one.name}, {label}", one.pictures[0] if label == "now" else None, "png"
                )
                for label, picture in zip(labels, one.pictures, strict=True)
            ]
            articles.append(page.Article([page.Heading(one.name, one.told), page.Group("panels", shown)]))
        over_time = metric_charts({"stored": self.first.rows(), "now": self.second.rows()})
        return page.Page(
            kind="diff",
            title="hmdwarp: run comparison",
            heading=("Run comparison:", counted(count, "difference")),
            facts=[page.fact("stored", self.first.named), page.fact("now", self.second.named), self.told()],
            command=command,
            remarks=self.notes,
            sections=(
                page.Section("Differences", self.blocks()),
                page.Section("Pictures", [choice, *articles] if articles else []),
                page.Section("Over time", [page.Group("charts", over_time)]),
            ),
            made_with=page.machine_pairs(*(self.second.summary[key] for key in ("hmdwarp", "machine", "clock"))),
        ).html()


_Allows = Callable[[str, Any, Any], bool]


def diff_runs(
    first: StoredRun,
    second: StoredRun,
    allows: _Allows = is_same,
    pixels: tuple[float, float] = (0.0, 0.0),
    within: str = "",
) -> RunDiff:
    """Return what differs between two replays by more than the tolerances.

    allows(key, stored, now): of figures. pixels: levels of 255 by which a pixel may differ, and the
    share of the pixels that may differ by more. within: both in words.
    Errors: InputError for files that cannot be read.
    """
    setup: list[tuple[str, Any, Any]] = []
    figures: list[_FigureChange] = []
    for key, a, b in _leaves(first.summary, second.summary):
        if key.partition(".")[0] in SECTIONS and not isinstance(a or b, str):
            figures.append(_FigureChange(key, a, b))
        elif not is_same(key, a, b):
            setup.append((key, a, b))
    ours, theirs = ({"version": run.summary["hmdwarp"], **run.summary["machine"]} for run in (first, second))
    notes = [
        f"another {name}: {ours.get(key)} -> {theirs.get(key)}; pictures may differ in their last digits"
        for name, key in (("driver", "gl_version"), ("renderer", "gl_renderer"), ("version", "version"))
        if ours.get(key) != theirs.get(key)
    ]
    changed = [one for one in figures if not is_same(one.key, one.stored, one.now)]
    beyond = [one for one in changed if not allows(one.key, one.stored, one.now)]
    same_rows = first.summary["digests"]["frames.csv"] == second.summary["digests"]["frames.csv"]
    refreshes = [] if same_rows else _refreshes(first, second, allows, notes)
    beyond.sort(key=lambda one: -one.size)
    pictures, compared, allowed = (
        [*_pictures(first, second, pixels)],
        [o.key for o in figures],
        len(changed) - len(beyond),
    )
    return RunDiff(first, second, setup, beyond, compared, allowed, refreshes, pictures, notes, within)


def _leaves(a: Any, b: Any, key: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the values of both by their keys, but for times and what names the machine."""
    ours, theirs = (dict(enumerate(one)) if isinstance(one, list) else {} if one is None else one for one in (a, b))
    if isinstance(ours, Mapping) and isinstance(theirs, Mapping) and (ours or theirs):
        for name in dict.fromkeys([*ours, *theirs]):
            if name not in _LEFT_OUT:
                yield from _leaves(ours.get(name), theirs.get(name), f"{key}.{name}" if key else str(name))
    else:
        yield key, a, b


def _refreshes(first: StoredRun, second: StoredRun, allows: _Allows, notes: list[str]) -> list[str]:
    ours, theirs = first.rows(), second.rows()
    if not ours or not theirs:
        missing = (first if not ours else second).named
        notes.append(f"frames.csv differs; {missing} has none, so single refreshes cannot be compared")
        return []
    if len(ours) != len(theirs):
        return [f"rows of frames.csv: {len(ours)} -> {len(theirs)}"]
    found = []
    for a, b in zip(ours, theirs, strict=True):
        apart = [
            f"{name}: {' -> '.join(_texts(a.get(name), b.get(name)))}"
            for name in FRAME_COLUMNS
            if name not in TIMED_COLUMNS
            and not (allows if name in QUALITY else is_same)(f"{ROWS}.{name}", a.get(name), b.get(name))
        ]
        if apart:
            found.append(f"frame {a['frame']:g} ({a['time_s']:.3f} s), eye {a['eye']:g}: {', '.join(_some(apart))}")
    return found and [f"{len(found)} of {counted(len(ours), 'row')} of frames.csv differ, the first: {found[0]}"]


def _pictures(first: StoredRun, second: StoredRun, pixels: tuple[float, float]) -> Iterator[_PictureDiff]:
    ours, theirs = ({**run.summary["digests"], "frames.csv": {}} for run in (first, second))
    for name in dict.fromkeys([*ours, *theirs]):
        here, there = ours.get(name), theirs.get(name)
        if here == there:
            continue
        kept, there_in = (first.panels(name), second.panels(name)), (first.named, second.named)
        if here is None or there is None:
            yield _PictureDiff(name, f"is not in {there_in[here is not None]}")
        elif kept[0] is None or kept[1] is None:
            yield _PictureDiff(name, f"differs, and is not kept in {there_in[kept[0] is not None]}")
        else:
            for label in dict.fromkeys([*here, *there]):
                found = _panel(f"{name}, {label}", kept[0].get(label), kept[1].get(label), *pixels)
                yield from [found] if found is not None and here.get(label) != there.get(label) else []


def _panel(name: str, a: Pixels | None, b: Pixels | None, levels: float, share: float) -> _PictureDiff | None:
    if a is None or b is None or a.shape != b.shape:
        sizes = ("none" if one is None else f"{one.shape[1]}x{one.shape[0]}" for one in (a, b))
        return _PictureDiff(name, f"pixels: {' -> '.join(sizes)}")
    apart = np.abs(a.astype(np.int16) - b).max(axis=2)
    if (beyond := float((apart > levels).mean())) <= share:
        return None
    magnified = np.repeat(np.minimum(apart * _MAGNIFY, 255).astype(np.uint8)[..., None], 3, axis=2)
    told = f"{100 * beyond:.2g} % of the pixels differ, by at most {apart.max()} of 255"
    return _PictureDiff(name, told, beyond, int(apart.max()), (a, b, magnified))


def _some(texts: list[str]) -> list[str]:
    """Return the first few, and how many more there are."""
    return texts if len(texts) <= _SOME + 1 else [*texts[:_SOME], f"and {len(texts) - _SOME} more"]


def _texts(*values: Any) -> list[str]:
    """Return values that differ with six digits, with all where those are equal."""
    texts = [f"{value:.6g}" if isinstance(value, float) else str(value) for value in values]
    texts = [str(value) for value in values] if len(set(texts)) == 1 else texts
    return ["–" if value is None else text for value, text in zip(values, texts, strict=True)]
