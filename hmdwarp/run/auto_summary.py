"""What a run that chooses its warp by itself tells of its choices: the `auto` entry of summary.json, and a note."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from ..auto.adaptive import AdaptiveCompensator

_MOST_TOLD = 8  # changes in the note; all of them are in the entry and on the page


def auto_entry(auto: AdaptiveCompensator, rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """{budget_ms, ladder, changes}; rows: two for each refresh, keyed as frames.csv.

    ladder: from cheapest to most accurate, what each rung was expected to take and to err, and how many refreshes it made.
    changes: time_s and frame of the last picture made by `from`, and the reason.
    """
    ran = Counter((row["warp"], row["fill"]) for row in rows if row["eye"] == 0)
    ladder = [
        {
            "name": str(level),
            "warp": level.warp,
            "fill": level.fill,
            "total_ms": level.total_ms,
            "flip": level.error,
            "psnr_db": level.psnr_db,
            "refreshes": ran[level.warp, level.fill],
        }
        for level in auto.ladder
    ]
    changes = [
        {
            "time_s": rows[2 * change.refresh]["time_s"],
            "frame": change.refresh,
            "from": str(change.before),
            "to": str(change.after),
            "reason": change.reason,
        }
        for change in auto.changes
    ]
    return {"budget_ms": auto.budget_ms, "ladder": ladder, "changes": changes}


def auto_note(entry: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> str:
    """The entry in a sentence or two."""
    started = rows[0]["warp"] if rows[0]["fill"] == "none" else f"{rows[0]['warp']} + {rows[0]['fill']}"
    expected = next(level["total_ms"] for level in entry["ladder"] if level["name"] == started)
    told = f"Warp 'auto' began with {started}, expected to take {expected:.2f} of the {entry['budget_ms']:g} ms for one eye"
    changes = entry["changes"]
    if not changes:
        return f"{told}, and kept it."
    steps = [f"at {change['time_s']:.2f} s to {change['to']}" for change in changes[:_MOST_TOLD]]
    more = f", and {len(changes) - _MOST_TOLD} more" if len(changes) > _MOST_TOLD else ""
    count = "once" if len(changes) == 1 else f"{len(changes)} times"
    return f"{told}. It changed {count}: {', '.join(steps)}{more}; the reasons are in the report."
