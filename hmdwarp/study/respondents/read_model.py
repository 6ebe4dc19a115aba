"""Files of simulated participants (.toml) to Model objects; what is wrong in one is told with its line."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

from ...errors import InputError
from ...registry import unknown_name
from ...tables import KeyFault, LineFinder, Table
from .model import Model, RatingModel, SicknessModel

SCHEMA = 1
_FOLDER = Path(__file__).resolve().parent
_EXAMPLE = str(_FOLDER / "thesis.toml")
_MOST_BYTES = 1_000_000


def model_names() -> list[str]:
    """Names of the shipped ones, sorted: each is called like the study it is for."""
    return sorted(path.stem for path in _FOLDER.glob("*.toml"))


def load_model(name_or_path: str | Path) -> Model:
    """A shipped model by the name of its study, or a .toml file by path. Errors: InputError that names the file, the line and the value."""
    path = _path_of(str(name_or_path))
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"model file {path}: {error.strerror}: wanted a .toml file, or one of {', '.join(model_names())}"
        ) from error
    if len(data) > _MOST_BYTES:
        raise InputError(f"model file {path}: {len(data)} bytes: wanted a few numbers, in at most {_MOST_BYTES}")
    try:
        return model_from_text(data.decode("utf-8"), str(path))
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(f"{path}:{line}: byte {data[error.start]:#x}: wanted a text in UTF-8") from error


def model_from_text(text: str, path: str) -> Model:
    """The model in a text. Errors: as load_model."""
    text = text.replace("\r\n", "\n")
    try:
        return _model(Table(tomllib.loads(text), example=_EXAMPLE), path)
    except KeyFault as error:
        raise InputError(f"{path}:{LineFinder(text).line(error.path)}: {error}") from error
    except (ValueError, RecursionError) as error:
        found = re.fullmatch(r"(.*) \(at line (\d+), column \d+\)", str(error), re.DOTALL)
        where, says = (f"{path}:{found[2]}", found[1]) if found else (path, str(error))
        raise InputError(f"{where}: this is no TOML: {says}") from error


def _path_of(name: str) -> Path:
    if name.endswith(".toml"):
        return Path(name)
    if name not in model_names():
        raise unknown_name("model", name, [*model_names(), "FILE.toml"])
    return _FOLDER / f"{name}.toml"


def _model(data: Table, path: str) -> Model:
    if data.raw("schema") != SCHEMA:
        raise data.fault("schema", f"is {data.raw('schema')!r}: wanted {SCHEMA}, which this version of hmdwarp reads")
    ratings = data.table("rating")
    made = Model(
        path=path,
        title=data.text("title"),
        ratings={name: _rating(ratings.table(name)) for name in ratings.keys()},  # noqa: SIM118  (a Table is no dict)
        **(_numbers(data.table("sessions"), "dropout", "pause", "again") if "sessions" in data else {}),
        **(_times(data.table("answers")) if "answers" in data else {}),
        **({"sickness": _sickness(data.table("sickness"))} if "sickness" in data else {}),
    )
    data.refuse_unread()
    return made


def _rating(table: Table) -> RatingModel:
    spreads = {key: table.within(key, 0, math.inf, 0.0) for key in ("people_sd", "condition_sd", "noise_sd")}
    return RatingModel(
        means=_means(table.table("means"), parts=True),
        **spreads,
        drift=table.number("drift", 0.0),
        carry_over=table.within("carry_over", -1, 1, 0.0),
        missing=table.within("missing", 0, 1, 0.0),
    )


def _means(table: Table, *, parts: bool) -> dict[str, object]:
    """parts: whether there may be tables in it, one for each part of the study."""
    out: dict[str, object] = {}
    for key in table.keys():  # noqa: SIM118  (a Table is no dict)
        inner = parts and isinstance(table.raw(key), dict)
        out[key] = _means(table.table(key), parts=False) if inner else table.number(key)
    return out


def _sickness(table: Table) -> SicknessModel:
    spreads = {key: table.within(key, 0, math.inf, 0.0) for key in ("people_sd", "noise_sd")}
    return SicknessModel(
        start=table.within("start", 0, 1, 0.0), per_trial=table.within("per_trial", 0, 1, 0.0), **spreads
    )


def _numbers(table: Table, *keys: str) -> dict[str, float]:
    """Probabilities."""
    return {key: table.within(key, 0, 1, 0.0) for key in keys}


def _times(table: Table) -> dict[str, float]:
    return {
        "median_s": table.within("median_s", 0, 3600, 2.0, above=True),
        "spread_s": table.within("spread_s", 0, 5, 0.5),
    }
