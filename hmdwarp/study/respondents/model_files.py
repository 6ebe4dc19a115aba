"""Load response models from their .toml files."""

from __future__ import annotations

import math
from pathlib import Path

from ...errors import unknown_name
from ...options import Table, parsed, text_of
from .response_model import Model, OtherRatings, RatingModel, SicknessModel

SCHEMA = 1
_FOLDER = Path(__file__).resolve().parent
_EXAMPLE = "the model of docs/response-models.md"


def model_names() -> list[str]:
    """Return the names of the shipped models, sorted; each has the name of its study."""
    return sorted(path.stem for path in _FOLDER.glob("*.toml"))


def load_model(name_or_path: str | Path) -> Model:
    """Load a shipped model by the name of its study, or any .toml file by path.

    Errors: InputError naming the file, the line and the value.
    """
    name = str(name_or_path)
    if not name.endswith(".toml") and name not in model_names():
        raise unknown_name("model", name, [*model_names(), "FILE.toml"])
    if not name.endswith(".toml"):
        return model_from_text((_FOLDER / f"{name}.toml").read_text(encoding="utf-8"), f"model {name}")
    return model_from_text(text_of(Path(name), f"a .toml file, or one of {', '.join(model_names())}"), name)


def model_from_text(text: str, path: str) -> Model:
    """Make the model from a text. path: for messages. Errors: as load_model."""
    return parsed(text, path, lambda data: _model(data, path), _EXAMPLE)


def _model(data: Table, path: str) -> Model:
    if data.raw("schema") != SCHEMA:
        raise data.fault("schema", f"is {data.raw('schema')!r}: expected {SCHEMA}, which this version of hmdwarp reads")
    ratings = data.table("rating")
    sessions = data.table("sessions") if "sessions" in data else Table({})
    answers = data.table("answers") if "answers" in data else Table({})
    looks = data.table("looks") if "looks" in data else Table({})
    return Model(
        path=path,
        title=data.text("title"),
        ratings={name: _rating(ratings.table(name)) for name in ratings.keys()},  # noqa: SIM118  (a Table is no dict)
        others=_others(data.table("others")) if "others" in data else None,
        sickness=_sickness(data.table("sickness")) if "sickness" in data else SicknessModel(),
        dropout=_share(sessions, "dropout"),
        pause=_share(sessions, "pause"),
        again=_share(sessions, "again"),
        median_s=answers.within("median_s", 0, 3600, 2.0, above=True),
        spread_s=answers.within("spread_s", 0, 5, 0.5),
        look_median_s=looks.within("median_s", 0, 3600, 20.0, above=True),
        look_spread_s=looks.within("spread_s", 0, 5, 0.5),
    )


def _rating(table: Table) -> RatingModel:
    return RatingModel(
        means=_means(table.table("means"), parts=True),
        people_sd=_spread(table, "people_sd"),
        condition_sd=_spread(table, "condition_sd"),
        noise_sd=_spread(table, "noise_sd"),
        drift=table.number("drift", 0.0),
        carry_over=table.within("carry_over", -1, 1, 0.0),
        missing=_share(table, "missing"),
        threshold=_spread(table, "threshold"),
    )


def _others(table: Table) -> OtherRatings:
    return OtherRatings(
        mean=table.within("mean", 0, 1),
        reference=table.within("reference", 0, 1),
        people_sd=_spread(table, "people_sd"),
        condition_sd=_spread(table, "condition_sd"),
        noise_sd=_spread(table, "noise_sd"),
        drift=table.number("drift", 0.0),
        missing=_share(table, "missing"),
    )


def _means(table: Table, *, parts: bool) -> dict[str, object]:
    """Read means by condition. parts: whether there may be a table for each part of the study."""
    out: dict[str, object] = {}
    for key in table.keys():  # noqa: SIM118  (a Table is no dict)
        inner = parts and isinstance(table.raw(key), dict)
        out[key] = _means(table.table(key), parts=False) if inner else table.number(key)
    return out


def _sickness(table: Table) -> SicknessModel:
    return SicknessModel(
        start=_share(table, "start"),
        per_trial=_share(table, "per_trial"),
        people_sd=_spread(table, "people_sd"),
        noise_sd=_spread(table, "noise_sd"),
    )


def _share(table: Table, key: str) -> float:
    return table.within(key, 0, 1, 0.0)


def _spread(table: Table, key: str) -> float:
    return table.within(key, 0, math.inf, 0.0)
