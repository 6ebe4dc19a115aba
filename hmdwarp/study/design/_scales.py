"""The scales a study file names."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from ...tables import Table
from ..scales import QUESTIONNAIRE, RATING, Scale, load_scale


def scale_at(table: Table, key: str, name: str, folder: Path, *within: int) -> Scale:
    """A shipped scale, or a .toml file that lies beside the study's. Errors: KeyFault."""
    try:
        return load_scale(str(folder / name) if name.endswith(".toml") else name)
    except InputError as error:
        raise table.fault(key, f"has '{name}': {error}", *within) from error


def scales_of(table: Table, key: str, folder: Path, *, questionnaires: bool = False) -> tuple[Scale, ...]:
    """All of a list. questionnaires: whether they are asked around the session; else after each trial."""
    names = table.texts(key) if not questionnaires else table.texts(key, ())
    made: list[Scale] = []
    for number, name in enumerate(names):
        scale = scale_at(table, key, name, folder, number)
        if not questionnaires and scale.kind == QUESTIONNAIRE:
            raise table.fault(
                key,
                f"has '{name}', a questionnaire of {len(scale.items)} items: wanted what is asked in a moment",
                number,
            )
        if scale.name in [one.name for one in made]:
            raise table.fault(key, f"has '{scale.name}' twice: wanted each scale once", number)
        made.append(scale)
    if not made and not questionnaires:
        raise table.fault(key, "is empty: wanted one scale at least; 'hmdwarp list scales' shows those there are")
    if not questionnaires and all(scale.kind != RATING for scale in made):
        # Tables of ratings and the analysis are of that kind alone.
        raise table.fault(
            key,
            f"has no rating ({', '.join(names)}): wanted one scale of kind rating at least; [sickness] asks the others",
        )
    return tuple(made)
