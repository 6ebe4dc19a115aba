"""The ratings of several studies as those of one: people and conditions are each study's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...errors import InputError, listed

Row = Mapping[str, Any]


def pooled(studies: Mapping[str, Sequence[Row]], scale: str = "") -> tuple[str, list[Row]]:
    """Return the scale, and the rows of all studies on it; people count from their own mean anyway.

    studies: rows as export.long_rows gives, by name. scale: by default the first that all have.
    Errors: InputError for a study without ratings on it, and where it has another good end.
    """
    scales = {name: tuple(dict.fromkeys(row["scale"] for row in rows)) for name, rows in studies.items()}
    common = [one for one in next(iter(scales.values()), ()) if all(one in found for found in scales.values())]
    chosen = scale or next(iter(common), "")
    lacking = [
        f"'{name}' ({listed(found) if found else 'nothing'})" for name, found in scales.items() if chosen not in found
    ]
    if lacking:
        wanted = f"on scale '{chosen}'" if chosen else "on one scale"
        raise InputError(f"expected ratings {wanted} in every study, and these have others: {listed(lacking)}")
    good = {name: bool(row["low_is_good"]) for name, rows in studies.items() for row in rows if row["scale"] == chosen}
    if len(set(good.values())) > 1:
        ways = listed([f"{'low' if low else 'high'} is good in '{name}'" for name, low in good.items()])
        raise InputError(f"the scale '{chosen}' is not the same in all studies: {ways}; predict each alone")
    return chosen, [_apart(name, row) for name, rows in studies.items() for row in rows if row["scale"] == chosen]


def _apart(study: str, row: Row) -> Row:
    """Name participant and part after the study, so that those of two are never one."""
    return {**row, **{key: f"{study}: {row.get(key) or ''}" for key in ("participant", "part")}}
