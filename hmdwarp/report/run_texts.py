"""A run in words: its source, the frames in transit, what the client holds, a live run's lines."""

from __future__ import annotations

import functools
import math
import re
import textwrap
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from decimal import ROUND_HALF_UP, Decimal
from importlib import resources
from typing import TYPE_CHECKING, Any

import attrs
from markupsafe import Markup

from ..base import errors
from ..metrics import JOD, STAGES, Figure, metrics_in_order

if TYPE_CHECKING:
    from rich.table import Table as TerminalTable

ALPHA = 0.05
# Words that other packages take from here too.
counted, listed = errors.counted, errors.listed


@functools.cache
def texts(page: str) -> Mapping[str, Any]:
    """Return the longer texts of a page: `notes` of its sections, terms `to_read` it."""
    content = resources.files(__package__).joinpath("templates/texts.toml").read_text(encoding="utf-8")
    found: Mapping[str, Any] = tomllib.loads(content)[page]
    return found


def p_text(p: float | None) -> str:
    """Return p as ".226", below .01 as ".0098", below .0001 as "3e-7"."""
    if p is None or math.isnan(p):
        return "–"
    if p < 1e-4:
        digit, _, power = f"{p:.0e}".partition("e")
        return f"{digit}e{int(power)}"
    # Exact p are dyadic fractions that often end in 5: .3125 is printed as .313, not to the even
    # digit.
    text = str(Decimal(p).quantize(Decimal("0.001" if p >= 0.01 else "0.0001"), ROUND_HALF_UP))
    return text.removeprefix("0") if p < 0.9995 else text


def p_is(p: float) -> str:
    return f"p = {p_text(p)}"


def signed(value: float | None, digits: int = 2) -> str:
    """Return "+1.30", "-0.56" or "0.00"; a dash for None."""
    return plain(value, digits, "+")


def interval(low: float | None, high: float | None, digits: int = 2) -> str:
    """Return "-0.16 .. +0.75"; a dash if an end is None."""
    return "–" if low is None or high is None else f"{signed(low, digits)} .. {signed(high, digits)}"


def plain(value: float | None, digits: int = 2, sign: str = "") -> str:
    """Return "2.62", and "0.00" for what rounds to it from below; a dash for None."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:{sign}.{digits}f}"
    return text.lstrip("+-") if float(text) == 0 else text


def pair_text(baseline: str, condition: str) -> str:
    """Return "forward over none, 200 ms": the common end of the two names is written once."""
    head, comma, tail = condition.rpartition(", ")
    return f"{head if comma and baseline.endswith(f', {tail}') else condition} over {baseline}"


def name_pieces(text: str, also: str = "") -> list[str]:
    """Split a long name after colon, comma or blank, where it may break; also: more patterns."""
    return re.split(rf"(?<=[:, ])(?=\S){also}", text)


Heads = Sequence[tuple[str, str]]


@attrs.frozen
class Cell:
    text: str
    # Numbers stand at the right; `word`, `tail`, `best`, `meter` are other styles.
    style: str = ""


@attrs.frozen
class Line:
    """One line of a table; the first cell is its heading."""

    cells: tuple[Cell, ...]
    # Starred and bold.
    is_marked: bool = False
    # A heading above the line, where a group of lines begins.
    group: str = ""


@attrs.frozen
class Table:
    """A table of texts."""

    caption: str
    # (label, unit) of each column.
    heads: Heads
    lines: Sequence[Line]
    has_marks: bool = False
    # Two columns without heads, as narrow as they can be.
    is_pairs: bool = False
    style: str = ""
    # What a table without a caption is called.
    label: str = ""

    @classmethod
    def of(
        cls, caption: str, heads: Heads, lines: Iterable[Sequence[str]], words: int | Sequence[int] = 1, **more: Any
    ) -> Table:
        """Make a table of texts. words: the columns of words, or how many of the first are."""
        worded = range(words) if isinstance(words, int) else words
        made = [
            Line(tuple(Cell(text, "word" if number in worded else "") for number, text in enumerate(texts)))
            for texts in lines
        ]
        return cls(caption, tuple(heads), made, **more)

    def style_of(self, column: int) -> str:
        """Return the style of a column's head: as its cells, if they are words or tails."""
        style = self.lines[0].cells[column].style.partition(" ")[0] if self.lines else ""
        return style if style in ("word", "tail") else ""

    def markdown(self) -> str:
        heads = [" ".join(filter(None, head)) for head in self.heads]
        rule = ["---" if not self.lines or self.style_of(n) == "word" else "---:" for n in range(len(heads))]
        lines = [heads, rule, *([cell.text for cell in line.cells] for line in self.lines)]
        return "".join(f"| {' | '.join(line)} |\n" for line in lines)

    def terminal(self, columns: Sequence[int] = (), /, **titles: str) -> TerminalTable:
        """Return these columns, or all, for the terminal: heads above units, the best bold.

        Names fold where there is no room. A marked line begins with a star; in a table without
        marks the best has one.
        """
        from rich.text import Text

        columns = columns or range(len(self.heads))
        written: Any = {name: Text(text) for name, text in titles.items()}
        table = terminal_table(["*"] * self.has_marks, **written)
        for at in columns:
            is_name, dim = at == 0 or self.style_of(at) == "word", "dim" if self.style_of(at) == "tail" else None
            how: Any = {"justify": "left" if is_name else "right", "overflow": "fold", "no_wrap": not is_name}
            label, unit = self.heads[at]
            head = "\n".join([*textwrap.wrap(label, 60 if is_name else 20), *([unit] if unit else [])])
            table.add_column(head, style=dim, **how)
        for line in self.lines:
            if line.group:
                table.add_section()
                table.add_row(*[""] * self.has_marks, Text(line.group, "bold"))
            cells = [Text("*" * line.is_marked, "bold green")] * self.has_marks
            for cell in (line.cells[at] for at in columns):
                is_best = cell.style == "best"
                starred = is_best and not self.has_marks
                cells.append(Text(cell.text + " *" * starred, ("bold green" if starred else "bold") if is_best else ""))
            table.add_row(*cells)
        return table

    def text(self) -> str:
        """Return the table as plain text in columns; numbers stand at the right."""
        heads = [" ".join(filter(None, head)) for head in self.heads]
        lines = [heads, *([cell.text for cell in line.cells] for line in self.lines)]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        sides = [f"{'<' if self.style_of(n) == 'word' else '>'}{wide}" for n, wide in enumerate(widths)]
        return "\n".join("  ".join(map(format, line, sides)).rstrip() for line in lines)

    def html(self, columns: Sequence[int] | None = None) -> str:
        """Return these columns, or all, as HTML for a notebook; the best of a line has a star."""
        chosen = range(len(self.heads)) if columns is None else columns
        sides = ["left" if self.style_of(n) == "word" else "right" for n in chosen]
        lines = [("th", [f"{label} [{unit}]" if unit else label for label, unit in (self.heads[n] for n in chosen)])]
        for cells in (line.cells for line in self.lines):
            lines.append(("td", [cells[n].text + " *" * (cells[n].style == "best") for n in chosen]))
        cell, rows = Markup('<{0} style="text-align: {1}">{2}</{0}>').format, Markup()
        for tag, texts in lines:
            rows += Markup("<tr>{}</tr>").format(Markup().join(map(functools.partial(cell, tag), sides, texts)))
        return str(Markup("<table>{}</table>").format(rows))


def terminal_table(
    heads: Iterable[str] = (), lines: Iterable[Iterable[str]] = (), *, words: int = 1, **options: Any
) -> TerminalTable:
    """Return a table for the terminal. words: columns from the left that may wrap."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    looks: Any = {"padding": (0, 1, 0, 0), "box": SIMPLE_HEAD, "show_edge": False, "pad_edge": False}
    table = Table(**looks | options, title_justify="left", caption_justify="left")
    for number, head in enumerate(heads):
        table.add_column(head, justify="left" if number < words else "right", no_wrap=number >= words)
    for line in lines:
        table.add_row(*map(Text, line))
    return table


Summary = Mapping[str, Any]
Pairs = list[tuple[str, str]]

QUALITY_FIGURES = tuple(metric.figure for metric in metrics_in_order())
TIME_FIGURES = tuple(Figure(stage, stage.capitalize(), "ms", 2, higher_is_better=False) for stage in STAGES)
_SHARES, _RATES = ("filled", "share", "truth_preferred"), ("mbit_s", "layers_mbit_s", "up_mbit_s")
_BY_NAME = {figure.name: figure for figure in (*QUALITY_FIGURES, JOD)}
_BY_NAME |= {f"{figure.name}_ms": figure for figure in TIME_FIGURES}
_BY_NAME |= {name: Figure(name, name, "%", 2, 100) for name in _SHARES}
_BY_NAME |= {name: Figure(name, name, "Mbit/s", 2, higher_is_better=False) for name in _RATES}


def figure_of(key: str) -> Figure:
    """Return how a number is written, by the last part of its dotted key that has a declaration."""
    known = [part for part in key.split(".") if part in _BY_NAME]
    return _BY_NAME[known[-1]] if known else Figure(key, key, "ms" if key.endswith("_ms") else "", 0)


def source_facts(summary: Summary) -> Pairs:
    """Return (kind, text) of the frames' origin: a scene, or a folder, its camera and the eyes."""
    recorded = summary.get("recorded")
    if recorded is None:
        return [("scene", summary["scene"])]
    across, down = recorded["fov_deg"]
    camera = f"{'×'.join(map(str, recorded['size']))}, {across:.1f} × {down:.1f} degrees"
    distance = recorded["eye_distance_mm"]
    eyes = f"both, the right one {distance:g} mm from the camera" if distance else "one, the camera's"
    frames = f"{recorded['folder']} ({recorded['frames']}, {recorded['layout']})"
    return [("recorded frames", frames), ("camera", camera), ("eyes", eyes)]


def eyes_text(summary: Summary) -> str:
    """Return whose time it is that all eyes take together."""
    recorded = summary.get("recorded")
    return "both eyes" if recorded is None or recorded["eye_distance_mm"] else "the camera's eye"


def drawing_text(summary: Summary) -> str:
    """Return what the server does before it sends a frame."""
    return "drawing" if "recorded" not in summary else "reading the recorded frame"


def axes_of_traces(summaries: Iterable[Summary]) -> dict[str, str]:
    """Return the axes in which each recorded trace was read, by its name."""
    return {str(summary["trace"]): str(summary["trace_axes"]) for summary in summaries if summary.get("trace_axes")}


def filled_rows(summary: Summary) -> Pairs:
    """Return (fill, share of all pixels) of each step of the chain, then the pixels left empty."""
    filled = (summary.get("filled") or {}).items()
    return [("left empty" if name == "empty" else f"fill {name}", f"{100 * share:.2f} %") for name, share in filled]


def model_rows(summary: Summary) -> Pairs:
    """Return (model, its size) of each that the client drew for itself, and what crossed for it."""
    rows = []
    for model in summary.get("client_models") or ():
        geometry_mb = f"{model['geometry_bytes'] / 1e6:.1f} MB"
        if "share" not in model:
            *_, kept = model  # how many things it holds comes last
            rows.append((f"client's {kept}", f"{model[kept]}, room of {geometry_mb}"))
        else:
            named = f"client's model, {100 * model['share']:g} % of the triangles, textures at {model['texture']:g}"
            textures_mb = f"{model['texture_bytes'] / 1e6:.1f} MB"
            rows.append((named, f"{model['triangles']} triangles {geometry_mb}, textures {textures_mb}"))
        if "start_up_bytes" in model:
            first = model["first_picture_bytes"]
            whole = "no whole picture" if first is None else f"{first / 1e6:.2f} MB before the first whole picture"
            ends = (f"{model[key] / 1e6:.2f} MB" for key in ("start_up_bytes", "arrived_bytes"))
            rows.append(("of that crossed, packed", f"{next(ends)} at the start, {whole}, {next(ends)} in all"))
    return rows


def response_rows(summary: Summary, *names: str) -> Pairs:
    """Return (part, mean ms) of the response time, its median and p95 last; names: some alone."""
    link = summary.get("link") or {}
    # With --response fixed a frame is as old as the latency says, whatever the stages took here.
    kind = "response time" if link.get("response") == "sum" else "latency plus this machine's stages"
    took = link.get("response_ms") or {}
    words = {"kind": kind, "drawing": drawing_text(summary), "eyes": eyes_text(summary)}
    labels = texts("link")["response"]
    return [(labels[name].format(**words), f"{took[name]:.2f} ms") for name in names or labels if took.get(name)]


def frame_rows(summary: Summary) -> Pairs:
    """Return (outcome, number of frames), without outcomes of no frame."""
    frames = (summary.get("link") or {}).get("frames") or {}
    return [(outcome, str(frames[name])) for name, outcome in texts("link")["frames"].items() if frames.get(name)]


def coding_rows(summary: Summary) -> Pairs:
    """Return the data rate, of each layer too, and the time and loss of the codec."""
    link = summary.get("link") or {}
    if "mbit_s" not in link:
        return []
    coded = " uncompressed" if link["codec"] == "none" else ""
    rows = [(f"rate, {eyes_text(summary)}", f"{link['mbit_s']:.1f} Mbit/s{coded}")]
    layers: Mapping[str, float] = link.get("layers_mbit_s") or {}
    if len(layers) > 1:
        rows.append(("of that", ", ".join(f"{name.replace('_', ' ')} {rate:.1f}" for name, rate in layers.items())))
    if "up_mbit_s" in link:
        rows.append(("head poses to the server", f"{link['up_mbit_s']:.2f} Mbit/s"))
    if link["codec"] != "none":
        rows.append(("codec", link["codec"]))
        rows += [(label, _with_unit(link.get(name), unit)) for name, (label, unit) in texts("link")["coding"].items()]
    if "proxy" in link:
        proxy = link["proxy"]
        passes = proxy["warp"] if proxy["fill"] == "none" else f"{proxy['warp']} + {proxy['fill']}"
        coded = " uncompressed" if proxy["codec"] == "none" else f", {proxy['codec']}"
        took = proxy["time_ms"].get("total", {}).get("median")
        rows += [
            ("proxy", passes),
            ("from the server to the proxy", f"{proxy['latency_ms']:g} ms, {proxy['mbit_s']:.1f} Mbit/s{coded}"),
            ("the proxy's warp to fill, one eye (median)", _with_unit(took, "ms")),
        ]
    return rows


def _with_unit(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.1f} {unit}"


_HARDLY = 0.05  # of the refreshes: so many may be late without one being missed, where pictures queue


def waited_text(live: Mapping[str, Any]) -> str:
    """Return what to say where a display waits for late pictures; "" where not."""
    share = live["over"] / max(1, live["timed"])
    if live["missed"] or share < _HARDLY:
        return ""
    return f"this display waits for each picture, and {share:.0%} took longer than a refresh"
