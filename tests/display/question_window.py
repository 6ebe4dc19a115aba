"""A window that shows nothing and asks one question, on a virtual screen.

python -m display.question_window, led by programs.Led.

Reads from stdin, a line each: "ask" (a new question), "words" (one that is answered in words),
"show" (none), "trial" (none, and the start of a trial), "wait" (as it is) and "end".
Tells each command that came by hand, with what the question made of it, each line from stdin two
refreshes later, and each change of where the head is or who has the mouse.
"""

from __future__ import annotations

import json
import os
import sys
import threading

from hmdwarp.display import DisplayOptions
from hmdwarp.display.desktop import DesktopDisplay
from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.dialog_panels import CONTROLS, QuestionDialog, TextDialog
from hmdwarp.study.scales import load_scale


class QuestionWindow:
    """display, and what is asked in it just now.

    A panel is allowed, and is not there: no control of a study opens one.
    """

    def __init__(self) -> None:
        self._display = DesktopDisplay(DisplayOptions("rift-dk1", size=(300, 400), controls=CONTROLS))
        self._lines: list[str] = []
        self._asked: QuestionDialog | TextDialog | None = None
        self._last: dict[str, object] = {}
        self._drawn: list[tuple[str, int]] = []  # lines that were done, and how many refreshes ago

    def run(self) -> None:
        """Until "end"."""
        threading.Thread(target=self._listen, daemon=True).start()
        while self._obeys():
            self._refresh()

    def _listen(self) -> None:
        for line in sys.stdin:
            self._lines.append(line.strip())

    def _obeys(self) -> bool:
        while self._lines:
            line = self._lines.pop(0)
            if line != "wait":
                self._ask(line)
            if line == "trial":
                self._display.restart()
            if line == "end":
                return False
            self._drawn.append((line, 0))
        return True

    def _refresh(self) -> None:
        if self._display.wait() is not None:
            self._display.show(None, self._asked.panel() if self._asked is not None else "")
            # The first of two refreshes may have been sent and not be on the screen yet.
            counted = [(line, count + 1) for line, count in self._drawn]
            self._drawn = [entry for entry in counted if entry[1] < 2]
            for line in (line for line, count in counted if count == 2):
                self._tell(line=line)
        for command in self._display.commands():
            if self._asked is not None:
                self._asked.handle([command])
            self._tell(command=command.control, given=command.value)
        self._tell()

    def _ask(self, line: str) -> None:
        scale = load_scale("comments" if line == "words" else "grade")
        ask = Ask("trial/1/grade/grade", scale, scale.items[0], "trial", 1)
        self._asked = None
        if line == "ask":
            self._asked = QuestionDialog(ask, lambda: self._display.now_ns() * 1e-9)
        elif line == "words":
            self._asked = TextDialog(ask)

    def _tell(self, **more: object) -> None:
        head = self._display.source.head_at(self._display.now_ns()).pose
        state: dict[str, object] = {
            "captured": self._display._input.captured,
            "turned": [round(part, 4) for part in head.orientation_xyzw.tolist()],
            "stands": [round(part, 2) for part in head.position_m.tolist()],
            "value": self._asked.value if self._asked is not None else None,
            "text": self._asked.text if self._asked is not None else "",
            "confirmed": self._asked is not None and self._asked.over,
        }
        if more or state != self._last:
            self._last = state
            print(json.dumps({**state, **more}), flush=True)


if __name__ == "__main__":
    QuestionWindow().run()
    sys.stdout.flush()
    os._exit(0)  # the thread is left waiting for a line that does not come
