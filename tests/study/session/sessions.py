"""Sessions on the display without a screen, with people who look at what is shown, as people do,
and answer with their hands.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import attrs
import numpy as np
from PIL import Image
from run.offscreen import OffscreenDisplay

from hmdwarp.display import Closed, Command, Lost
from hmdwarp.study.dialogs.dialog_panels import MessagePanel, QuestionPanel
from hmdwarp.study.line_console import ConsoleState
from hmdwarp.study.session import program
from hmdwarp.study.session.session_options import SessionOptions
from hmdwarp.study.store import Contents, Session, Store

from ..plans import text_of

RED, BLUE = (220, 40, 40), (30, 60, 200)
NAMES, LATENCIES_MS = ("plainly-late", "spun-about"), (130, 170)
TEXT, MORE = text_of("small"), text_of("small-more")


def study(folder: Path, more: str = "") -> Path:
    """A study's file."""
    path = folder / "small.toml"
    path.write_text(TEXT.replace("[common]", f"{more}\n[common]"), encoding="utf-8")
    return path


def whole(folder: Path) -> Path:
    """One with everything in it that may come between trials."""
    return study(folder, MORE)


def press(panel: MessagePanel, name: str) -> Command:
    """A click onto a button of a panel."""
    for v in range(1, 100, 2):
        for u in range(2, 20, 2):
            if panel.button_at(u / 20, v / 100) == name:
                return Command("press", (u / 20, v / 100))
    raise AssertionError(f"no button {name!r} on {panel}")


Seen = MessagePanel | QuestionPanel | str
Own = Callable[[Seen], Sequence[Command] | None]


class Person:
    """Goes through the session as panels ask; own: what is done instead, None for nothing else."""

    def __init__(self, own: Own = lambda panel: None) -> None:
        self._own, self._last = own, None

    def looks(self, panel: Seen) -> Sequence[Command]:
        """What hands do at a panel. A panel is reacted to once, when it comes."""
        if panel == self._last:
            return ()
        self._last = panel
        own = self._own(panel)
        return self._usual(panel) if own is None else own

    def _usual(self, panel: Seen) -> Sequence[Command]:
        if isinstance(panel, QuestionPanel) and panel.value is None and not panel.skipping and not panel.typed:
            return (Command("digit", "2"), Command("confirm"))
        if isinstance(panel, MessagePanel) and panel.title == "Before we begin":
            return (press(panel, "agree"),)
        if isinstance(panel, MessagePanel) and panel.title == "Menu":
            return (press(panel, "continue"),)
        if isinstance(panel, MessagePanel) and (
            panel.title in ("Ready?", "We stop here") or "whenever you like" in " ".join(panel.lines)
        ):
            return (Command("confirm"),)
        return ()


class SeatedDisplay(OffscreenDisplay):
    """A display with somebody before it. events: by the number of the wait, as OffscreenDisplay's;
    at: by the n-th picture shown (counted from 1), what happens right before the next: an exception
    is raised, anything else called.
    """

    def __init__(self, gpu, person: Person, at: dict[int, object] | None = None, **more) -> None:
        super().__init__(gpu=gpu, **more)
        self.person, self._at, self.shown, self.lost = person, dict(at or {}), 0, 0
        self.titles: list[str] = []
        self.handed: list[tuple[int, bool, object]] = []  # when, whether there was a picture, what lay over it

    def wait(self):
        due = self._at.pop(self.shown, None)
        if isinstance(due, BaseException):
            self.lost += isinstance(due, Lost)
            raise due
        if due is not None:
            due()
        return super().wait()

    def show(self, refresh, label="") -> int:
        self.shown += refresh is not None
        self.handed.append((self.now_ns(), refresh is not None, label))
        return super().show(refresh, label)

    def commands(self) -> Sequence[Command]:
        return self.person.looks(self.labels[-1]) if self.labels else ()

    def show_status(self, status) -> None:
        self.titles.append(status.title())

    @property
    def panels(self) -> list[Seen]:
        """Those seen, one after the other."""
        return [panel for before, panel in zip([None, *self.labels], self.labels, strict=False) if panel != before]


class ScriptedConsole:
    """A console. asks: what the experimenter asks for, given the state when it is new."""

    def __init__(self, asks: Callable[[ConsoleState], Sequence[Command]] = lambda state: ()) -> None:
        self.states: list[ConsoleState] = []
        self.said: list[str] = []
        self.open = False
        self._asks, self._pending = asks, []

    def __enter__(self):
        self.open = True
        return self

    def __exit__(self, *_: object) -> None:
        self.open = False

    def tell(self, state: ConsoleState) -> None:
        self.states.append(state)
        self._pending += self._asks(state)

    def say(self, text: str) -> None:
        self.said.append(text)

    def commands(self) -> Sequence[Command]:
        pending, self._pending = self._pending, []
        return pending


@attrs.define
class Ran:
    """What came of a run of the program. error: that ended it, None for none."""

    display: SeatedDisplay
    console: ScriptedConsole
    said: list[str]
    session: Session | None = None
    error: BaseException | None = None


def run(
    monkeypatch,
    gpu,
    path: Path,
    person: Person | None = None,
    console: ScriptedConsole | None = None,
    at=None,
    **options,
) -> Ran:
    """One run of the program. at: of SeatedDisplay. options: of SessionOptions, participant P1 and
    a desktop where nothing else is said; back_after: of the display.
    """
    back_after = options.pop("back_after", 0)
    ran = Ran(SeatedDisplay(gpu, person or Person(), at, back_after=back_after), console or ScriptedConsole(), [])
    monkeypatch.setattr(program, "open_display", lambda *_, **__: ran.display)
    options = {"participant": "P1", "source": "desktop", **options}
    try:
        ran.session = program.run_session(
            SessionOptions(study=str(path), **options), ran.said.append, console=ran.console
        )
    except BaseException as error:
        ran.error = error
    finally:
        ran.display.close()
    assert not ran.console.open
    return ran


def contents(path: Path, pilot: bool = False) -> Contents:
    """What the store holds."""
    with Store(path.with_name("small-pilot-data" if pilot else "small-data")) as store:
        return store.contents(pilot)


def closing() -> Closed:
    """Somebody closes the window."""
    return Closed("the window was closed")


def picture(path: Path, size: tuple[int, int] = (900, 600)) -> None:
    """Red on the left, blue on the right."""
    half = np.zeros((size[1], size[0], 3), np.uint8)
    half[:, : size[0] // 2], half[:, size[0] // 2 :] = RED, BLUE
    Image.fromarray(half).save(path)
