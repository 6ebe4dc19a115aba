"""What a bench says in sentences: of its client, and in answer to `--budget`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...client.classes import Client
from ...metrics import PRIMARY, metrics
from ...report.bench import cases, choice_terms

Row = Mapping[str, Any]


def left_out_notes(rows: Sequence[Row], client: Client) -> list[str]:
    """Return which methods the front and the choice leave out, and what they would gain.

    rows: of bench.json. Empty if the client can run all of them.
    """
    lacking = [row for row in rows if row["lacks"]]
    if not lacking:
        return []

    def figures(row: Row) -> str:
        total = row["time_ms"]["total"]["median"]
        return f"{metrics.get(PRIMARY).short_figure.label} {row['quality'][PRIMARY]['mean']:.3f} in {total:.2f} ms"

    names = ", ".join(dict.fromkeys(map(_pair, lacking)))
    notes = [f"Not in the front: client '{client.name}' ({client.summary}) cannot run {names}. --client names another."]
    for case in cases(rows):
        ordered = [row for row in case.ordered() if row["quality"][PRIMARY]["mean"] is not None]
        best = next((row for row in ordered if not row["lacks"]), None)
        if best is not None and ordered[0]["lacks"]:
            gain = f"{case.label}: a client that can run {_pair(ordered[0])} would have {figures(ordered[0])}"
            notes.append(f"{gain}, where {_pair(best)} has {figures(best)}; {ordered[0]['lacks']}.")
    return notes


def _pair(row: Row) -> str:
    return str(row["warp"]) if row["fill"] == "none" else f"{row['warp']} + {row['fill']}"


def answer(choice: Mapping[str, Any]) -> list[str]:
    """Return the best combination within the budget, then the gain and cost of the next step up.

    choice: as in bench.json.
    """
    step, where = choice["next"], f" ({choice_terms(choice)})"
    best = f"Within {choice['budget_ms']:g} ms per eye the most accurate is {_described(choice)}{where}."
    use = f"Use it by --warp {choice['warp']} --fill {choice['fill']}."
    if step is None:
        return [best, use, "Nothing that was measured is more accurate, however long it takes."]
    gains = [f"{1 - step['flip'] / choice['flip']:.0%} less FLIP error"] if choice["flip"] else []
    if None not in (choice["psnr_db"], step["psnr_db"]):
        change = step["psnr_db"] - choice["psnr_db"]
        gains.append(f"{abs(change):.2f} dB {'more' if change >= 0 else 'less'} PSNR")
    following = f"The next step up is {_described(step)}; {' and '.join(gains)}"
    return [best, use, f"{following} for {step['total_ms'] - choice['total_ms']:.2f} ms more."]


def _described(entry: Mapping[str, Any]) -> str:
    fill = "without a fill" if entry["fill"] == "none" else f"with fill {entry['fill']}"
    psnr = "" if entry["psnr_db"] is None else f" and PSNR {entry['psnr_db']:.2f} dB"
    return f"warp {entry['warp']} {fill}: mean FLIP {entry['flip']:.4f}{psnr}, {entry['total_ms']:.2f} ms"
