"""Reads study files (.toml), naming the line of an error; writes a new one to begin with."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError, unknown_name
from ...options import Table, parsed, quoted, text_of
from ...report import refuse_existing, write_text
from ..scales import Scale
from ._parts import NAME, NAME_WANTED, Checker, families_of, parts_of
from ._sections import (
    breaks_of,
    consent_of,
    length_of,
    page_of,
    practice_of,
    questionnaires_of,
    scales_of,
    sickness_of,
    task_of,
)
from .definitions import ADAPTIVE, BLIND, BOTH, ONE, ORDERS, PAIR, SHOWS, WILLIAMS, Design, Sickness

SCHEMA = 1
SHIPPED = Path(__file__).resolve().parent.parent / "ready"
_EXAMPLE = "thesis.toml ('hmdwarp study plan thesis' prints its path)"


def study_names() -> list[str]:
    """Return the names of the shipped studies, sorted; NAME_more.toml only belongs to a study."""
    return sorted(p.stem for p in SHIPPED.glob("*.toml") if "_" not in p.stem)


def load_design(name_or_path: str, *, checked: bool = True) -> Design:
    """Load a shipped study by name, or a .toml file by path.

    checked: try every condition's settings as far as possible without a display, which takes a
    second for a large scene.
    Errors: InputError that names file and line, what was found and what was expected.
    """
    path = _path_of(name_or_path)
    return design_from_text(
        text_of(path, f"a .toml file, or one of {', '.join(study_names())}"), str(path), checked=checked
    )


def _path_of(name: str) -> Path:
    if name.endswith(".toml"):
        return Path(name)
    if name in study_names():
        return SHIPPED / f"{name}.toml"
    if Path(name).is_file():
        raise InputError(f"study file {name}: expected one whose name ends in .toml")
    raise unknown_name("study", name, [*study_names(), "FILE.toml"])


def design_from_text(text: str, path: str, *, checked: bool = True) -> Design:
    """Return the plan of a text.

    path: of its file, for messages and for files it names. checked: False does not try the
    settings, because the scenes of an old session may be gone. Errors: as load_design.
    """
    return parsed(text, path, lambda data: _design(data, text, path, checked), _EXAMPLE)


def _design(data: Table, text: str, path: str, checked: bool) -> Design:
    if (schema := data.whole("schema", 0, 2**31)) != SCHEMA:
        raise data.fault("schema", f"is {schema}: expected {SCHEMA}, which this version of hmdwarp reads")
    folder = Path(path).parent
    trial = data.table("trial")
    shows, order = trial.word("shows", SHOWS, ONE), trial.word("order", ORDERS, WILLIAMS)
    if order == ADAPTIVE and shows != PAIR:
        raise trial.fault("order", f'is {ADAPTIVE}, which chooses pairs: expected shows = "{PAIR}" beside it')
    checker = Checker(folder, data.table("common") if "common" in data else None, checked)
    scales = scales_of(trial, "scales", folder)
    sickness = sickness_of(data, folder)
    before, after = questionnaires_of(data, folder)
    _refuse_twice(trial, scales, sickness)
    parts = parts_of(data, checker)
    seconds, until_done = length_of(trial)
    return Design(
        name=_name(data),
        title=data.line("title"),
        parts=parts,
        scales=scales,
        families=families_of(data, parts),
        seconds=seconds,
        until_done=until_done,
        repeats=trial.whole("repeats", 1, 1000, 1),
        shows=shows,
        order=order,
        seed=data.whole("seed", 0, 2**63 - 1, 0),
        blind=data.word("blind", BLIND, BOTH),
        task=task_of(data, parts, checker),
        practice=practice_of(data, checker),
        practice_seconds=data.table("practice").within("seconds", 0, 3600, 60.0, above=True)
        if "practice" in data
        else 60.0,
        breaks=breaks_of(data),
        sickness=sickness,
        before=before,
        after=after,
        consent=consent_of(data, folder),
        instructions=page_of(data, "instructions", "Instructions", folder, checked),
        ready=page_of(data, "ready", "Ready?", folder, checked),
        thanks=page_of(data, "thanks", "Thank you", folder, checked),
        text=text,
        path=path,
        scene_notes=checker.scene_notes,
    )


def _name(data: Table) -> str:
    name = data.text("name")
    if not NAME.fullmatch(name):
        raise data.fault("name", f"is {quoted(name)}: {NAME_WANTED}")
    return name


def _refuse_twice(trial: Table, scales: tuple[Scale, ...], sickness: Sickness | None) -> None:
    """Refuse a scale that comes twice: an answer is known by trial, scale and item."""
    if sickness is not None and sickness.scale.name in [scale.name for scale in scales]:
        raise trial.fault(
            "scales", f"has '{sickness.scale.name}', which is also that of [sickness]: leave it out of one of them"
        )


TEMPLATE = Path(__file__).parent / "plan_template.toml"


def write_new_plan(name: str, folder: Path, *, force: bool = False) -> Path:
    """Write NAME.toml, a commented plan that can be run as it is, and return its path.

    Errors: InputError for a name that no study can have, a file that is there, unless forced,
    and a folder that cannot be written.
    """
    if not NAME.fullmatch(name) or name.endswith(".toml"):
        raise InputError(f"study name {quoted(name)}: {NAME_WANTED}, without .toml")
    path = folder / f"{name}.toml"
    refuse_existing(path, force=force)
    write_text(path, TEMPLATE.read_text(encoding="utf-8").format(name=name))
    return path
