"""The answer to `--budget`, in sentences to act on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...report.bench import choice_terms


def answer(choice: Mapping[str, Any]) -> list[str]:
    """Return the best combination within the budget, then the gain and cost of the next step up.

    choice: as in bench.json.
    """
    name, step, where = _name(choice), choice["next"], f" ({choice_terms(choice)})"
    best = f"Within {choice['budget_ms']:g} ms per eye the most accurate is {name}"
    first = f"{best}: {_accuracy(choice)}, {choice['total_ms']:.2f} ms{where}."
    use = f"Use it by --warp {choice['warp']} --fill {choice['fill']}."
    if step is None:
        return [first, use, "Nothing that was measured is more accurate, however long it takes."]
    extra_ms = step["total_ms"] - choice["total_ms"]
    following = f"The next step up is {_name(step)}: {_accuracy(step)}, {step['total_ms']:.2f} ms"
    return [first, use, f"{following}; {_gain(choice, step)} for {extra_ms:.2f} ms more."]


def _name(entry: Mapping[str, Any]) -> str:
    return f"warp {entry['warp']} {'without a fill' if entry['fill'] == 'none' else 'with fill ' + entry['fill']}"


def _accuracy(entry: Mapping[str, Any]) -> str:
    psnr = "" if entry["psnr_db"] is None else f" and PSNR {entry['psnr_db']:.2f} dB"
    return f"mean FLIP {entry['flip']:.4f}{psnr}"


def _gain(choice: Mapping[str, Any], step: Mapping[str, Any]) -> str:
    parts = [f"{1 - step['flip'] / choice['flip']:.0%} less FLIP error"] if choice["flip"] else []
    if None not in (choice["psnr_db"], step["psnr_db"]):
        change = step["psnr_db"] - choice["psnr_db"]
        parts.append(f"{abs(change):.2f} dB {'more' if change >= 0 else 'less'} PSNR")
    return " and ".join(parts)
