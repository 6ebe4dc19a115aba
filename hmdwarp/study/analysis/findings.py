"""What ratings say: conditions, comparisons, order, references, pairs, claims; plain data."""

from __future__ import annotations

import itertools
import math
import tomllib
import warnings
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import attrs
import numpy as np
import pandas as pd
from scipy.special import ndtr, stdtrit

from ...base import InputError, fields_in, import_extra, parsed, read_by, reads, text_of
from ...base import Table as Keys
from ...metrics import PRIMARY, metrics_in_order
from ...report import counted, listed
from .. import statistics as st
from ..design import SHIPPED, Comparison, Family, tables_of
from ..scales import FIRST, NEITHER, QUESTIONNAIRE, Scale, load_scale, scale_names, score_ranges, scored
from .long_table import Ratings, ScaleInfo, SourceOptions, from_csv

Row = dict[str, Any]
_LEVEL = 0.95
_EQUAL = 1e-9  # means of equal ratings may differ by rounding
_LEAST_LEVEL = 0.5  # of an exact interval: one difference gives 0 %, two give 50 %
_MOST_PAIRED = 45  # comparisons of a part without a plan: ten conditions, each against each
_LEAST_REST = 5  # degrees of freedom that must be left for the noise
RESAMPLES = 2000  # of people, for scores: the ends are then known to a tenth of the interval's width
LEAST_PEOPLE = 6  # fewer have no interval: their resamples are too alike for 95 %


@attrs.frozen
class Resampling:
    """Options of random draws: of BCa intervals where not all resamples count."""

    seed: int = st.SEED
    resamples: int = st.RESAMPLES


# --- conditions


def condition_rows(ratings: Ratings, part: str, scale: str) -> list[Row]:
    """Return a row per condition: n, median, mean, spread, and each participant's rating.

    "low" to "high" is Student's 95 % interval of the mean over people, cut at the ends of the scale
    (ITU-T P.910, 10/2023); None where n is too small, as the spread, or all rated alike.
    """
    table, info, references = ratings.table(part, scale), ratings.scale_info[scale], ratings.references(part)
    return [
        {
            "condition": name,
            "settings": ratings.settings(part, name),
            "reference": name in references,
            "n": int(column.count()),
            "missing": int(column.isna().sum()),
            "ratings": column.dropna().round(9).to_dict(),
            **_spread(column.dropna(), info),
        }
        for name, column in table.items()
    ]


def _spread(rated: pd.Series, info: ScaleInfo) -> Row:
    names = ("q1", "median", "q3", "mean", "sd", "least", "most", "low", "high")
    if rated.empty:
        return dict.fromkeys(names)
    mean, sd = float(rated.mean()), float(rated.std()) if len(rated) > 1 else None
    ends: tuple[float | None, float | None] = (None, None)
    if sd:
        half = float(stdtrit(len(rated) - 1, 0.5 + _LEVEL / 2)) * sd / math.sqrt(len(rated))
        least, most = (-math.inf, math.inf) if info.least is None or info.most is None else (info.least, info.most)
        ends = max(mean - half, least), min(mean + half, most)
    figures = (*rated.quantile([0.25, 0.5, 0.75]).tolist(), mean, sd, float(rated.min()), float(rated.max()), *ends)
    return dict(zip(names, figures, strict=True))


def reference_votes(table: pd.DataFrame, references: Sequence[str], info: ScaleInfo) -> Row | None:
    """Return how each participant rated the hidden reference against the median of their others.

    "better" and "same" are counts, "missed" the participants who rated it worse; "flat" counts
    those of "same" who gave everything the same rating. None without a reference.
    """
    if not references:
        return None
    own, others = table[list(references)].mean(axis=1), table.drop(columns=references).median(axis=1)
    worse_by = (info.sign * (own - others)).dropna()
    same = worse_by.index[worse_by.abs() <= _EQUAL]
    flat = (table.max(axis=1) - table.min(axis=1))[same] <= _EQUAL
    counts = {"rated": len(worse_by), "better": int((worse_by < -_EQUAL).sum()), "same": len(same)}
    missed = worse_by.index[worse_by > _EQUAL].tolist()
    return {**counts, "flat": int(flat.sum()), "missed": missed, "references": list(references)}


def order_effects(rows: pd.DataFrame) -> Row:
    """Estimate the effect of a trial's place (a slope per trial) and of the condition before it.

    Type II F tests by ordinary least squares, with participants and conditions. rows: of one part
    on one scale. Where the two effects are confounded, each is estimated without the other and
    names it ("or"). An effect that cannot be estimated is {"why_not": sentence}.
    """
    rated = rows[rows["value"].notna()]
    if rated.empty or not rated["place"].all():
        unknown = "the order in which the conditions were shown is not recorded"
        why = "nothing was rated" if rated.empty else unknown
        if rated["place"].any():
            why = "the place of some trials is not recorded"
        return {name: {"why_not": why} for name in ("place", "previous")}
    blocks = {
        "base": np.hstack([_dummies(rated["participant"]), _dummies(rated["condition"])[:, 1:]]),
        "place": rated[["place"]].to_numpy(float),
        "previous": _dummies(rated["previous"])[:, 1:],
    }
    values = rated["value"].to_numpy(float)
    others = {"place": "previous", "previous": "place"}
    return {name: _effect(values, blocks, name, other) for name, other in others.items()}


def _dummies(names: pd.Series) -> np.ndarray:
    return np.asarray(pd.get_dummies(names), float)


def _effect(values: np.ndarray, blocks: Mapping[str, np.ndarray], name: str, other: str) -> Row:
    """Estimate one effect; the other one leaves the model where the two are confounded."""
    base, effect = blocks["base"], blocks[name]
    rest = np.hstack([base, blocks[other]]) if _rank(base, blocks[other]) > _rank(base) else base
    df = _rank(rest, effect) - _rank(rest)
    if df == 0:
        if _rank(base, effect) == _rank(base):
            return {"why_not": "it is confounded with the conditions: all participants saw them in the same order"}
        alone = _effect(values, {**blocks, other: np.zeros((len(values), 0))}, name, other)
        return alone if "why_not" in alone else alone | {"or": other}
    if len(values) - _rank(rest, effect) < _LEAST_REST:
        return {"why_not": f"{counted(len(values), 'rating')} {'is' if len(values) == 1 else 'are'} too few for it"}
    ols = import_extra("statsmodels.api", "statsmodels", "study").OLS
    with warnings.catch_warnings():
        # Sums of squares, ranks and the slope are the same for every solution of least squares.
        warnings.filterwarnings("ignore", "The design matrix is rank-deficient")
        full, reduced = ols(values, np.hstack([rest, effect])).fit(), ols(values, rest).fit()
    if full.ssr <= 1e-20 * max(float((values**2).sum()), 1e-300):
        return {"why_not": "the ratings leave no noise to compare it with"}
    f, p, _ = full.compare_f_test(reduced)
    found: Row = {"f": float(f), "df": df, "df_rest": int(full.df_resid), "p": float(p)}
    if name == "place":
        found |= dict(zip(("slope", "low", "high"), map(float, (full.params[-1], *full.conf_int()[-1])), strict=True))
    return found


def _rank(*blocks: np.ndarray) -> int:
    matrix = np.hstack(blocks)
    return int(np.linalg.matrix_rank(matrix)) if matrix.shape[1] else 0


# --- what was asked beside the ratings


def _asked(ratings: Ratings, *, questionnaires: bool) -> Iterator[tuple[Scale, pd.DataFrame]]:
    """Yield each scale of the survey, known by the plan or shipped, with its answers."""
    for name, answers in ratings.survey.groupby("scale", sort=False):
        scale = ratings.scales.get(name) or (load_scale(name) if name in scale_names() else None)
        if scale is not None and (scale.kind == QUESTIONNAIRE) == questionnaires:
            yield scale, answers


def sickness_rows(ratings: Ratings) -> list[Row]:
    """Return for each sickness scale and trial the number, median and worst of the answers."""
    out = []
    for scale, answers in _asked(ratings, questionnaires=False):
        worst = "max" if scale.low_is_good else "min"
        by_trial = answers.groupby("trial")["value"].agg(n="count", median="median", worst=worst).reset_index()
        about = {"scale": scale.name, "title": scale.title, "least": scale.least, "most": scale.most}
        out.append({**about, "trials": by_trial.to_dict("records")})
    return out


def questionnaire_rows(ratings: Ratings) -> tuple[list[Row], list[Row]]:
    """Return a row for each score of questionnaires answered before and after, and answered once.

    The change is over those who answered both times, each of them once: a person's sessions are
    averaged, as ratings are. p is of the exact Wilcoxon test of the change, uncorrected: these
    comparisons are not planned.
    """
    twice, once = list[Row](), list[Row]()
    for scale, answers in _asked(ratings, questionnaires=True):
        sheets = {phase: _scores(scale, own) for phase, own in answers.groupby("phase") if phase in ("before", "after")}
        about = {"scale": scale.name, "title": scale.title}
        if len(sheets) == 1:
            ((phase, scores),) = sheets.items()
            least, most = score_ranges(scale)
            for score in scale.scores:
                ends = {"least": least[score.name], "most": most[score.name], "n": int(scores[score.name].count())}
                row = {**about, "score": score.name, "when": phase, "score_title": score.title or score.name, **ends}
                quartiles = scores[score.name].quantile([0.25, 0.5, 0.75])
                names = ("low_quartile", "median", "high_quartile")
                once.append(row | {name: _or_none(q) for name, q in zip(names, quartiles, strict=True)})
        elif sheets:
            for score in sheets["before"]:
                medians = {phase: _or_none(sheets[phase][score].median()) for phase in ("before", "after")}
                changes = (sheets["after"][score] - sheets["before"][score]).dropna().groupby(level=0).mean().to_numpy()
                row = {**about, "score": score, "n": len(changes), **medians}
                if len(changes):
                    row |= dict(zip(("change", "low", "high", "level"), _shift_of(changes), strict=True))
                    row["p"] = st.wilcoxon_exact(changes).p
                twice.append(row)
    return twice, once


def _scores(scale: Scale, answers: pd.DataFrame) -> pd.DataFrame:
    """Return the scores (columns) of each participant's session."""
    sheets = answers.groupby(["participant", "session"], sort=False)
    found = {who: scored(scale, dict(zip(own["item"], own["value"], strict=True))) for who, own in sheets}
    return pd.DataFrame.from_dict(found, orient="index", columns=[s.name for s in scale.scores], dtype=float)


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else float(value)


# --- comparisons


def families_for(ratings: Ratings, requested: Sequence[str] = ()) -> tuple[tuple[Family, ...], str]:
    """Return the families of comparisons, and a sentence on where they come from.

    requested: from the command line, "A:B;C:D" or "PART/A:B", each text a family. Without it the
    plan's families. Without a plan, in each part: at each latency no warp against each warp; else
    each condition against the hidden reference; else all pairs.
    Errors: InputError for names without ratings.
    """
    if requested:
        names = ["as requested"] if len(requested) == 1 else [f"as requested, {k + 1}" for k in range(len(requested))]
        asked = zip(requested, names, strict=True)
        return tuple(
            f for text, name in asked for f in _requested(text, name, ratings)
        ), "Compared: the pairs of --family."
    if ratings.families:
        return ratings.families, "Compared: what the study's file plans."
    found = {part: _default_pairs(ratings, part) for part in ratings.parts()}
    families = tuple(
        Family(f"{part}: {rule}" if part else rule, tuple(Comparison(part, a, b) for a, b in pairs))
        for part, (pairs, rule) in found.items()
        if pairs
    )
    rules = dict.fromkeys(rule for pairs, rule in found.values() if pairs)
    which = "; ".join(rules) or "nothing, as there is only one condition"
    return families, f"Compared: {which}. The data come without a plan; --family chooses other pairs."


def _requested(text: str, name: str, ratings: Ratings) -> list[Family]:
    head, slash, rest = text.partition("/")
    parts, pairs_text = ([head], rest) if slash and head in ratings.parts() else (ratings.parts(), text)
    pairs = [tuple(name.strip() for name in pair.split(":")) for pair in pairs_text.split(";")]
    if any(len(pair) != 2 or not all(pair) for pair in pairs):
        raise InputError(
            f"--family '{text}': expected pairs of conditions, like 'late-200:warped-200;late-400:warped-400'"
        )
    here = {part: [pair for pair in pairs if set(pair) <= set(ratings.conditions(part))] for part in parts}
    for a, b in pairs:
        if not any((a, b) in found for found in here.values()):
            names = "; ".join(dict.fromkeys(name for part in parts for name in ratings.conditions(part)))
            raise InputError(f"--family '{text}': no part has both '{a}' and '{b}': the conditions are {names}")
    return [
        Family(f"{part}: {name}" if part else name, tuple(Comparison(part, a, b) for a, b in found))
        for part, found in here.items()
        if found
    ]


def _default_pairs(ratings: Ratings, part: str) -> tuple[list[tuple[str, str]], str]:
    names = ratings.conditions(part)
    settings = {name: ratings.settings(part, name) for name in names}
    alike = {
        name: {key: str(value) for key, value in own.items() if key not in ("warp", "fill")}
        for name, own in settings.items()
    }
    bare = [name for name in names if settings[name].get("warp") == "none" and "latency_ms" in settings[name]]
    pairs = [(a, b) for a in bare for b in names if settings[b].get("warp", "none") != "none" and alike[a] == alike[b]]
    if pairs:
        return pairs, "at each latency no warp against each warp"
    if references := ratings.references(part):
        against = [(name, references[0]) for name in names if name not in references]
        return against, "each condition against the hidden reference"
    pairs = list(itertools.combinations(names, 2))
    if len(pairs) > _MOST_PAIRED:
        raise InputError(
            f"{len(names)} conditions and no plan: choose with --family which of the {len(pairs)} pairs to compare"
        )
    return pairs, "each condition against each"


def compared(
    ratings: Ratings,
    scale: str,
    families: Sequence[Family],
    resampling: Resampling,
    without: Mapping[str, list[str]] = {},
) -> list[Row]:
    """Return all comparisons on a scale, with Holm's p within the family and over all.

    without: by part, participants to leave out.
    """
    rows = []
    for family, comparison in ((f, one) for f in families for one in f.comparisons):
        table = ratings.table(comparison.part, scale).drop(index=without.get(comparison.part, []), errors="ignore")
        if {comparison.baseline, comparison.better} <= set(table.columns):
            rows.append(_compared(table, ratings.scale_info[scale], family.name, comparison, resampling))
    correct(rows, over_all=True)
    return rows


def _compared(table: pd.DataFrame, info: ScaleInfo, family: str, of: Comparison, resampling: Resampling) -> Row:
    found = (info.sign * (table[of.baseline] - table[of.better])).round(9).dropna()
    values, names = found.to_numpy(), ["mean", "sd", "median", "w_plus", "w_minus", "p", "smallest_p"]
    names += ["rank_biserial", "shift", "shift_low", "shift_high", "shift_level", "low", "high"]
    row = {
        "part": of.part,
        "scale": info.name,
        "family": family,
        "condition": of.better,
        "baseline": of.baseline,
        "n": len(found),
        "better": int((found > 0).sum()),
        "equal": int((found == 0).sum()),
        "worse": int((found < 0).sum()),
        "differences": found.to_dict(),
        "left_out": table.index.difference(found.index, sort=False).tolist(),
        **dict.fromkeys(names),
    }
    if len(values) > st.MOST_PAIRS:
        raise InputError(
            f"{len(values)} participants rated both of two conditions: the exact test takes {st.MOST_PAIRS} at most"
        )
    if not len(values):
        return row
    test = st.wilcoxon_exact(values)
    # One difference, or equal ones, have no spread to resample: a point is no interval.
    ends = (None, None) if st.is_degenerate(values) else st.bca(values, resampling.seed, resampling.resamples)
    figures = (
        float(values.mean()), float(values.std(ddof=1)) if len(values) > 1 else None, float(np.median(values)),
        test.w_plus, test.w_minus, test.p, st.smallest_p(test.n), st.rank_biserial(values), *_shift_of(values), *ends,
    )  # fmt: skip
    return row | dict(zip(names, figures, strict=True))


def _shift_of(values: np.ndarray) -> tuple[float, float | None, float | None, float | None]:
    """Return the Hodges-Lehmann shift, its interval and level, None where that is too low."""
    shift, level = st.hodges_lehmann(values), st.attained_level(len(values))
    return (*shift, level) if level >= _LEAST_LEVEL else (shift.shift, None, None, None)


def correct(rows: list[Row], *, over_all: bool = False) -> None:
    """Put Holm's p into each row, within its family; over_all: over all rows as well.

    A planned comparison without ratings counts with p = 1: to leave it out would favour the rest.
    """
    families = [[row for row in rows if row["family"] == name] for name in dict.fromkeys(row["family"] for row in rows)]
    for group, key in [*((group, "holm") for group in families), *([(rows, "holm_all")] if over_all else [])]:
        for row, p in zip(group, st.holm([1.0 if row["p"] is None else row["p"] for row in group]), strict=True):
            row |= {key: None if row["p"] is None else p, f"{key}_of": len(group)}


# --- pairs that were compared


def preference_results(ratings: Ratings, families: Sequence[Family], resampling: Resampling) -> list[Row]:
    """Return the results of each part with paired comparisons.

    Scores are in JOD: the hidden reference, or without one the mean, has 0. "p" is of the exact
    Wilcoxon test of each person's choices for less those against, where both were shown together.
    """
    parts = ratings.preferences.groupby(["part", "scale"], sort=False)
    return [_preferred(ratings, planned, families, resampling) for _, planned in parts]


def _preferred(ratings: Ratings, planned: pd.DataFrame, families: Sequence[Family], resampling: Resampling) -> Row:
    first, given = planned.iloc[0], planned[planned["answer"].notna()]
    found: Row = {
        "part": first["part"],
        "scale": first["scale"],
        "people": given["participant"].nunique(),
        "answers": len(given),
        "ties": int((given["answer"] == NEITHER).sum()),
        "first": int((given["answer"] == FIRST).sum()),
        "missing": len(planned) - len(given),
        "threshold": None,
        "conditions": [],
        "comparisons": [],
    }
    if given.empty:
        return found
    names = ratings.conditions(first["part"])
    pairs = given.groupby("participant", sort=False)[["first", "second", "answer"]]
    tables = [
        tables_of(names, [((a, b), answer) for a, b, answer in own.itertuples(index=False)], allows_ties=True)
        for _, own in pairs
    ]
    wins, ties = (np.array([table[k] for table in tables]) for k in (0, 1))
    tied = ties if first["allows_ties"] or ties.any() else None
    scores = st.jod_scores(wins.sum(axis=0), None if tied is None else tied.sum(axis=0))
    resampled = left_out = None
    if len(wins) >= LEAST_PEOPLE:
        count = min(RESAMPLES, resampling.resamples)
        resampled = st.resampled_scores(wins, tied, count, resampling.seed).jod
        left_out = st.left_out_scores(wins, tied).jod

    def score(weights: np.ndarray) -> Row:
        """Return a weighted sum of scores, "jod", with its interval, "low" to "high"."""
        jod, ends = float(scores.jod @ weights), tuple[Any, ...]((None, None))
        if resampled is not None and left_out is not None and weights.any():
            ends = st.resampled_interval(jod, resampled @ weights, left_out @ weights)
        return dict(zip(("jod", "low", "high"), (jod, *ends), strict=True))

    places, zero = np.eye(len(names)), first["reference"]
    total = pd.DataFrame(wins.sum(axis=0), names, names)
    neither = pd.DataFrame(ties.sum(axis=0), names, names)
    found["threshold"] = None if tied is None else float(scores.threshold)
    found["conditions"] = [
        {
            "condition": name,
            "reference": name == zero,
            **score(places[k] - (places[names.index(zero)] if zero in names else 0)),
            "preferred": int(total.loc[name].sum()),
            "other_preferred": int(total[name].sum()),
            "neither": int(neither.loc[name].sum()),
        }
        for k, name in enumerate(names)
    ]
    for family, one in ((f, one) for f in families for one in f.comparisons):
        if one.part == first["part"] and {one.baseline, one.better} <= set(names):
            a, b = names.index(one.better), names.index(one.baseline)
            together = wins[:, a, b] + wins[:, b, a] + ties[:, a, b] > 0
            net = (wins[:, a, b] - wins[:, b, a])[together]
            row: Row = {"part": one.part, "family": family.name, "condition": one.better, "baseline": one.baseline}
            row |= {"people": len(net), "for": int(total.loc[one.better, one.baseline])}
            row |= {"against": int(total.loc[one.baseline, one.better]), "neither": int(neither.iloc[a, b])}
            row |= score(places[a] - places[b])
            shares = {"share": "jod", "share_low": "low", "share_high": "high"}  # of forced choices
            row |= {
                key: None if row[of] is None else float(ndtr(row[of] / st.JOD_SPREAD)) for key, of in shares.items()
            }
            found["comparisons"].append(row | {"p": st.wilcoxon_exact(net).p if len(net) else None})
    correct(found["comparisons"])
    return found


# --- published figures

_EXAMPLE = "the example of docs/study-analysis.md"
_PUBLISHED = (
    "These published ratings ship with hmdwarp; so do the figures published with them, which are compared with them."
)


@attrs.frozen
class _Claim:
    """One published figure."""

    part: str = attrs.field(metadata=reads(Keys.text))
    step: float  # what it was rounded to
    # Mean, positive where `better` was rated better; None: a mere mention.
    difference: float | None = read_by(Keys.number, default=None)
    # Means the comparison at that latency, instead of a pair.
    latency_ms: float | None = read_by(Keys.number, default=None)
    baseline: str = read_by(Keys.text, default="")
    better: str = read_by(Keys.text, default="")
    where: str = read_by(Keys.text, default="")  # in the text


@attrs.frozen
class Claims:
    """Figures of one publication."""

    title: str = attrs.field(metadata=reads(Keys.text))  # of the publication, for sentences
    claims: tuple[_Claim, ...]
    why_step: str = read_by(Keys.text, default="")  # how the step is known


def load_claims(path: Path) -> Claims:
    """Load a .toml file of claims. A figure counts as rounded to its last digit without `step`."""
    text = text_of(path, f"a .toml file of published figures: {_EXAMPLE} shows one")

    def made(data: Keys) -> Claims:
        step, exact = data.number("step", None), tomllib.loads(text, parse_float=Decimal).get("claim", [])
        claims = []
        for table, raw in zip(data.tables("claim"), exact, strict=True):
            found = fields_in(table, _Claim)
            if found["latency_ms"] is None and not (found["baseline"] and found["better"]):
                raise table.fault("difference", "lacks its comparison: expected latency_ms, or baseline and better")
            last: Any = Decimal(str(raw.get("difference", 1))).as_tuple().exponent
            claims.append(_Claim(step=float(Decimal(1).scaleb(last)) if step is None else step, **found))
        return Claims(claims=tuple(claims), **fields_in(data, Claims))

    return parsed(text, path, made, _EXAMPLE)


def claims_for(path: Path | None, ratings: Ratings, options: SourceOptions) -> tuple[Claims | None, str]:
    """Return the figures of the file, else those shipped for these ratings, with a note."""
    if path is not None:
        return load_claims(path), ""
    key = ["part", "participant", "condition"]
    for table in sorted(SHIPPED.glob("*_ratings.csv")):
        claims = table.with_name(table.name.replace("_ratings.csv", "_claims.toml"))
        known = from_csv(table, attrs.evolve(options, columns={}, origin="", scale="grade")).rows
        own = ratings.rows.set_index(key)["value"].sort_index()
        if claims.is_file() and known.set_index(key)["value"].sort_index().equals(own):
            return load_claims(claims), _PUBLISHED
    return None, ""


def checked(claim: _Claim, rows: Sequence[Row], ratings: Ratings, scale: str) -> Row:
    """Compare a claim with the data. rows: as compared.

    A figure follows where the mean difference of the pairs is within one step of it, which rounding
    or truncation explains. Otherwise "others" holds what else may have been meant. A claim about a
    latency without ratings names the latencies that were rated.
    """
    found = {name: getattr(claim, name) for name in ("part", "latency_ms", "difference", "step", "where")}
    if claim.part not in ratings.parts():
        why = f"there is no part '{claim.part}' among {', '.join(ratings.parts())}"
        return found | {"follows": None, "why_not": why}

    def is_about(row: Row) -> bool:
        pair = row["baseline"], row["condition"]
        if claim.baseline:
            return bool(pair == (claim.baseline, claim.better))
        return {ratings.settings(claim.part, name).get("latency_ms") for name in pair} == {claim.latency_ms}

    own = [row for row in rows if row["part"] == claim.part and is_about(row)]
    if not own:
        why = f"'{claim.baseline}' and '{claim.better}' are not compared"
        if claim.latency_ms is not None:
            known = ratings.rows.loc[ratings.rows["part"] == claim.part, "latency_ms"].dropna().unique()
            latencies = ", ".join(f"{latency_ms:g}" for latency_ms in sorted(known))
            why = f"nothing was rated at {claim.latency_ms:g} ms: the latencies are {latencies} ms"
        return found | {"follows": False, "why_not": why}
    row = own[0]
    found |= {"baseline": row["baseline"], "condition": row["condition"], "data": row["mean"], "n": row["n"]}
    if claim.difference is None:
        return found | {"follows": True}
    if row["mean"] is None:
        return found | {"follows": None, "why_not": f"nobody rated both '{row['baseline']}' and '{row['condition']}'"}
    if abs(row["mean"] - claim.difference) <= claim.step + _EQUAL:
        return found | {"follows": True}
    table, sign = ratings.table(claim.part, scale), ratings.scale_info[scale].sign
    a, b = table[row["baseline"]], table[row["condition"]]
    others = {
        "difference of the means over all who rated either": float(sign * (a.mean() - b.mean())),
        "difference of the medians": float(sign * (a.median() - b.median())),
        "median difference": row["median"],
    }
    near = [name for name, value in others.items() if abs(value - claim.difference) <= claim.step + _EQUAL]
    return found | {"follows": False, "others": others, "explained_by": near}


# Title of each column of the long table that is a measure.
MEASURES = {
    **{
        f"measured_{metric.name}": metric.study_title
        for metric in sorted(metrics_in_order(), key=lambda m: (m.name != PRIMARY, not m.is_contest, m.order))
    },
    "actual_latency_ms_median": "age of the frame",
    "actual_latency_ms_sd": "jitter of that age",
    "actual_hole_share_mean": "holes in the live picture",
    "actual_pose_age_ms_median": "age of the pose",
    "actual_missed_share": "missed refreshes",
    "actual_period_ms_p95": "95th percentile between pictures",
    "actual_angular_speed_deg_s_median": "speed of the turning head",
}
_STILL = 1e-9  # of its own size: what varies less is constant but for rounding


class Correlation(NamedTuple):
    """Repeated-measures correlation with its 95 % interval and the p of no association."""

    r: float
    low: float
    high: float
    p: float
    dof: int


def _within_people(x: pd.Series, y: pd.Series, who: pd.Series) -> Correlation | str:
    """Return the correlation with Fisher's interval, or the reason why there is none."""
    from scipy.special import stdtr

    several = who.groupby(who).transform("size") > 1
    x, y, who = x[several].astype(float), y[several].astype(float), who[several]
    dof = len(x) - who.nunique() - 1
    if dof < 2:
        return "too few ratings"
    dx, dy = (values - values.groupby(who).transform("mean") for values in (x, y))
    if dx.abs().max() <= _STILL * x.abs().max():
        return "the same in all trials of each person"
    if dy.abs().max() <= _STILL:
        return "every person gave one rating throughout"
    dx = dx / dx.abs().max()  # so that squares of 1e-200 are no 0
    r = min(1.0, max(-1.0, float((dx * dy).sum() / math.sqrt((dx**2).sum() * (dy**2).sum()))))
    if abs(r) == 1:
        return Correlation(r, r, r, 0.0, dof)
    half = 1.959963984540054 / math.sqrt(dof - 1)
    low, high = (math.tanh(math.atanh(r) + side * half) for side in (-1, 1))
    return Correlation(r, low, high, float(2 * stdtr(dof, -abs(r) * math.sqrt(dof / (1 - r * r)))), dof)


def correlation_data(rows: pd.DataFrame, scale: str) -> dict[str, Any] | None:
    """Return each measure's correlation, with sentences; positive: more of it was rated worse."""
    rated = rows[(rows["scale"] == scale) & rows["value"].notna()]
    there = [name for name in MEASURES if name in rated and rated[name].notna().any()]
    if not there:
        return None
    worse = rated["value"] * (1 if rated["low_is_good"].iloc[0] else -1)
    how = rated[[name for name in ("measured_size", "measured_every") if name in rated]].dropna(how="all")
    mixed = len(how.drop_duplicates()) > 1
    found, left_out, reasons = [], [], dict[str, list[str]]()
    for name, title in MEASURES.items():
        is_metric = name.startswith("measured_")
        if name not in there:
            result: Correlation | str = "not measured; 'study measure' does it" if is_metric else "not measured"
        elif is_metric and mixed:
            result = "measured with several sizes or steps: 'study measure' with one --size makes them alike"
        else:
            own = rated[rated[name].notna()]
            result = _within_people(own[name], worse[own.index], own["participant"])
        if isinstance(result, str):
            left_out.append([title, result])
            reasons.setdefault(result, []).append(title)
        else:
            found.append({"name": name, "title": title, **result._asdict()})
    texts = [f"{one['title']} {one['r']:+.2f} (95 % {one['low']:+.2f} .. {one['high']:+.2f})" for one in found]
    said = [f"Within a person the ratings go with {listed(texts)}; positive: more is rated worse."] if texts else []
    said += [f"Not tested: {listed(titles)} ({reason})." for reason, titles in reasons.items()]
    return {"sentences": said, "measures": found, "left_out": left_out}
