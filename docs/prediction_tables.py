"""How far each predictor misses the heads of the recordings, and how far it leads them."""

from __future__ import annotations

import json
import subprocess
import sys

PREDICTORS = ("none", "constant_velocity", "cautious")
RECORDINGS = ("look-around", "walk", "reversals", "fast-turns")
LATENCIES_MS = (50, 100, 200, 400, 800)


def errors_table() -> str:
    """Return what `hmdwarp trace info` says of each predictor: a row for each latency."""
    heads = ["recording", "latency ms", "`none`"]
    for name in PREDICTORS[1:]:
        heads += [f"`{name}`", "leads"]
    lines = ["| " + " | ".join(heads) + " |", "| --- |" + " ---: |" * (len(heads) - 1)]
    for recording in RECORDINGS:
        command = [sys.executable, "-m", "hmdwarp", "trace", "info", recording, "--json"]
        found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        for row in found["errors_deg"]:
            if row["latency_ms"] in LATENCIES_MS:
                cells = [recording, str(row["latency_ms"]), _error(row["none"])]
                for name in PREDICTORS[1:]:
                    cells += [_error(row[name]), f"{100 * row[name]['lead_share']:.1f} %, {row[name]['lead_p95']:.2f}"]
                lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _error(figures: dict[str, float]) -> str:
    return f"{figures['p50']:.2f} / {figures['p95']:.2f}"
