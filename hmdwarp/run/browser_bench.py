"""What a page's `?bench` measured, as a bench.json that `hmdwarp bench merge` reads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from ..client.classes import PICTURE_CLIENT
from ..client.variants import every_baseline
from ..metrics import BLOCKS, aggregate, at_instants, blocks_text, db_of, metrics_in_order, pooled
from ..options.identity import program_hash
from ..report import SCHEMA, OutputFolder
from ..report.bench.page import render_bench_page
from ..resources import __version__
from .browser_display import CHAINS, FILL, BadLog, BrowserDisplay, facts_of, number, words

MOST_TEXT = 1 << 16  # characters of the message
FILLS = ("none", FILL)
_CLOCKS = ("gpu", "wall")
_MOST_INSTANTS, _MOST_TIMES = 16, 256  # of a row
_STEPS = 256  # of a level that the means of parts of a picture come in
_OF_ROW = {"chain", "fill", "warp_ms", "total_ms", "square", "means"}


def _numbers(values: object, most: float, count: int | None = None, longest: int = _MOST_TIMES) -> list[float]:
    """Return a list of numbers from 0. Errors: BadLog."""
    if not isinstance(values, list) or not 1 <= len(values) <= (count or longest):
        raise BadLog("a bench without figures, or with too many")
    good = all(
        isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= most for value in values
    )
    if not good or (count is not None and len(values) != count):
        raise BadLog("a bench's figure out of range, or too few of them")
    return [float(value) for value in values]


def _instants(values: object) -> list[float]:
    return _numbers(values, 1e9, longest=_MOST_INSTANTS)


@attrs.frozen
class BrowserBench:
    """The times of every chain on one display. Errors: BadLog for anything out of range."""

    display: BrowserDisplay
    clock: str = attrs.field()  # "gpu" or "wall"
    instants_ms: list[float] = attrs.field(converter=_instants)
    rows: list[dict[str, Any]] = attrs.field()
    # How times were taken.
    how: str = words(100)
    seconds: float = number(0, 1e5)

    @clock.validator
    def _check_clock(self, _: object, value: object) -> None:
        if value not in _CLOCKS:
            raise BadLog(f"clock: expected one of {', '.join(_CLOCKS)}")

    @rows.validator
    def _check_rows(self, _: object, value: object) -> None:
        if not (isinstance(value, list) and 1 <= len(value) <= len(CHAINS) * len(FILLS)):
            raise BadLog("rows: expected one for each chain")
        for row in value:
            if (
                not isinstance(row, dict)
                or set(row) != _OF_ROW
                or row["chain"] not in [*CHAINS]
                or row["fill"] not in FILLS
            ):
                raise BadLog("a row of no chain")
            self._check_figures(row)

    def _check_figures(self, row: Mapping[str, Any]) -> None:
        count = len(self.instants_ms)
        if len(_numbers(row["warp_ms"], 1e6)) != len(_numbers(row["total_ms"], 1e6)) or len(row["warp_ms"]) % count:
            raise BadLog("times of warps and of all, in other numbers")
        _numbers(row["square"], 255.0**2, count)
        if not isinstance(row["means"], list) or len(row["means"]) != count:
            raise BadLog("means: expected a list for each instant")
        parts = min(BLOCKS, self.display.width) * min(BLOCKS, self.display.height) * 3
        for means in row["means"]:
            _numbers(means, 255.0 * _STEPS, parts)

    @classmethod
    def of(cls, said: object) -> BrowserBench:
        """Read what a page said. Errors: BadLog."""
        own = {field.name for field in attrs.fields(cls)} - {"display"}
        if not isinstance(said, dict) or not own <= set(said):
            raise BadLog(f"a bench: expected the keys {', '.join(sorted(own))}")
        display = BrowserDisplay.of({key: value for key, value in said.items() if key not in own})
        return cls(display, **{key: said[key] for key in own})


def write_bench(bench: BrowserBench, out: OutputFolder, scene: str, command: str) -> None:
    """Write bench.json and bench.html. Errors: as OutputFolder."""
    rows = [_row(bench, row, scene) for row in bench.rows]
    copying = [row for row in bench.rows if row["fill"] == FILLS[0]] or bench.rows
    pass_ms = float(np.median([t - w for row in copying for t, w in zip(row["total_ms"], row["warp_ms"], strict=True)]))
    note = (
        f"{bench.how}, in {bench.display.browser}; the fill's time has the pass in it that writes the picture, and "
        "copying is that pass alone"
    )
    data = {
        "schema": SCHEMA,
        "hmdwarp": __version__,
        "command": command,
        "program": program_hash(),
        "machine": rows[0]["machine"],
        "clock": bench.clock,
        "clocks": {"wall_ms": None, "gpu_ms": None, f"{bench.clock}_ms": pass_ms, "note": note},
        "client": PICTURE_CLIENT,
        "notes": ["Measured in a browser by its page: of one eye, frames without a codec, PSNR to the server's truth."],
        "rows": rows,
        "choice": None,
        "seconds": bench.seconds,
    }
    out.write_text("bench.html", render_bench_page(data))
    out.write_json("bench.json", data)


def _row(bench: BrowserBench, row: Mapping[str, Any], scene: str) -> dict[str, Any]:
    """Return a row of bench.json, as experiments/bench has them."""
    facts, count = facts_of(bench.display, scene).shared, len(bench.instants_ms)
    frames = [round(ms * bench.display.rate_hz * 1e-3) for ms in bench.instants_ms]
    pictures = [{"frame": at, "psnr_db": db_of(off / 255**2)} for at, off in zip(frames, row["square"], strict=True)]
    times = [
        {"warp_ms": warp, "fill_ms": max(total - warp, 0.0), "total_ms": total}
        for warp, total in zip(row["warp_ms"], row["total_ms"], strict=True)
    ]
    warp = CHAINS[row["chain"]]
    blocks = {str(at): blocks_text(np.array(means) / _STEPS) for at, means in zip(frames, row["means"], strict=True)}
    return {
        **facts.summary((warp, row["fill"], "none"), count, aggregate([*pictures, *times])),
        **{"predict": "none", "server_rate_hz": None, "clock": bench.clock},
        "machine": {**facts.machine, "host": f"{bench.display.renderer}, {bench.display.browser}"},
        "client": PICTURE_CLIENT,
        "lacks": "",
        "baseline": every_baseline().get(CHAINS[row["chain"]], ""),
        "at_instants": {
            metric.name: {str(at): value for at, value in at_instants(pictures, metric.name).items()}
            for metric in metrics_in_order()
        },
        "blocks": blocks,
        "regions": pooled([]),
        "mismatch": None,
        "notes": [f"Timed by: {bench.how}."],
    }
