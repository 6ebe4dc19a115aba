"""A window that shows nothing and asks one question, on a virtual screen.

python -m display.question_window, led by programs.Led.

Reads from stdin, a line each: "ask" (a new question), "words" (one that is answered in words),
"show" (none), "trial" (none, and the start of a trial), "wait" (as it is) and "end".
Tells each command that came by hand, with what the question made of it, each line from stdin two
refreshes later, and each change of where the head is or who has the mouse.
"""

from __future__ import annotations

from hmdwarp.display import DisplayOptions
from hmdwarp.display.desktop import DesktopDisplay
from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.dialog_panels import CONTROLS, QuestionDialog, TextDialog
from hmdwarp.study.scales import load_scale

from .programs import lines_now, tell


def main() -> None:
    """A panel is allowed, and is not there: no control of a study opens one."""
    display = DesktopDisplay(DisplayOptions("rift-dk1", size=(300, 400), controls=CONTROLS))
    asked: QuestionDialog | TextDialog | None = None
    last: dict[str, object] = {}
    drawn: list[list] = []  # lines that were done, and how many refreshes ago

    def report(**more: object) -> None:
        nonlocal last
        head = display.source.head_at(display.now_ns()).pose
        state: dict[str, object] = {
            "captured": display._input.captured,
            "turned": [round(part, 4) for part in head.orientation_xyzw.tolist()],
            "stands": [round(part, 2) for part in head.position_m.tolist()],
            "value": asked.value if asked is not None else None,
            "text": asked.text if asked is not None else "",
            "confirmed": asked is not None and asked.over,
        }
        if more or state != last:
            last = state
            tell(**state, **more)

    while True:
        for line in lines_now():
            scale = load_scale("comments" if line == "words" else "grade")
            ask = Ask("trial/1/grade/grade", scale, scale.items[0], "trial", 1)
            if line == "end":
                display.close()
                return
            if line == "ask":
                asked = QuestionDialog(ask, lambda: display.now_ns() * 1e-9)
            elif line == "words":
                asked = TextDialog(ask)
            elif line != "wait":
                asked = None
            if line == "trial":
                display.restart()
            drawn.append([line, 0])
        if display.wait() is not None:
            display.show(None, asked.panel() if asked is not None else "")
            for entry in drawn:
                entry[1] += 1
            # The first of two refreshes may have been sent and not be on the screen yet.
            while drawn and drawn[0][1] == 2:
                report(line=drawn.pop(0)[0])
        for command in display.commands():
            if asked is not None:
                asked.handle([command])
            report(command=command.control, given=command.value)
        report()


if __name__ == "__main__":
    main()
