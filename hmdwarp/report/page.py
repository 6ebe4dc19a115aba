"""The builder of all pages: a title, facts, and sections of blocks, declared as data.

A page holds its styles, charts and pictures and loads nothing from the network. Texts are escaped,
but for those made as Markup. The same content gives the same page.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any

import attrs
from markupsafe import Markup

from . import run_texts
from .charts import css_variables
from .files import jpeg_bytes, png_bytes

_CLOCK_NAMES = {"gpu": "GPU timer queries", "wall": "wall clock around finished GPU work"}
Pairs = list[tuple[str, str]]
texts = run_texts.texts


@attrs.frozen
class Tile:
    label: str
    unit: str
    text: str
    note: str
    # The compared run's figure.
    baseline: str | None = None


@attrs.frozen
class Text:
    text: str
    style: str = "small"


@attrs.frozen
class Heading:
    text: str
    note: str = ""


@attrs.frozen
class Sentences:
    sentences: Sequence[str]
    # Classes of the lines, if they have any.
    styles: Sequence[str] = ()
    style: str = ""


@attrs.frozen
class Terms:
    pairs: Sequence[tuple[str, str]]
    style: str = ""


@attrs.frozen
class Chart:
    """A chart in one or more versions."""

    heading: str
    # (measure, svg, what it says in words)
    versions: tuple[tuple[str, str, str], ...]
    style: str = "big"

    @classmethod
    def of(cls, heading: str, svg: str, words: str, style: str = "big") -> Chart:
        """Make a chart of one version; words: the chart for readers who cannot see it."""
        return cls(heading, (("", svg, words),), style)

    @classmethod
    def over_time(cls, heading: str, svg: str) -> Chart:
        return cls.of(heading, svg, f"{heading} over time", "")


@attrs.frozen
class Picture:
    caption: str
    source: str  # data URI
    alt: str
    size: tuple[int, int] | None = None
    # Data URI of another that takes its place in turn, where the section's choice says so.
    over: str = ""

    @classmethod
    def of(cls, caption: str, picture: Any, alt: str, over: Any = None, kind: str = "jpeg") -> Picture:
        """Make one of an (h, w, 3) uint8 sRGB picture, shown in its size. kind: as of data_uri."""
        size = (picture.shape[1], picture.shape[0])
        return cls(caption, data_uri(picture, kind), alt, size, "" if over is None else data_uri(over, kind))


@attrs.frozen
class Choice:
    """Radio buttons that choose the version of the section's charts."""

    name: str
    # (measure, label)
    measures: Sequence[tuple[str, str]]
    legend: str = "Error measured by"


@attrs.frozen
class Group:
    """Blocks side by side: `charts`, `panels` or `pairs`."""

    style: str
    blocks: Sequence[Any]


@attrs.frozen
class Fold:
    """Blocks under a line that opens and closes them."""

    label: str
    blocks: Sequence[Any]
    note: str = ""
    is_open: bool = False


@attrs.frozen
class Article:
    """Blocks on a card."""

    blocks: Sequence[Any]
    id: str = ""
    style: str = ""


@attrs.frozen
class Section:
    """A part of the page; those with an id stand in the list under the title."""

    heading: str
    # Those that are None or empty are left out.
    blocks: Sequence[Any]
    id: str = ""
    style: str = ""
    # For readers who cannot see it, where there is no heading.
    label: str = ""


@attrs.frozen
class Page:
    kind: str  # of hmdwarp's commands: "bench"
    title: str  # of the window
    heading: tuple[str, str | None]
    facts: Sequence[str]
    command: str
    # None and sections without blocks are left out.
    sections: Sequence[Section | None]
    made_with: Sequence[tuple[str, str]]
    remarks: Sequence[str] = ()  # lines under the command
    shared: Sequence[str] = ()  # of all tables and charts, for captions: "scene room", "960x600"

    def html(self) -> str:
        from jinja2 import Environment, PackageLoader, StrictUndefined

        environment = Environment(
            loader=PackageLoader("hmdwarp.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
            lstrip_blocks=True,
        )  # fmt: skip
        script = resources.files(__package__).joinpath("templates/page.js").read_text(encoding="utf-8")
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        environment.filters["pieces"] = lambda text: (
            [text] if isinstance(text, Markup) else run_texts.name_pieces(text, r"|(?<=[._+])(?=[a-z])")
        )
        return environment.get_template("page.html").render(
            page=self,
            script=script if self.kind == "replay" else "",
            digest=f"sha256-{digest}",
            sections=[section for section in self.sections if section is not None and any(section.blocks)],
            light=css_variables(dark=False),
            dark=css_variables(dark=True),
        )


def fact(label: str, text: object, after: str = "") -> str:
    """Return a fact under the title, its text in bold."""
    return Markup("{}<b>{}</b>{}").format(f"{label} " if label else "", text, after)


def notes_section(notes: Sequence[str]) -> Section:
    return Section("Notes", [Sentences(notes)] if notes else [], style="notes")


def machine_pairs(version: str, machine: Mapping[str, Any], clock: str | None) -> Pairs:
    """Return what a run was made with. clock: its name in summary.json."""
    labels = {"gl_renderer": "GL renderer", "gl_version": "GL version", "cpu_count": "CPU cores"}
    pairs = [("hmdwarp", version), *((labels[key], str(machine[key])) for key in labels if key in machine)]
    return [*pairs, ("Clock", _CLOCK_NAMES.get(clock or "", str(clock)))]


def minutes(seconds: float) -> str:
    return f"{seconds / 60:.1f} min"


def data_uri(picture: Any, kind: str = "jpeg") -> str:
    """Return a picture as a data URI. kind: jpeg or png."""
    content = jpeg_bytes(picture) if kind == "jpeg" else png_bytes(picture)
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"


def reading_section(page: str, *more: tuple[str, str], **values: str) -> Section:
    """Return the section that explains a page: its texts, with values in their places, and more."""
    pairs = [(term, text.format(**values)) for term, text in texts(page)["to_read"].items()]
    return Section("How to read this", [Terms([*pairs, *more])], id="reading", style="reading")
