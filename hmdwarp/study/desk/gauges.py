"""The parts of a desk's screen that show numbers: progress, the head, the question's scale."""

from __future__ import annotations

import math

from ._base import DeskState, Question
from .cells import Glyphs, Row, plain, spread, wrapped
from .words import number, span

_TICKS = (0.25, 0.5, 1, 2, 5, 10, 20, 25, 50, 100)
_CELLS_A_TICK = 5  # a number of three digits, and room


def progress(step: str, done: float, width: int, glyphs: Glyphs) -> Row:
    """trial 3 of 12  ████░░░░  25 %"""
    share = min(1.0, max(0.0, done)) if math.isfinite(done) else 0.0
    room = max(4, width - len(step) - 12)
    full = math.floor(room * share)
    bar: Row = [
        ("class:bar", glyphs.full * full),
        ("class:rest", glyphs.empty * (room - full)),
    ]  # a rest in the same green looks done
    return [("bold", f" {step}  "), *bar, ("", f"  {math.floor(100 * share):3d} %")]


def head_rows(state: DeskState, width: int, glyphs: Glyphs) -> list[Row]:
    """Where the head is and looks, two rows, and the pictures: 0 in the middle of a bar, to the right what is to the right."""
    pictures: Row = [("", f" pictures {state.rate_hz:5.1f}/s  missed {state.missed}")]
    if state.position_m is None or state.turned_deg is None:
        return [pictures, [("", " head: none yet")]]
    x, y, z = state.position_m
    where: Row = [("", f"head {x:+.2f} {y:+.2f} {z:+.2f} m ")]
    room = max(5, (width - 47) // 3 | 1)
    row: Row = []  # turns to the left are positive
    for name, degrees, most in zip(("yaw", "pitch", "roll"), state.turned_deg, (-180.0, 90.0, -90.0), strict=True):
        row += [("", f" {name} {degrees:+4.0f}{glyphs.degree} "), ("class:bar", gauge(degrees, most, room, glyphs))]
    return [spread(pictures, where, width, glyphs.more), row]


def gauge(value: float, most: float, cells: int, glyphs: Glyphs) -> str:
    """A bar of `cells` (odd) from -most to most, which may be negative, with a mark at value; beyond its ends the mark stays there."""
    place = round((min(1.0, max(-1.0, value / most)) + 1.0) / 2.0 * (cells - 1)) if math.isfinite(value) else -1
    return "".join(glyphs.full if k == place else glyphs.mid if k == cells // 2 else glyphs.dot for k in range(cells))


def question_rows(question: Question | None, width: int, rows: int, glyphs: Glyphs) -> list[Row]:
    """What is asked, in exactly `rows` (4 or more): its words, the scale with what is entered, the anchors."""
    if question is None:
        return [[("class:none", " none now")], *([] for _ in range(rows - 1))]
    words = wrapped(plain(question.text), width - 2, rows - 3, glyphs.more)
    entered = f"entered {number(question.entered)}" if question.entered is not None else "nothing entered"
    anchors = "; ".join(f"{number(value)} {plain(text)}" for value, text in question.anchors) or span(question)
    out: list[Row] = [[("bold", f" {line}")] for line in words]
    out.append(
        spread([("", " "), *scale(question, width - 20, glyphs)], [("bold", f" {entered} ")], width, glyphs.more)
    )
    out += [[("", f" {line}")] for line in wrapped(anchors, width - 2, rows - len(out), glyphs.more)]
    return [*out[:rows], *([] for _ in range(rows - len(out)))]


def scale(question: Question, cells: int, glyphs: Glyphs) -> Row:
    """1────2────3────4 with the entered value's cell turned over."""
    span_ = question.most - question.least
    if span_ <= 0 or cells < 4:
        return []
    least = max(question.step, 1.0 if span_ >= 3 else 0.0)
    tick = next((t for t in _TICKS if t >= least and (cells - 1) * t / span_ >= _CELLS_A_TICK), span_)
    line = [glyphs.line] * cells
    for k in range(math.floor(span_ / tick + 1e-9) + 1):
        text = number(question.least + k * tick)
        place = min(round(k * tick / span_ * (cells - 1)), cells - len(text))
        line[place : place + len(text)] = text
    if question.entered is None:
        return [("", "".join(line))]
    at = round(min(1.0, max(0.0, (question.entered - question.least) / span_)) * (cells - 1))
    return [("", "".join(line[:at])), ("class:entered", line[at]), ("", "".join(line[at + 1 :]))]
