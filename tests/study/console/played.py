"""A session for the console to be tried on, run as a program of its own in a terminal.

It tells what a scripted session would, at some 60 a second, and writes down what was asked for.

played.py LOG [--console KIND] [--script NAME] [--seconds S]. LOG gets one line for each command, as
Python literals.
"""

from __future__ import annotations

import argparse
import os
import signal
import time
import warnings
from pathlib import Path

import attrs

from hmdwarp.study.line_console import ConsoleState, LineConsole, Question

GRADE = Question(
    "How good was the picture?", 1.0, 6.0, 0.25,
    ((1.0, "very good"), (2.0, "good"), (3.0, "satisfactory"), (4.0, "sufficient"), (5.0, "poor"),
    (6.0, "insufficient")),
)  # fmt: skip
SICK = Question("How sick do you feel?", 0.0, 20.0, 1.0, ((0.0, "no sickness at all"), (20.0, "frank sickness")))
HEADING = "latency-and-warp - participant P07 - session 1"
SHOWING = ConsoleState(
    heading=HEADING, participant="P07", step="trial 3 of 12", elapsed_s=724.0, left_s=14.0, phase="showing",
    rate_hz=89.9, missed=3,
)  # fmt: skip
ASKING = attrs.evolve(SHOWING, phase="asking", left_s=None, question=attrs.evolve(GRADE, entered=3.25))
STATES = {
    "reading": attrs.evolve(SHOWING, phase="reading", step="consent", left_s=None),
    "waiting": attrs.evolve(SHOWING, phase="waiting", step="about to begin", left_s=None),
    "showing": SHOWING,
    "asking": ASKING,
    "next": attrs.evolve(ASKING, step="trial 4 of 12", question=GRADE),
    "fms": attrs.evolve(ASKING, question=attrs.evolve(SICK, entered=6.0)),
    "break": attrs.evolve(SHOWING, phase="break", step="break 1 of 2", left_s=22.0),
    "paused": attrs.evolve(SHOWING, phase="paused", left_s=None),
    "lost": attrs.evolve(SHOWING, notice="tracking lost", participant="P07 - PILOT"),
    "sick": attrs.evolve(SHOWING, phase="over", left_s=None, notice="stopped: sickness 15 of 20, the stop rule is 15"),
    "open": attrs.evolve(SHOWING, condition="late-200"),
}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("log", type=Path)
    parser.add_argument("--console", default="lines")
    parser.add_argument(
        "--states", default="showing", help="names of STATES; the file LOG.state may name another one meanwhile"
    )
    parser.add_argument("--seconds", type=float, default=600.0, help="less those in which this program stands still")
    parser.add_argument("--do", default="", help="once, when the last question is to be repeated: see deed()")
    options = parser.parse_args()
    with options.log.open("a", encoding="utf-8", buffering=1) as log:
        try:
            play(options, log)
        except KeyboardInterrupt:
            print("interrupted", file=log)
    print("the program has ended")


def play(options: argparse.Namespace, log) -> None:
    chosen = options.log.with_suffix(".state")
    with LineConsole("latency-and-warp", kind=options.console) as console:
        console.say("the session begins")
        todo = options.do
        for _ in range(round(60 * options.seconds)):
            name = chosen.read_text(encoding="utf-8").strip() if chosen.exists() else options.states
            if name in STATES:
                console.tell(STATES[name])
            for command in console.commands():
                print((command.control, command.value), file=log)
                console.say(f"asked for: {command.control}")
                if command.control == "stop":
                    return
                if command.control == "again" and todo:
                    deed(todo)
                    todo = ""
            time.sleep(1 / 60)


def deed(name: str) -> None:
    if name == "warn":
        warnings.warn("a warning of a library", stacklevel=1)
    elif name == "raise":
        raise RuntimeError("a fault in the session")
    elif name == "kill":
        os.kill(os.getpid(), signal.SIGKILL)


if __name__ == "__main__":
    main()
