"""Study files (.toml) to Design objects; what is wrong in one is told with its line."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from ...registry import unknown_name
from ...tables import Table, parsed, text_of, told
from ..scales import Scale
from ._around import breaks_of, consent_of, practice_of, questionnaires_of, sickness_of
from ._parts import NAME, NAME_WANTED, Checker, families_of, parts_of
from ._scales import scales_of
from .nouns import BLIND, BOTH, ORDERS, WILLIAMS, Design, Sickness

SCHEMA = 1
READY = Path(__file__).resolve().parent.parent / "ready"
_EXAMPLE = "thesis.toml ('hmdwarp study plan thesis' tells where it lies)"


def ready_names() -> list[str]:
    """Names of the shipped studies, sorted. Files called NAME_more.toml belong to one of them and are none themselves."""
    return sorted(p.stem for p in READY.glob("*.toml") if "_" not in p.stem)


def load_design(name_or_path: str, *, checked: bool = True) -> Design:
    """A shipped study by name, or a .toml file by path. checked: every condition's settings are tried as far as they can be without a
    display, which takes a second for a large scene. Errors: InputError that names file and line, what was found and what was wanted."""
    path = _path_of(name_or_path)
    return design_from_text(
        text_of(path, f"a .toml file, or one of {', '.join(ready_names())}"), str(path), checked=checked
    )


def _path_of(name: str) -> Path:
    if name.endswith(".toml"):
        return Path(name)
    if name in ready_names():
        return READY / f"{name}.toml"
    if Path(name).is_file():
        raise InputError(f"study file {name}: wanted one whose name ends in .toml")
    raise unknown_name("study", name, [*ready_names(), "FILE.toml"])


def design_from_text(text: str, path: str, *, checked: bool = True) -> Design:
    """The plan in a text. path: where it lies, for messages and for files it names. checked: False leaves out trying the settings, for
    looking at a session of long ago whose scenes may be gone. Errors: as load_design."""
    return parsed(text, path, lambda data: _design(data, text, path, checked), _EXAMPLE)


def _design(data: Table, text: str, path: str, checked: bool) -> Design:
    if (schema := data.whole("schema", 0, 2**31)) != SCHEMA:
        raise data.fault("schema", f"is {schema}: wanted {SCHEMA}, which this version of hmdwarp reads")
    folder = Path(path).parent
    trial = data.table("trial")
    checker = Checker(folder, data.table("common") if "common" in data else None, checked)
    scales = scales_of(trial, "scales", folder)
    sickness = sickness_of(data, folder)
    before, after = questionnaires_of(data, folder)
    _refuse_twice(trial, scales, sickness)
    parts = parts_of(data, checker)
    return Design(
        name=_name(data),
        title=data.line("title"),
        parts=parts,
        scales=scales,
        families=families_of(data, parts),
        seconds=trial.within("seconds", 0, 3600, 20.0, above=True),
        repeats=trial.whole("repeats", 1, 1000, 1),
        order=trial.word("order", ORDERS, WILLIAMS),
        seed=data.whole("seed", 0, 2**63 - 1, 0),
        blind=data.word("blind", BLIND, BOTH),
        practice=practice_of(data, checker),
        practice_seconds=data.table("practice").within("seconds", 0, 3600, 60.0, above=True)
        if "practice" in data
        else 60.0,
        breaks=breaks_of(data),
        sickness=sickness,
        before=before,
        after=after,
        consent=consent_of(data, folder),
        text=text,
        path=path,
    )


def _name(data: Table) -> str:
    name = data.text("name")
    if not NAME.fullmatch(name):
        raise data.fault("name", f"is {told(name)}: {NAME_WANTED}")
    return name


def _refuse_twice(trial: Table, scales: tuple[Scale, ...], sickness: Sickness | None) -> None:
    """An answer is known by the trial, the scale and the item it belongs to."""
    if sickness is not None and sickness.scale.name in [scale.name for scale in scales]:
        raise trial.fault(
            "scales", f"has '{sickness.scale.name}', which [sickness] asks as well: leave it out of one of them"
        )
