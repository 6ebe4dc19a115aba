"""A desk's screen as rows of text, from its state alone: no terminal, no clock.

What is looked for in the dark, with somebody under a headset, stands at the top and does not move: which trial, what is going on, what to
do, how long it takes, and what is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import attrs

from ._base import DeskState
from .cells import Glyphs, Row, cut, end_of, fitted, plain, spread, wrapped
from .entry import Entry
from .gauges import head_rows, progress, question_rows
from .words import clock

LEAST = (60, 20)  # columns, rows
ROOMY = 24  # rows from which on there are blank ones between the blocks
STALE_S = 3.0
_TIMED = re.compile(r"( *\d+(?::\d\d)+  |)(.*)", re.DOTALL)  # how a line of the journal begins, as screen.py writes it
_LOUD = re.compile(r"\b(PILOT|REHEARSAL|SIMULATED)\b")
HINTS = {
    "reading": "g once they agree to the text, s if they do not.",
    "waiting": "The participant goes on when ready; c does it for them.",
    "showing": "The participant looks. Nothing to do.",
    "asking": "The participant answers. Said aloud: type it.",
    "break": "A break. c ends it.",
    "paused": "Everything waits. c continues.",
    "over": "The session is over.",
}
KEYS = [
    ("p", "pause"), ("c", "continue"), ("b", "break"), ("r", "repeat question"), ("a", "answer"), ("k", "skip"), ("m", "remark"),
    ("g", "agree"), ("s", "stop"), ("?", "help"),
]  # fmt: skip
HELP = [
    ("p c", "pause, and continue; what was on is shown or asked again"),
    ("b", "a break as soon as there may be one; c ends it"),
    ("r", "ask the last question again; the old answer is kept beside the new"),
    ("a, digits", "type the answer that the participant says; Enter, then Enter"),
    ("k", "leave the question without an answer"),
    ("m", "a remark for the journal of the session"),
    ("g", "the participant has read the text and agrees"),
    ("s", "stop now, without a reason; nothing is lost"),
    ("Ctrl-C", "stop the program; Esc: leave a line or this help"),
]


@attrs.frozen
class Scene:
    """All that a screen shows. heard_s: how long ago the state came. journal: the newest last."""

    state: DeskState
    entry: Entry
    journal: Sequence[str] = ()
    heard_s: float = 0.0
    glyphs: Glyphs = Glyphs()


def page(scene: Scene, width: int, height: int) -> list[Row]:
    """`height` rows of exactly `width` cells."""
    if width < LEAST[0] or height < LEAST[1]:
        rows = _cramped(scene, width, height)
    else:
        top, bottom = _top(scene, width, height), _bottom(scene, width)
        room = height - len(top) - len(bottom)
        rows = [*top, *_middle(scene, width, room), *bottom]
    return [fitted(row, width, scene.glyphs.more) for row in rows[:height]]


def _cramped(scene: Scene, width: int, height: int) -> list[Row]:
    state = scene.state
    rows: list[Row] = [
        [("class:phase", _phase_text(state)), ("", f" {plain(state.step)}")],
        _notice(scene),
        [("", f"This window is {width} x {height}; the desk")],
        [("", f"wants {LEAST[0]} x {LEAST[1]} or more.")],
    ]
    rows = [row for row in rows if row][: max(1, height - 1)]
    rows += [[] for _ in range(height - 1 - len(rows))]
    return [*rows, _typing(scene, width)]


def _top(scene: Scene, width: int, height: int) -> list[Row]:
    state, glyphs, gap = scene.state, scene.glyphs, [[]] if height >= ROOMY else []
    left_s = None if state.phase == "break" and not state.left_s else state.left_s  # it ends when somebody says so
    left = f"   {clock(left_s)} left of this step" if left_s is not None else ""
    times: Row = [("", f" {clock(state.elapsed_s)} since the start"), ("bold", left)]
    if state.condition:
        times = spread(times, [("", f"condition: {plain(state.condition)} ")], width, glyphs.more)
    return [
        _heading(state, width, glyphs),
        *gap,
        progress(plain(state.step), state.done, width, glyphs),
        times,
        *gap,
        [
            ("", " "),
            (f"class:phase.{state.phase or 'none'}", f" {_phase_text(state)} "),
            ("", "  " + HINTS.get(state.phase, "")),
        ],
        _notice(scene),
        *(() if scene.entry.mode == "help" else _numbers(state, width, height, glyphs)),
    ]


def _numbers(state: DeskState, width: int, height: int, glyphs: Glyphs) -> list[Row]:
    return [
        *head_rows(state, width, glyphs),
        _rule("question", width, glyphs),
        *question_rows(state.question, width, 5 if height >= ROOMY else 4, glyphs),
    ]


def _heading(state: DeskState, width: int, glyphs: Glyphs) -> Row:
    heading = plain(state.heading)
    loud = list(dict.fromkeys(_LOUD.findall(heading)))
    rest = re.sub(r"\s{2,}", " ", _LOUD.sub("", heading)).strip(" ,;:·-|()[]") if loud else heading
    right: Row = [("class:loud", f" {' '.join(loud)} ")] if loud else []
    return spread([("class:heading", f" {rest}")], right, width, glyphs.more, "class:heading")


def _phase_text(state: DeskState) -> str:
    return (state.phase or "starting").upper()


def _notice(scene: Scene) -> Row:
    if scene.heard_s >= STALE_S and scene.state.phase not in ("", "over"):
        return [
            ("", " "),
            ("class:loud", f" NO NEWS FOR {clock(scene.heard_s)}: the pictures stand still, or the program is busy "),
        ]
    notice = plain(scene.state.notice)
    return [("", " "), ("class:loud", f" {notice.upper()} ")] if notice else []


def _rule(name: str, width: int, glyphs: Glyphs) -> Row:
    return [("class:rule", f"{glyphs.line * 2} {name} {glyphs.line * width}"[:width] if name else glyphs.line * width)]


def _middle(scene: Scene, width: int, room: int) -> list[Row]:
    if room <= 0:
        return []
    if scene.entry.mode == "help":
        rows: list[Row] = [[("class:key", f" {keys:<10}"), ("", words)] for keys, words in HELP]
        name = "help, Esc closes it"
    else:
        rows = _journal(scene, width)[-(room - 1) :] if room > 1 else []
        name = "journal"
    rows = rows[: room - 1]
    return [_rule(name, width, scene.glyphs), *rows, *([] for _ in range(room - 1 - len(rows)))]


def _journal(scene: Scene, width: int) -> list[Row]:
    """Each line in at most two rows: what is cut off in one is often what happened."""
    more = scene.glyphs.more
    out: list[Row] = []
    for line in scene.journal:
        time, text = _TIMED.match(plain(line)).groups()  # type: ignore[union-attr]
        rows = wrapped(text, max(1, width - 2 - len(time)), 2, more)
        out += [
            [("", f" {cut(time if k == 0 else ' ' * len(time), width - 2, more)}{row}")] for k, row in enumerate(rows)
        ]
    return out


def _bottom(scene: Scene, width: int) -> list[Row]:
    rows: list[Row] = [_rule("", width, scene.glyphs)]
    typing = scene.entry.mode not in ("keys", "help")
    notes = wrapped(scene.entry.note, width - 2, 2, scene.glyphs.more) if scene.entry.note else []
    note_style = "class:refused" if scene.entry.loud else "class:note"
    rows += [[(note_style, f" {line}")] for line in notes[: 1 if typing else 2]]
    if typing:
        rows.append(_typing(scene, width))
    rows += [[] for _ in range(3 - len(rows))]
    return [*rows, *_keys(scene, width)]


def _typing(scene: Scene, width: int) -> Row:
    """The line that is being typed, with the cursor at its end."""
    entry = scene.entry
    if entry.mode in ("keys", "help"):
        return [("class:refused" if entry.loud else "class:note", f" {entry.note}")]
    prompt = f" {entry.prompt(scene.state.question)} "
    text = end_of(entry.text, max(1, width - len(prompt) - 2), scene.glyphs.more)
    return [("class:prompt", prompt), ("bold", text), ("[SetCursorPosition]", "")]


def _keys(scene: Scene, width: int) -> list[Row]:
    if scene.entry.mode in ("answer", "sure", "remark"):
        pairs = (("Enter", "sends"), ("Esc", "leaves the line"), ("Ctrl-U", "empties it"))
        return [[piece for key, name in pairs for piece in (("", " "), ("class:key", key), ("", f" {name} "))], []]
    rows: list[Row] = [[]]
    used = 0
    for key, name in KEYS:
        room = len(key) + len(name) + 3
        if used + room > width and len(rows) < 2:
            rows.append([])
            used = 0
        rows[-1] += [("", " "), ("class:key", key), ("", f" {name} ")]
        used += room
    return [*rows, *([] for _ in range(2 - len(rows)))]
