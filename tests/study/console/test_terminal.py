"""The experimenter's screen in a real pseudo-terminal, driven by keys, with a session's program
behind it that is also killed.
"""

from __future__ import annotations

import ast
import os
import re
import signal
import socket
import termios
from pathlib import Path

import pytest

pytest.importorskip("textual", reason="the experimenter's console needs textual: pip install '.[study]'")
pytest.importorskip("pexpect", reason="these tests drive a pseudo-terminal by pexpect")
pytest.importorskip("pyte", reason="these tests read a screen by pyte")

from hmdwarp.study.console.line_console import subject_of
from hmdwarp.study.console.message_socket import MessageSocket
from hmdwarp.study.console.screen_text import HELP
from hmdwarp.study.console.terminal_console import TerminalConsole

from .played import ASKING, STATES
from .terminals import Terminal, played, played_by_a_shell


@pytest.fixture
def log(tmp_path) -> Path:
    return tmp_path / "asked.log"


def asked(log: Path) -> list[tuple[str, object]]:
    return [ast.literal_eval(line) for line in log.read_text(encoding="utf-8").splitlines() if line.startswith("(")]


def show(log: Path, state: str) -> None:
    new = log.with_suffix(".new")
    new.write_text(state, encoding="utf-8")
    new.replace(log.with_suffix(".state"))


def do(terminal: Terminal) -> None:
    """Have the session do what it was started for, once its console is there."""
    terminal.until("SHOWING")
    terminal.keys("r")


def left_the_page(terminal: Terminal) -> bool:
    """The last page switched to is the one the shell is on, and the cursor is to be seen."""
    pages = re.findall(rb"\x1b\[\?1049[hl]", terminal.raw)
    cursor = re.findall(rb"\x1b\[\?25[hl]", terminal.raw)
    return pages[-1:] == [b"\x1b[?1049l"] and cursor[-1:] in ([], [b"\x1b[?25h"])


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_a_session_by_keys(log, size):
    """Every key gives its command, wrong answers are refused with words, and the terminal is
    afterwards as it was.
    """
    with played(log, "--states", "reading", size=size) as terminal:
        before = terminal.modes()
        terminal.until("g once they agree")
        assert terminal.modes() != before
        for line in ("participant P07", "the session begins", "consent"):
            assert line in terminal.text()
        terminal.keys("g")
        terminal.until("Does the participant agree")
        terminal.keys("y")
        terminal.until("asked for: agree")
        show(log, "asking")
        terminal.until("How good was the picture?")
        terminal.keys("3,3\r")
        terminal.until("lies between two steps")
        terminal.keys("\x7f5\r")
        terminal.until("3.5? Enter again")
        assert asked(log)[1:] == []
        terminal.keys("\r")
        terminal.until("asked for: answer")
        terminal.keys("r")
        terminal.until("asked for: again")
        terminal.keys("mthe strap slipped: é\r")
        terminal.until("asked for: remark")
        terminal.keys("kk")
        terminal.until("asked for: skip")
        show(log, "showing")
        terminal.until("SHOWING")
        terminal.keys("p")
        terminal.until("asked for: pause")
        show(log, "paused")
        terminal.until("PAUSED")
        terminal.keys("c")
        terminal.until("asked for: continue")
        terminal.keys("b")
        terminal.until("asked for: break")
        terminal.keys("\x1a\x13\x04")  # Ctrl-Z, Ctrl-S, Ctrl-D do nothing
        terminal.keys("s")
        terminal.until("End the session now?")
        terminal.keys("y")
        assert terminal.ended() == 0
        assert terminal.modes() == before and left_the_page(terminal)
        assert "the program has ended" in terminal.text()
    assert asked(log) == [
        ("agree", None), ("answer", 3.5), ("again", None), ("remark", "the strap slipped: é"), ("skip", None),
        ("pause", None),
        ("continue", None), ("break", None), ("stop", None),
    ]  # fmt: skip


def test_pasted_text_is_no_row_of_keys(log):
    with played(log, "--states", "asking") as terminal:
        terminal.until("How good was the picture?")
        terminal.keys("\x1b[200~sy\x1b[201~")
        terminal.until("into an open line")
        terminal.keys("\x1b[A")  # an arrow key, which begins as Esc does
        terminal.keys("p")
        terminal.until("asked for: pause")
    assert asked(log) == [("pause", None)]


SIZES = [(80, 24), (120, 40), (60, 20), (100, 21)]
SHOWN = ("participant P07", "trial 3 of 12", "25 %", "12:04", "0:14 left", "SHOWING", "89.9", "missed 3", "+1.62",
         "yaw  -35°",
         "pitch   +3°", "roll   +0°", "the session begins", "p:pause", "s:stop", "?:help")  # fmt: skip
ASKED = (
    "ASKING",
    "How good was the picture?",
    "1 very good",
    "6 insufficient",
    "entered 3.25",
    "answer > 3.2",
    "Enter",
    "sends",
)


@pytest.mark.slow(10)
def test_the_essentials_are_shown_in_every_size(log):
    """Sizes follow each other in one window, which is filled anew each time."""
    with played(log, COLUMNS="80", LINES="24") as terminal:  # a shell's own, which must not count
        for size in SIZES:
            terminal.resize(*size)
            show(log, "showing")
            terminal.until(*SHOWN)
            terminal.until_holds(lambda: max(map(len, terminal.lines())) == size[0])  # noqa: B023
            show(log, "asking")
            terminal.until("How good was the picture?")
            terminal.keys("3.2")
            terminal.until(*ASKED)
            terminal.keys("\x1b")
            terminal.until("answer >", there=False)
            terminal.keys("?")
            text = terminal.until(*(words[: size[0] - 20] for _, words in HELP))
            assert [keys for keys, _ in HELP if keys not in text] == []
            terminal.keys("\x1b")
            terminal.until("help, Esc", there=False)


def test_a_long_journal_shows_its_end(log):
    """The end of a line is often what happened; here it does not fit into one row."""
    with played(log, "--do", "say", size=(60, 20)) as terminal:
        do(terminal)
        terminal.until("questionnaire (SSQ), question")
        terminal.until("15 of 16: left unanswered.")


def test_a_window_too_small_keeps_what_matters(log):
    with played(log, "--states", "lost", size=(50, 10)) as terminal:
        terminal.until("SHOWING", "trial 3", "TRACKING LOST", "PILOT")
        terminal.keys("s")
        terminal.until("End the session now?")


def test_a_stop_from_outside_leaves_the_screen_as_it_was(log):
    """The shell takes the terminal meanwhile, and leaves it in its own modes."""
    with played(log, "--states", "asking") as terminal:
        before = terminal.modes()
        terminal.until("How good was the picture?")
        during = terminal.modes()
        termios.tcsetattr(terminal.program.child_fd, termios.TCSANOW, before)
        program = console_of(terminal)
        os.kill(program, signal.SIGSTOP)
        os.kill(program, signal.SIGCONT)
        terminal.until_holds(lambda: terminal.modes() == during)
        terminal.keys("p")
        terminal.until("asked for: pause")


def console_of(terminal: Terminal) -> int:
    """The process of the console, the only child of the session's."""
    session = terminal.program.pid
    return int(Path(f"/proc/{session}/task/{session}/children").read_text(encoding="ascii").split()[0])


def test_warnings_and_progress_stand_out(log):
    with played(log, "--states", "lost") as terminal:
        terminal.until("TRACKING LOST")
        for words in ("TRACKING LOST", "PILOT"):
            assert colours_of(terminal, words) == {("white", "red", True)}
        assert colours_of(terminal, "██") == {("green", "default", False)}
        assert colours_of(terminal, "░░") == {("brightblack", "default", False)}


def test_no_black_is_bold(log):
    """xterm draws it grey."""
    with played(log) as terminal:
        for name in ("showing", "paused", "break", "asking", "reading", "waiting"):
            show(log, name)
            terminal.until(f" {name.upper()} ")
            ((foreground, background, bold),) = colours_of(terminal, f" {name.upper()} ")
            assert (foreground, bold) == ("black", False) and background != "default"


def colours_of(terminal: Terminal, words: str) -> set[tuple[str, str, bool]]:
    """(foreground, background, bold) of the cells of these words."""
    row, line = next((y, line) for y, line in enumerate(terminal.screen.display) if words in line)
    first = line.index(words)
    cells = [terminal.screen.buffer[row][x] for x in range(first, first + len(words))]
    return {(cell.fg, cell.bg, cell.bold) for cell in cells}


def test_ctrl_c_reaches_the_program_and_the_terminal_is_restored(log):
    with played(log) as terminal:
        before = terminal.modes()
        terminal.until("SHOWING")
        terminal.keys("\x03")
        assert terminal.ended() == 0
        assert terminal.modes() == before and left_the_page(terminal)
    assert "interrupted" in log.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("deed", "status", "words"),
    [
        ("raise", 1, ["Traceback", "a fault in the session"]),
        ("hard-exit", 3, ["the last words", "--resume"]),
        ("abort", 134, ["--resume"]),
        ("kill", 137, ["--resume"]),
    ],
)
def test_the_terminal_is_restored_and_messages_printed_after_any_end(log, deed, status, words):
    with played_by_a_shell(log, "--do", deed) as terminal:
        before = terminal.modes()
        do(terminal)
        for word in words:
            terminal.until(word)
        terminal.until_holds(lambda: terminal.modes() == before)
        terminal.until_holds(
            lambda: b"status %d" % status in terminal.raw
        )  # the shell may say it on the page that is about to go
        assert left_the_page(terminal)


@pytest.mark.parametrize(
    ("deed", "words"), [("print", ["a print in red", "a driver's own words"]), ("warn", ["a warning of a library"])]
)
def test_prints_appear_in_the_journal_and_after_the_end(log, deed, words):
    with played(log, "--do", deed) as terminal:
        do(terminal)
        for word in words:
            terminal.until(word)
        assert "trial 3 of 12" in terminal.lines()[2]  # nothing is torn
        terminal.keys("\x03")
        terminal.ended()
        after = terminal.raw[terminal.raw.rindex(b"\x1b[?1049l") :].decode()
        assert all(word.replace(" in red", "") in after for word in words)


def test_a_dead_screen_is_replaced_by_lines(log):
    with played(log, "--do", "kill-screen") as terminal:
        before = terminal.modes()
        do(terminal)
        terminal.until("the session goes on")
        assert terminal.modes() == before and left_the_page(terminal)
        terminal.keys("remark still here\n")
        terminal.until("asked for: remark")
        terminal.keys("stop\n")
        assert terminal.ended() == 0
    assert asked(log) == [("again", None), ("remark", "still here"), ("stop", None)]


def test_a_program_that_stands_still_is_seen(log):
    with played(log, "--do", "still") as terminal:
        do(terminal)
        terminal.until("NO NEWS FOR")
        show(log, "showing")  # for which it waits
        terminal.until("NO NEWS FOR", there=False)


def test_without_colours_nothing_is_coloured_and_what_is_loud_still_stands_out(log):
    with played(log, "--states", "lost", NO_COLOR="1") as terminal:
        terminal.until("TRACKING LOST")
        cells = [cell for row in terminal.screen.buffer.values() for cell in row.values()]
        assert {(cell.fg, cell.bg) for cell in cells} == {("default", "default")}
        row = next(y for y, line in enumerate(terminal.screen.display) if "TRACKING LOST" in line)
        assert terminal.screen.buffer[row][4].reverse


def test_a_terminal_without_unicode_gets_none(log):
    with played(log, "--states", "asking", PYTHONUTF8="0", PYTHONIOENCODING="ascii") as terminal:
        terminal.until("How good was the picture?")
        assert terminal.text().isascii()


def test_in_a_terminal_that_cannot_place_text_there_are_lines(log):
    with played(log, TERM="dumb") as terminal:
        text = terminal.until("trial 3 of 12: showing")
        assert "TERM says" in text
        terminal.keys("pause\n")
        terminal.until("asked for: pause")


def test_typing_for_a_finished_question_is_dropped():
    """The participant may have confirmed while the experimenter's Enter was on its way."""
    console = TerminalConsole("a study")
    here, there = (MessageSocket(end) for end in socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET))
    console.messages = here
    console.tell(STATES["next"])
    there.send("command", "answer", 3.25, subject_of(ASKING))
    there.send("command", "pause", None, subject_of(ASKING))
    there.send("command", "answer", 2.0, subject_of(STATES["next"]))
    assert [(c.control, c.value) for c in console.commands()] == [("pause", None), ("answer", 2.0)]
    assert console.commands() == ()
    told = list(there.received())
    assert ("state", STATES["next"]) in told and any("too late" in str(packet) for packet in told)
    here.close()
    there.close()


def test_a_second_answer_to_one_question_never_becomes_one_to_the_next():
    """A session that was busy for a while finds both at once."""
    console = TerminalConsole("a study")
    here, there = (MessageSocket(end) for end in socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET))
    console.messages = here
    console.tell(ASKING)
    for value in (2.0, 3.0):
        there.send("command", "answer", value, subject_of(ASKING))
    assert [c.value for c in console.commands()] == [2.0]
    assert console.commands() == ()
    console.tell(STATES["next"])
    assert console.commands() == ()
    there.send("command", "answer", 4.0, subject_of(STATES["next"]))
    assert [c.value for c in console.commands()] == [4.0]
    here.close()
    there.close()


def test_a_slow_screen_delays_nothing_and_gets_the_newest_state():
    here, there = (MessageSocket(end) for end in socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET))
    for k in range(2000):
        here.send_state(k)
    here.send("say", "a line")
    got = []
    for _ in range(10):
        got += list(there.received())
        here.flush()
    assert got[-1] == ("state", 1999) and ("say", "a line") in got
    assert len(got) < 2001
    here.close()
    there.close()
