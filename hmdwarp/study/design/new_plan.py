"""A new plan to begin with."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from ...tables import quoted
from ._parts import NAME, NAME_WANTED

TEMPLATE = Path(__file__).parent / "plan_template.toml"


def write_new_plan(name: str, folder: Path) -> Path:
    """Write NAME.toml, a commented plan that can be run as it is, and return its path.

    Errors: InputError for a name that no study can have, a file that is there, and a folder that
    cannot be written.
    """
    if not NAME.fullmatch(name) or name.endswith(".toml"):
        raise InputError(f"study name {quoted(name)}: {NAME_WANTED}, without .toml")
    path = folder / f"{name}.toml"
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(TEMPLATE.read_text(encoding="utf-8").format(name=name))
    except FileExistsError as error:
        raise InputError(f"{path} is there already, and is not overwritten: choose another name") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}): choose another folder") from error
    return path
