"""Sessions by script: what people see, what the store holds and what is said, as it was before.

A script of scripts.toml says who does what and when; transcripts/NAME.txt is what came of it:
HMDWARP_GOLDEN=write writes it anew.
"""

from __future__ import annotations

import itertools
import re
import tomllib
from pathlib import Path

import pytest
from golden_texts import assert_text

from hmdwarp.display import Command, Lost
from hmdwarp.study.store import Store

from . import sessions
from .sessions import Person, ScriptedConsole, closing, picture, press, run

FOLDER = Path(__file__).with_name("transcripts")
SCRIPTS = tomllib.loads(FOLDER.joinpath("scripts.toml").read_text(encoding="utf-8"))
NEVER, TOO_LONG = 10**6, 2000  # refreshes


def commands_of(words: str, panel: object = None) -> list[Command]:
    """The commands of a line; panel: whose buttons are pressed."""
    made = []
    for word in words.split(", "):
        control, _, value = word.partition(" ")
        if control == "close":
            raise closing()
        if control == "press":
            made.append(press(panel, value))
        elif control in ("digits", "type"):
            made += [Command({"digits": "digit"}.get(control, control), letter) for letter in value]
        else:
            made.append(Command(control, float(value) if re.fullmatch(r"[\d.]+", value) else value or None))
    return made


def name_of(panel: object) -> str:
    if isinstance(panel, str):
        return panel or "pictures"
    return getattr(panel, "title", "") or getattr(panel, "heading", "")


def is_meant(panel: object, name: str) -> bool:
    """Whether a panel has that name, and is not answered yet."""
    named = name == name_of(panel) or name in (getattr(panel, "text", "") or name_of(panel))
    return named and getattr(panel, "value", None) is None and not getattr(panel, "typed", "")


class Scripted(Person):
    """Does what `hands` says, nothing at the panels of `idle`, and all else as people do."""

    def __init__(self, hands: list[str], idle: list[str]) -> None:
        super().__init__()
        self.hands, self._idle = [line.partition(": ")[::2] for line in hands], idle
        self._refreshes = 0

    def looks(self, panel):
        self._refreshes += 1
        assert self._refreshes < TOO_LONG, f"nobody does anything at {shown_of(panel)}"
        if panel != self._last and self.hands and is_meant(panel, self.hands[0][0]):
            self._last = panel
            return commands_of(self.hands.pop(0)[1], panel)
        return () if {name_of(panel), "*"} & {*self._idle} else super().looks(panel)


def experimenter(lines: list[str]) -> ScriptedConsole:
    todo = [line.partition(": ")[::2] for line in lines]

    def asks(state):
        if todo:
            phase, _, step = todo[0][0].partition(", ")
            is_seen = bool(state.seen_s) if phase == "seen" else phase == state.phase
            if is_seen and step in ("", state.step, state.question and state.question.text):
                return commands_of(todo.pop(0)[1])
        return ()

    console = ScriptedConsole(asks)
    console.todo = todo
    return console


def display_events(at: str) -> tuple[dict[int, object], int]:
    """What happens to the display, and for how long it stays away."""
    if not at:
        return {}, 0
    number, what = at.split()
    return {
        int(number): closing() if what == "closed" else Lost("the headset went away")
    }, NEVER if what == "gone" else 0


def study_of(script: dict) -> Path:
    """The study's file, in the working folder."""
    kinds = {"small": script.get("more", ""), "whole": sessions.MORE}
    path = sessions.study(Path(), kinds[script.get("study", "small")])
    path.write_text(path.read_text(encoding="utf-8") + script.get("end", ""), encoding="utf-8")
    picture(Path("instructions.png"))
    return path


def change(path: Path, changes: dict) -> None:
    text = path.read_text(encoding="utf-8")
    for found, put in changes.get("change", ()):
        assert found in text, found
        text = text.replace(found, put)
    path.write_text(text, encoding="utf-8")
    for name, content in changes.get("files", {}).items():
        Path(name).write_text(content, encoding="utf-8")


def seen(ran: sessions.Ran) -> list[str]:
    """Each panel, with how many refreshes it stood, and what was on it."""
    out = []
    for panel, group in itertools.groupby(ran.display.labels, key=shown_of):
        out.append(f"  {len(list(group)):3d} {panel}")
    return out


def shown_of(panel: object) -> str:
    if hasattr(panel, "choices"):
        buttons = ", ".join(name for name, _ in panel.choices)
        parts = [*panel.lines, panel.picture and Path(panel.picture).name, buttons and f"[{buttons}]"]
        return " | ".join(filter(None, [name_of(panel), *parts, panel.hint.replace("\n", "; "), panel.note]))
    return " | ".join(filter(None, [name_of(panel), getattr(panel, "text", "")])).replace("\n", "; ")


def told(ran: sessions.Ran) -> list[str]:
    """Each state of the console that is another one, and what was said there."""
    states = [
        " | ".join(filter(None, (one.phase, one.step, one.condition, one.notice, one.question and one.question.text)))
        for one in ran.console.states
    ]
    return [f"  {state}" for state, _ in itertools.groupby(states)] + [f"  said: {line}" for line in ran.console.said]


def stored(folder: Path, pilot: bool) -> list[str]:
    """All that the store holds of the sessions."""
    if not folder.exists():
        return ["  nothing"]
    with Store(folder) as store:
        found = store.contents(pilot)
    of = {showing.id: f"{showing.key}#{showing.presentation}" for showing in found.showings}
    out = [f"  {one.code} {one.number} {one.origin}: {one.status}, {one.why or '-'}" for one in found.sessions]
    for event in found.events:
        kept = {k: v for k, v in event.data.items() if k in ("by", "text", "complete", "presentation", "status")}
        out.append(f"  {event.kind} {event.key} {kept or ''}".rstrip())
    for one in found.answers:
        about = of.get(one.showing, "nothing")
        out.append(f"  {one.key}#{one.revision} = {one.value} {one.text!r} by {one.by}, about {about}")
    for one in found.showings:
        figures = {name: one.actual.get(name) for name in ("pictures", "ended_by", "head_still")}
        out.append(f"  {of[one.id]} complete {one.complete}: {figures}")
    onsets = [one.actual["onset_s"] for one in found.showings if one.actual.get("onset_s") and one.session == 1]
    assert onsets == sorted({*onsets}), "they count from the session's beginning"
    assert len({one.trace for one in found.showings if one.trace}) == sum(bool(one.trace) for one in found.showings)
    return out


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_scripted_session_comes_out_as_it_did(monkeypatch, gpu, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    script = SCRIPTS[name]
    path, lines, before = study_of(script), [], None
    change(path, script)
    for number, one in enumerate(script.get("runs", [{}]), 1):
        change(path, one)
        person, console = Scripted(one.get("hands", []), one.get("idle", [])), experimenter(one.get("console", []))
        at, back_after = display_events(one.get("at", ""))
        options = one.get("options", {})
        with pytest.MonkeyPatch.context() as patch:
            # By a clock that is not the display's: a run begins so long after the session did.
            patch.setattr(Store, "passed_s", lambda *_, passed_s=1000.0 * (number - 1): passed_s)
            ran = run(patch, gpu, path, person, console, at=at, back_after=back_after, **options)
        left = [*person.hands, *console.todo]
        assert not left, (
            f"these never came to be: {left}; {ran.error}; there were {[*map(shown_of, ran.display.panels)]}"
        )
        assert bool(ran.error) == one.get("fails", False), ran.error
        origin = "-pilot" if options.get("pilot") else "-simulated" if options.get("simulate") else ""
        held = stored(Path(options.get("store", f"small{origin}-data")), options.get("pilot", False))
        lines += [f"run {number}", f"  {type(ran.error).__name__}: {ran.error}"] if ran.error else [f"run {number}"]
        lines += [f"  {line}" for line in ran.said]
        lines += ["panels", *seen(ran), "console", *told(ran), "store", *(held if held != before else ["  as before"])]
        before = held
    text = "\n".join(lines).replace(str(tmp_path), "") + "\n"
    assert_text(text, FOLDER / f"{name}.txt")
