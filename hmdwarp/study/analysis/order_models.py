"""Effects of a trial's place and of the condition before it, by linear models."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...report import counted
from ...resources import import_extra
from .ratings import Rating

_LEAST_REST = 5  # degrees of freedom that must be left for the noise
_FIRST = "(nothing)"


def order_effects(rows: Sequence[Rating]) -> dict[str, Any]:
    """Estimate the effect of a trial's place (a slope per trial) and of the condition before it.

    Type II F tests by ordinary least squares, beside participants and conditions. rows: of one part
    on one scale. Where the two effects are confounded, each is estimated without the other and
    names it ("or"). An effect that cannot be estimated is {"why_not": sentence}: nothing was rated,
    the order is not recorded, or it is the same for all participants.
    """
    rated = [row for row in rows if row.value is not None]
    if not all(row.place for row in rated) or not rated:
        why = (
            "nothing was rated"
            if not rated
            else "the place of some trials is not recorded"
            if any(row.place for row in rated)
            else "the order in which the conditions were shown is not recorded"
        )
        return {name: {"why_not": why} for name in ("place", "previous")}
    blocks = {
        "base": np.hstack(
            [_dummies([row.participant for row in rated]), _dummies([row.condition for row in rated])[:, 1:]]
        ),
        "place": np.array([[row.place] for row in rated], float),
        "previous": _dummies([row.previous or _FIRST for row in rated])[:, 1:],
    }
    values = np.array([row.value for row in rated], float)
    return {
        "place": _effect(values, blocks, "place", "previous"),
        "previous": _effect(values, blocks, "previous", "place"),
    }


def _dummies(names: Sequence[str]) -> NDArray[np.float64]:
    levels = list(dict.fromkeys(names))
    return np.array([[float(name == level) for level in levels] for name in names])


def _effect(values: NDArray, blocks: dict[str, NDArray], name: str, other: str) -> dict[str, Any]:
    """Estimate one effect; the other one leaves the model where the two are confounded."""
    effect = blocks[name]
    rest = blocks["base"] if not _adds(blocks["base"], blocks[other]) else np.hstack([blocks["base"], blocks[other]])
    model = np.hstack([rest, effect])
    df = _rank(model) - _rank(rest)
    if df == 0:
        if _rank(np.hstack([blocks["base"], effect])) > _rank(blocks["base"]):
            alone = _effect(values, {**blocks, other: np.zeros((len(values), 0))}, name, other)
            return alone if "why_not" in alone else alone | {"or": other}
        return {"why_not": "it is confounded with the conditions: all participants saw them in the same order"}
    if len(values) - _rank(model) < _LEAST_REST:
        return {"why_not": f"{counted(len(values), 'rating')} {'is' if len(values) == 1 else 'are'} too few for it"}
    api = import_extra("statsmodels.api", "statsmodels", "study")
    with warnings.catch_warnings():
        # Sums of squares, ranks and the slope are the same for every solution of least squares.
        warnings.filterwarnings("ignore", "The design matrix is rank-deficient")
        full, reduced = api.OLS(values, model).fit(), api.OLS(values, rest).fit()
    noise = float(full.ssr)
    if noise <= 1e-20 * max(float((values**2).sum()), 1e-300):
        return {"why_not": "the ratings leave no noise to compare it with"}
    f, p, _ = full.compare_f_test(reduced)
    found: dict[str, Any] = {"f": float(f), "df": df, "df_rest": int(full.df_resid), "p": float(p)}
    if name == "place":
        low, high = full.conf_int()[-1]
        found |= {"slope": float(full.params[-1]), "low": float(low), "high": float(high)}
    return found


def _adds(base: NDArray, block: NDArray) -> bool:
    return block.shape[1] > 0 and _rank(np.hstack([base, block])) > _rank(base)


def _rank(matrix: NDArray) -> int:
    return int(np.linalg.matrix_rank(matrix)) if matrix.shape[1] else 0
