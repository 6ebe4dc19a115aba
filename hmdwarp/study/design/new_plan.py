"""A new plan to begin with."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from ...options.tables import quoted
from ...report import refuse_existing, write_text
from ._parts import NAME, NAME_WANTED

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
