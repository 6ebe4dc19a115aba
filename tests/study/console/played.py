"""A session for the console to be tried on, run as a program of its own in a terminal.

It tells what a scripted session would, at some 60 a second, and writes down what was asked for.

played.py LOG STATE [FAULT]. LOG gets one line for each command, as Python literals; STATE names one
of STATES, the file LOG.state another one meanwhile; FAULT: that the session fails at `again`.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import attrs

from hmdwarp.study.line_console import ConsoleState, LineConsole, Question

GRADE = Question(
    "How good was the picture?", 1.0, 6.0, 0.25,
    ((1.0, "very good"), (2.0, "good"), (3.0, "satisfactory"), (4.0, "sufficient"), (5.0, "poor"),
    (6.0, "insufficient")),
)  # fmt: skip
SICK = Question("How sick do you feel?", 0.0, 20.0, 1.0, ((0.0, "no sickness at all"), (20.0, "frank sickness")))
SHOWING = ConsoleState(
    heading="latency-and-warp - participant P07 - session 1", participant="P07", step="trial 3 of 12",
    elapsed_s=724.0, left_s=14.0, phase="showing", rate_hz=89.9, missed=3,
)  # fmt: skip
ASKING = attrs.evolve(SHOWING, phase="asking", left_s=None, question=attrs.evolve(GRADE, entered=3.25))
STATES = {
    "reading": attrs.evolve(SHOWING, phase="reading", step="consent", left_s=None),
    "showing": SHOWING,
    "asking": ASKING,
    "next": attrs.evolve(ASKING, step="trial 4 of 12", question=GRADE),
    "break": attrs.evolve(SHOWING, phase="break", step="break 1 of 2", left_s=22.0),
    "paused": attrs.evolve(SHOWING, phase="paused", left_s=None),
    "lost": attrs.evolve(SHOWING, notice="tracking lost", participant="P07 - PILOT"),
    "sick": attrs.evolve(SHOWING, phase="over", left_s=None, notice="stopped: sickness 15 of 20, the stop rule is 15"),
    "open": attrs.evolve(SHOWING, condition="late-200"),
    "fms": attrs.evolve(ASKING, question=SICK),
    "entered": attrs.evolve(ASKING, question=attrs.evolve(GRADE, entered=1.0)),
    "later": attrs.evolve(SHOWING, elapsed_s=999.0, rate_hz=1.0, missed=9),
    "until-done": attrs.evolve(SHOWING, seen_s=12.0, left_s=588.0),
    "finished": attrs.evolve(SHOWING, step="session finished", phase="over"),
    "nothing": ConsoleState(),
}


def play(file: Path, state: str, fault: str) -> None:
    chosen = file.with_suffix(".state")
    with file.open("a", encoding="utf-8", buffering=1) as log, LineConsole("latency-and-warp") as console:
        console.say("the session begins")
        for _ in range(60 * 600):
            console.tell(STATES[chosen.read_text(encoding="utf-8") if chosen.exists() else state])
            for command in console.commands():
                print((command.control, command.value), file=log)
                console.say(f"asked for: {command.control}")
                if command.control == "stop":
                    return
                if command.control == "again" and fault:
                    raise RuntimeError("a fault in the session")
            time.sleep(1 / 60)


if __name__ == "__main__":
    try:
        play(Path(sys.argv[1]), sys.argv[2], *[*sys.argv[3:], ""][:1])
    except KeyboardInterrupt:
        print("interrupted")
    print("the program has ended")
