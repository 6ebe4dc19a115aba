"""The analysis of a study: one long table of ratings, what it says, and its page and files."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...base import PAPER, PaperOptions, __version__, made_with
from ...report import (
    ALPHA,
    OutputFolder,
    counted,
    csv_tables,
    listed,
    p_is,
    pair_text,
    plain,
    signed,
    study_page,
    write_paper,
)
from ..design import SHIPPED, Family
from ..statistics import friedman, kendalls_w
from . import findings
from .findings import LEAST_PEOPLE, Claims, Resampling, correlation_data, families_for, load_claims
from .long_table import Ratings, ScaleInfo, SourceOptions, from_csv

SCHEMA = 1
_REPORT, DATA = "report.html", "analysis.json"
Row = dict[str, Any]


def analysis_folder(folder: str | os.PathLike[str], *, force: bool = False) -> OutputFolder:
    """Return the folder to write an analysis to; made before the work, it checks the place."""
    return OutputFolder(folder, owned=("tables/*.csv", _REPORT, *PAPER), last=DATA, force=force)


def write_analysis(out: OutputFolder, data: Mapping[str, Any], command: str, paper: PaperOptions | None = None) -> Path:
    """Write an analysis and return the path that its page will have. Errors: as analysis_folder."""
    for name, (columns, rows) in csv_tables(data).items():
        out.write_csv(f"tables/{name}", rows, columns)
    page = study_page(data, command)
    out.write_text(_REPORT, page.html())
    write_paper(out, page, paper or PaperOptions())
    out.write_json(DATA, data)
    return out.folder / _REPORT


def analyse(
    ratings: Ratings,
    resampling: Resampling = Resampling(),  # noqa: B008  (frozen)
    families: Sequence[str] = (),
    claims: Claims | None = None,
) -> Row:
    """Return the whole analysis as plain data, the same whatever the order of the rows.

    families: as families_for takes them. claims: published figures to compare with the data.
    Errors: as families_for; MachineError where statsmodels is missing.
    """
    rows = ratings.rows.assign(number=ratings.rows["participant"].str.extract(r"^([0-9]{1,9})$")[0].astype(float))
    order = ["part", "number", "participant", "session", "place", "repeat", "scale"]
    ratings = attrs.evolve(ratings, rows=rows.sort_values(order))
    compare, why = families_for(ratings, families)
    people = [*zip(ratings.rows["part"], ratings.rows["participant"], strict=True)]
    people += [*zip(ratings.preferences["part"], ratings.preferences["participant"], strict=True)]
    questionnaires, asked_once = findings.questionnaire_rows(ratings)
    sittings = ratings.sessions
    cut = sittings[sittings["status"] != "complete"].rename(columns={"planned": "of"}).to_dict("records")
    return {
        "schema": SCHEMA,
        "hmdwarp": __version__,
        "made_with": made_with(),
        "title": ratings.title,
        "source": ratings.source,
        "origin": ratings.origin,
        "seed": resampling.seed,
        "resamples": resampling.resamples,
        "compared": why,
        "notes": list(ratings.notes),
        "participants": len(set(people)),
        "ratings": int(ratings.rows["value"].notna().sum()),
        "missing": int(ratings.rows["value"].isna().sum()),
        "scales": [_on_scale(ratings, name, compare, resampling, claims) for name in ratings.rated_scales()],
        "preferences": said_of_preferences(findings.preference_results(ratings, compare, resampling)),
        "sittings": {"counts": sittings["status"].value_counts().sort_index().to_dict(), "cut": cut},
        "sickness": findings.sickness_rows(ratings),
        "questionnaires": questionnaires,
        "asked_once": asked_once,
    }


def _on_scale(
    ratings: Ratings, scale: str, families: Sequence[Family], resampling: Resampling, claims: Claims | None
) -> Row:
    info, table = ratings.scale_info[scale], ratings.rows
    rows = findings.compared(ratings, scale, families, resampling)
    published = [] if claims is None else [findings.checked(one, rows, ratings, scale) for one in claims.claims]
    lacking = table[(table["scale"] == scale) & table["value"].isna()].rename(columns={"why_missing": "why"})
    return {
        "measure": attrs.asdict(info),
        "comparisons": [row | {"sentence": _sentence_of_comparison(row, info)} for row in rows],
        "parts": [
            _part(ratings, part, scale, families, resampling)
            for part in ratings.parts()
            if len(ratings.of(part, scale))
        ],
        "claims": [row | {"sentence": _sentence_of_claim(row, claims.title, info)} for row in published if claims],
        "why_step": "" if claims is None else claims.why_step,
        "missing": lacking[["participant", "part", "condition", "session", "why"]].to_dict("records"),
        "prediction": correlation_data(table, scale),
    }


def _part(ratings: Ratings, part: str, scale: str, families: Sequence[Family], resampling: Resampling) -> Row:
    info, table, rows = ratings.scale_info[scale], ratings.table(part, scale), ratings.of(part, scale)
    test, effects = friedman(table.to_numpy()), findings.order_effects(rows)
    of_test = test and {**test._asdict(), "conditions": table.shape[1], "w": kendalls_w(test)}
    reference = findings.reference_votes(table, ratings.references(part), info)
    # Each rating less its participant's and its condition's mean, by place of its trial.
    rated = rows[rows["value"].notna() & (rows["place"] > 0)]
    means = [rated.groupby(name)["value"].transform("mean") for name in ("participant", "condition")]
    rest = rated["value"] - means[0] - means[1] + rated["value"].mean()
    found = {
        "part": part,
        "participants": len(table),
        "conditions": findings.condition_rows(ratings, part, scale),
        "friedman": of_test,
        "friedman_sentence": _sentence_of_friedman(of_test, part),
        "order": effects,
        "order_sentences": _sentences_of_order(effects, info),
        "places": [{"place": int(at), "rest": float(own)} for at, own in zip(rated["place"], rest, strict=True)],
        "reference": reference,
        "reference_sentence": _sentence_of_reference(reference),
    }
    if reference and reference["missed"]:
        again = findings.compared(ratings, scale, families, resampling, without={part: reference["missed"]})
        keys = ("condition", "baseline", "n", "mean", "p", "holm")
        found["without"] = [{key: row[key] for key in keys} for row in again if row["part"] == part]
    return found


def published_ratings(part: str, latency_ms: float) -> dict[str, float | None]:
    """Return what the published ratings of one part and latency say, and what the thesis says.

    mean: of the pairs' differences, positive where the warped picture was rated better, on the
    scale of grades; p: exact, two-sided, after Holm within the part.
    """
    scale = _published_analysis()["scales"][0]
    at = [claim for claim in scale["claims"] if (claim["part"], claim["latency_ms"]) == (part, latency_ms)]
    claim = next(claim for claim in at if claim["difference"] is not None)
    place = part, claim["baseline"], claim["condition"]
    row = next(row for row in scale["comparisons"] if (row["part"], row["baseline"], row["condition"]) == place)
    (conditions,) = (found["conditions"] for found in scale["parts"] if found["part"] == part)
    means = {condition["condition"]: condition["mean"] for condition in conditions}
    off = abs(row["mean"] - claim["difference"])
    figures = {"mean": row["mean"], "p": row["holm"], "published": claim["difference"], "off": off}
    return figures | {"late": means[row["baseline"]], "warped": means[row["condition"]]}


@functools.cache
def _published_analysis() -> Row:
    found = from_csv(SHIPPED / "thesis_ratings.csv", SourceOptions(scale="grade"))
    return analyse(found, claims=load_claims(SHIPPED / "thesis_claims.toml"))


# A bootstrap interval lies between the least and the largest difference. In 2 / 2^n of studies all
# n are on one side of a symmetric truth, and the interval misses it: five pairs hold it in 93.75 %
# at most.
_LEAST_FOR_BCA = 6


def _sentence_of_comparison(row: Row, scale: ScaleInfo) -> str:
    """Describe a comparison. row: as findings.compared."""
    where, better, other = f"{row['part']}: " if row["part"] else "", f"'{row['condition']}'", f"'{row['baseline']}'"
    if not row["n"]:
        return f"{where}no participant rated both {better} and {other}: they cannot be compared."
    votes = f"{row['better']} of {row['n']} rated {better} better than {other}, {row['worse']} worse"
    votes += f", {row['equal']} the same" if row["equal"] else ""
    return f"{where}{votes}; {_size(row, scale)} {_verdict(row, scale)}"


def _size(row: Row, scale: ScaleInfo) -> str:
    mean = f"mean difference {signed(row['mean'])} {scale.unit}"
    if row["low"] is None:
        why = "there is only one" if row["n"] == 1 else "all differences are the same"
        return f"{mean} (no interval: {why})."
    ends = f"{signed(row['low'])} to {signed(row['high'])}"
    if row["n"] < _LEAST_FOR_BCA:
        return f"{mean} (bootstrap {ends}, which is too short for 95 % with {counted(row['n'], 'pair')})."
    return f"{mean} (95 % {ends})."


def _verdict(row: Row, scale: ScaleInfo) -> str:
    of = row["holm_of"]
    after = f"After Holm over {counted(of, 'comparison')}" if of > 1 else "By the exact test"
    if row["holm"] <= ALPHA:
        # Not by the shift: it is 0 where more than half of the pairs are equal, which the test
        # leaves out.
        way = "better" if row["w_plus"] > row["w_minus"] else "worse"
        return f"{after} {p_is(row['holm'])}: '{row['condition']}' was rated {way}."
    if row["smallest_p"] > ALPHA:
        pairs = counted(row["better"] + row["worse"], "unequal pair")
        always = "" if row["equal"] else ", whatever the ratings"
        least = p_is(row["smallest_p"])[4:]
        return f"{pairs} cannot give a p below {least}, so this comparison shows nothing either way{always}."
    ends, level = (row["shift_low"], row["shift_high"]), f"{100 * row['shift_level']:.0f} %"
    if row["p"] <= ALPHA:
        low, high = map(signed, ends)
        alone = f"alone, the ratings fit differences from {low} to {high} {scale.unit} ({level})"
        return (
            f"{after} {p_is(row['holm'])}, by itself {p_is(row['p'])}: not significant at 5 % over all {of}; {alone}."
        )
    low, high = (
        f"{'a gain' if end > 0 else 'a loss'} of {plain(abs(end))} {scale.unit}" if end else "no difference"
        for end in ends
    )
    none = "no difference is shown, which does not mean that there is none"
    return f"{after} {p_is(row['holm'])}: {none}: the ratings fit anything from {low} to {high} ({level})."


def _sentence_of_friedman(row: Row | None, part: str) -> str:
    """Say whether any condition differs at all."""
    where = f"{part}: " if part else ""
    if row is None:
        return f"{where}Friedman's test needs three conditions and two participants who rated all of them."
    differ = "the conditions were not all rated alike"
    verdict = differ if row["p"] <= ALPHA else "no difference among the conditions is shown"
    return (
        f"{where}Friedman over {row['conditions']} conditions, {counted(row['n'], 'participant')} who rated all: "
        f"chi2({row['df']}) = {row['chi2']:.1f}, {p_is(row['p'])}, Kendall's W = {row['w']:.2f}: {verdict}."
    )


def _sentences_of_order(effects: Mapping[str, Row], scale: ScaleInfo) -> list[str]:
    """Describe the effects of order. effects: as findings.order_effects."""
    reasons = {row.get("why_not", "") for row in effects.values()}
    if len(reasons) == 1 and "" not in reasons:
        return [f"Effects of order cannot be estimated: {reasons.pop()}."]
    names, said = {"place": "The place of a trial", "previous": "The condition shown before"}, []
    for name, row in effects.items():
        if "why_not" in row:
            said.append(f"{names[name]}: its effect cannot be estimated, {row['why_not']}.")
            continue
        text = f"{names[name]}: F({row['df']}, {row['df_rest']}) = {row['f']:.2f}, {p_is(row['p'])}"
        if "slope" in row:
            ends = f"{signed(row['low'], 3)} to {signed(row['high'], 3)}"
            text += f"; {signed(row['slope'], 3)} {scale.unit} per trial (95 % {ends})"
        text += f": {'it changed the ratings' if row['p'] <= ALPHA else 'no effect is shown'}"
        said.append(f"{text}; here it is confounded with {names[row['or']].lower()}." if "or" in row else f"{text}.")
    return said


def _sentence_of_claim(row: Row, title: str, scale: ScaleInfo) -> str:
    """Describe a published figure against the data."""
    source, latency_ms = f"{title} ({row['where']})" if row["where"] else title, row["latency_ms"]
    if "why_not" in row:
        figure = f"{latency_ms:g} ms" if row["difference"] is None else signed(row["difference"], 3)
        return f"{row['part']}: {source} says {figure}; {row['why_not']}."
    pair = pair_text(row["baseline"], row["condition"])
    at = f"{row['part']}, {pair if latency_ms is None else f'{latency_ms:g} ms'}"
    if row["difference"] is None:
        return f"{at}: {source} names it, and it was rated."
    figure = f"{row['difference']:+.3f}".rstrip("0").rstrip(".")
    says = f"{at}: {source} says {figure}, its data give {signed(row['data'], 3)}"
    if row["follows"]:
        return f"{says}: follows."
    near = listed(row["explained_by"], "or the")
    rest = f"; only the {near} is near it, which is another quantity" if row["explained_by"] else ""
    return f"{says}: does not follow{rest}."


def _sentence_of_reference(row: Row | None) -> str:
    """Say how people rated the hidden reference among their other ratings; ties are ties."""
    if row is None:
        return "Without a hidden reference the ratings do not show who judged with care."
    if not row["rated"]:
        return "The hidden reference was not rated."
    counts = {"better than": row["better"], "the same as": row["same"], "worse than": len(row["missed"])}
    (way, most), *others = ((way, count) for way, count in counts.items() if count)
    who = f"{most} of {row['rated']}" if others else {1: "The only participant", 2: "Both"}.get(most, f"All {most}")
    first = f"{who} who rated the hidden reference rated it {way}"
    text = f"{listed([first, *(f'{count} {way}' for way, count in others)])} the median of their other ratings."
    if row["flat"]:
        text += f" {row['flat']} of them gave everything the same rating, which shows nothing."
    if row["missed"]:
        text += f" Worse: {listed(row['missed'])}. Their ratings are kept; "
        text += "the comparisons without them are listed as well."
    return text


def _sentence_of_preference(row: Row) -> str:
    """Describe a comparison of pairs."""
    where = f"{row['part']}: " if row["part"] else ""
    given = row["for"] + row["against"] + row["neither"]
    votes = f"{where}'{row['condition']}' was preferred to '{row['baseline']}' in {row['for']} of {given} answers"
    votes += f", neither in {row['neither']}" if row["neither"] else ""
    if not given:
        votes = f"{where}'{row['condition']}' and '{row['baseline']}' were not shown together"
    size, tested = f"{signed(row['jod'])} JOD", ""
    if row["p"] is not None:
        of = f" after Holm over {row['holm_of']}" if row["holm_of"] > 1 else ""
        alike = "" if row["holm"] <= ALPHA else ", not significant at 5 %"
        tested = f" {counted(row['people'], 'person')} who saw both: exact {p_is(row['holm'])}{of}{alike}."
    if row["low"] is None:
        return f"{votes}; {size}, from fewer than {LEAST_PEOPLE} people, who give no interval.{tested}"
    size += f" (95 % {signed(row['low'])} to {signed(row['high'])})"
    share = f"{row['share']:.0%} of choices would go to it ({row['share_low']:.0%} to {row['share_high']:.0%})"
    shown = "" if row["low"] > 0 or row["high"] < 0 else ": no difference is shown"
    return f"{votes}; {size}: {share}{shown}.{tested}"


def said_of_preferences(parts: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Put its sentences into what findings.preference_results found of each part."""
    for found in parts:
        for row in found["comparisons"]:
            row["sentence"] = _sentence_of_preference(row)
        chosen = counted(found["answers"] - found["ties"], "choice")
        first = f"The first of a pair was chosen {found['first']} times in {chosen}."
        said = [*(row["sentence"] for row in found["comparisons"]), first]
        found["sentences"] = said if found["answers"] else ["No pair was compared."]
    return parts
