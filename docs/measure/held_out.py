"""Whether parameters that were fitted hold elsewhere; docs/bench.md says what came of it.

Each is varied on both halves of hmdwarp's suites (`halves` in suites.toml): where the best value on
the half to fit on is not the one in use, it says what either gives on the half that was held out.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from hmdwarp.client.fills import pyramid
from hmdwarp.experiments.bench import BenchOptions, bench
from hmdwarp.experiments.bench.suites import FIT, HELD_OUT, halves
from hmdwarp.poses import analyse, load_trace
from hmdwarp.poses.predictors import cautious

LATE_MS = 200
WARP, FILL = "iterative", "pyramid"


@attrs.frozen
class Parameter:
    """What is varied: a setting of the warp or the fill, or a number of a module."""

    name: str
    # The one in use first.
    values: tuple[float, ...]
    where: Any = None

    def methods(self, value: float) -> dict[str, list[str]]:
        of_warp = self.where == WARP
        return {
            "warp": [f"{WARP}:{self.name}={value:g}" if of_warp else WARP],
            "fill": [f"{FILL}:{self.name}={value:g}" if self.where == FILL else FILL],
        }

    @contextmanager
    def set_to(self, value: float) -> Iterator[None]:
        if isinstance(self.where, str):
            yield
            return
        before = getattr(self.where, self.name)
        assert before == self.values[0]
        setattr(self.where, self.name, value)
        try:
            yield
        finally:
            setattr(self.where, self.name, before)


PARAMETERS = (
    Parameter("tolerance", (0.03, 0.015, 0.06), WARP),
    Parameter("floor", (0.02, 0.01, 0.04), WARP),
    Parameter("holes", (0.4, 0.2, 0.8, 2.0), FILL),
    Parameter("tolerance", (0.2, 0.1, 0.4), FILL),
    Parameter("floor", (0.02, 0.01, 0.04), FILL),
    Parameter("LEAST_BORDER", (0.23, 0.1, 0.4), pyramid),
    Parameter("LEAST_LOCAL", (2.0**-10, 2.0**-14, 2.0**-6), pyramid),
    Parameter("LEAST_BEYOND", (0.35, 0.2, 0.8), pyramid),
)
WEIGHTS = (
    Parameter("WEIGHT_MISSED", (0.25, 0.125, 0.5), cautious),
    Parameter("WEIGHT_TOO_FAR", (4.0, 2.0, 8.0), cautious),
)


def flip_of(parameter: Parameter, value: float, half: Mapping[str, Sequence[str]], most: int) -> float:
    """Return the mean FLIP over the first scenes and heads of a half."""
    with tempfile.TemporaryDirectory() as out, parameter.set_to(value):
        usual = {"latency": [str(LATE_MS)], "size": ["160x100"], "samples": 4, "instants": 2, "rounds": 1}
        where = {"scene": [",".join(half["scenes"][:most])], "traces": list(half["heads"][:most])}
        said = {**usual, **where, **parameter.methods(value), "out": Path(out) / "out"}
        rows = bench(BenchOptions.of(said)).data["rows"]
        return float(np.mean([row["quality"]["flip"]["mean"] for row in rows]))


def degrees_of(parameter: Parameter, value: float, half: Mapping[str, Sequence[str]], most: int) -> float:
    """Return the default predictor's 95th percentile of errors, averaged over a half's heads."""
    with parameter.set_to(value):
        tracks = [load_trace(name).track for name in half["heads"]]
        found = [analyse(track, (LATE_MS,))["errors_deg"][0]["cautious"]["p95"] for track in tracks]
        return float(np.mean(found))


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("only", nargs="*", help="iterative, pyramid, cautious or parameters; by default all")
    arguments.add_argument("--most", type=int, default=2, help="scenes, and heads, of each half")
    said = arguments.parse_args()
    print("| parameter | value | fitted on | held out |\n| --- | ---: | ---: | ---: |")
    for figure, parameters, measure in (("FLIP", PARAMETERS, flip_of), ("degrees", WEIGHTS, degrees_of)):
        for parameter in parameters:
            where = parameter.where if isinstance(parameter.where, str) else parameter.where.__name__.rpartition(".")[2]
            if said.only and not {where, parameter.name} & {*said.only}:
                continue
            found = {
                value: [measure(parameter, value, halves()[half], said.most) for half in (FIT, HELD_OUT)]
                for value in parameter.values
            }
            best = min(parameter.values, key=lambda value: found[value][0])
            for value, (fit, held) in found.items():
                told = (
                    f"{value:g}{', in use' if value == parameter.values[0] else ''}{', best' if value == best else ''}"
                )
                print(f"| `{where}` {parameter.name} | {told} | {fit:.4f} | {held:.4f} {figure} |", flush=True)


if __name__ == "__main__":
    main()
