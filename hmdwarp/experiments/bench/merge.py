"""Benches of several machines or parts as one: quality once, times for each machine."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...errors import HmdwarpError, InputError, MachineError
from ...metrics import BOUND, blocks_apart
from ...options.documents import json_in
from ...options.named_files import RESULTS
from ...report import SCHEMA, OutputFolder, summary_faults
from ..sweep import ExperimentResult
from .bench_rows import check_parquet
from .bench_run import FILES, SECTIONS, write_bench
from .options import MergeOptions

# What tells combinations and their conditions apart.
_KEY = (
    *("trace", "scene", "latency_ms", "size", "headset", "lens", "guard", "predict", "rate_hz", "server_rate_hz"),
    *("strategy", "warp", "fill"),
)
# Of the picture, not of the machine that made it.
_QUALITY = ("quality", "measured", "at_instants", "regions", "mismatch", "blocks", "frames", "jod")
_MACHINE = ("machine", "clock", "clocks", "copy_gb_s")
Row = dict[str, Any]


def merge(options: MergeOptions) -> ExperimentResult:
    """Join benches and write them as one.

    Rows of one combination in one case are one picture: their quality is that of the first bench
    that has it, and each machine has a row with its own times. Of several rows of one machine the
    first counts. The displacement grid and fused warps are those of the first bench that has them.
    Errors: InputError for a folder without a bench, and for benches of different programs or
    instants; MachineError where two machines showed different pictures.
    """
    if options.parquet:
        check_parquet()
    try:
        return _merged(options, [_read(folder) for folder in options.folders])
    except HmdwarpError:
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        # Of all that a row may hold, `summary_faults` checks what summaries have.
        said = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        found = " and ".join(map(str, options.folders))
        raise InputError(f"{found}: what one of them says is damaged ({said}): run that bench again") from error


def _merged(options: MergeOptions, benches: Sequence[dict[str, Any]]) -> ExperimentResult:
    _check_programs(options.folders, benches)
    _tell_apart(benches)
    rows = _joined([row for bench in benches for row in bench["rows"]])
    machines = {bench["machine"]["host"]: {key: bench[key] for key in _MACHINE} for bench in reversed(benches)}
    data = {
        **benches[0],
        "command": options.command,
        "notes": [*dict.fromkeys(note for bench in benches for note in bench["notes"]), *_about(machines)],
        "rows": rows,
        **{name: next((b[name] for b in benches if b.get(name)), missing) for name, missing in SECTIONS.items()},
        "choice": None,
        "seconds": sum(bench["seconds"] for bench in benches),
    }
    with OutputFolder(options.out, owned=FILES[:-1], last=FILES[-1], force=options.force) as out:
        write_bench(out, data, parquet=options.parquet)
    return ExperimentResult(options.out, data, options.out / "bench.html")


def _read(folder: Path) -> dict[str, Any]:
    path = folder / "bench.json"
    wanted = attrs.evolve(RESULTS, what="a folder that 'hmdwarp bench' wrote, with its bench.json")
    data: dict[str, Any] = json_in(path, wanted)
    rows = data.get("rows") if isinstance(data, dict) else None
    if not rows or data.get("schema") != SCHEMA or any(summary_faults(row) for row in rows):
        raise InputError(f"{path}: not what 'hmdwarp bench' writes, or damaged: run that bench again")
    if any("blocks" not in row or "host" not in row["machine"] for row in rows) or "program" not in data:
        raise InputError(f"{path}: of an older hmdwarp, which did not say what merge compares: run that bench again")
    return data


def _check_programs(folders: Sequence[Path], benches: Sequence[Mapping[str, Any]]) -> None:
    for folder, bench in zip(folders, benches, strict=True):
        if bench["program"] != benches[0]["program"]:
            raise InputError(
                f"{folder} and {folders[0]} were made by different programs (hmdwarp {bench['hmdwarp']} and "
                f"{benches[0]['hmdwarp']}), so their pictures may differ: run one of them again"
            )


def _tell_apart(benches: Sequence[Mapping[str, Any]]) -> None:
    """Name machines of one host that draw with different GPUs by their GPUs too."""
    machines = [each["machine"] for bench in benches for each in (bench, *bench["rows"])]
    gpus: dict[str, set[str]] = {}
    for machine in machines:
        gpus.setdefault(machine["host"], set()).add(machine["gl_renderer"])
    for machine in machines:
        if len(gpus[machine["host"]]) > 1:
            machine["host"] += f" ({machine['gl_renderer']})"


def _joined(rows: Sequence[Row]) -> list[Row]:
    """Return one row for each combination and machine; all with the quality of the first."""
    first: dict[str, Row] = {}
    joined: dict[tuple[str, str], Row] = {}
    apart: list[str] = []
    for row in rows:
        key = json.dumps([row.get(name) for name in _KEY])
        known = first.setdefault(key, row)
        if known is not row and (why := _differs(known, row)):
            apart.append(why)
        quality = {name: known[name] for name in _QUALITY if name in known}
        joined.setdefault((key, row["machine"]["host"]), {**row, **quality})
    if apart:
        more = f" and {len(apart) - 1} more" if len(apart) > 1 else ""
        raise MachineError(
            f"two machines showed different pictures, so a driver is at fault: {apart[0]}{more}; at most {BOUND:g} "
            "levels come from rounding, filters and edges"
        )
    return list(joined.values())


def _differs(one: Row, other: Row) -> str:
    """Return how two rows' pictures differ, "" if they do not.

    Errors: InputError where they are of other instants.
    """
    name = f"{one['trace']}, {one['latency_ms']:g} ms, {one.get('strategy') or one['warp']} + {one['fill']}"
    if one["blocks"].keys() != other["blocks"].keys():
        raise InputError(f"{name}: measured at other instants: run both benches with the same --instants")
    try:
        levels = max(blocks_apart(one["blocks"][at], other["blocks"][at]) for at in one["blocks"])
    except ValueError as error:
        raise InputError(f"{name}: what it says of its pictures is damaged: run that bench again") from error
    if levels <= BOUND:
        return ""
    where = " and ".join(f"{row['machine']['host']} ({row['machine']['gl_renderer']})" for row in (one, other))
    return f"{name}: a part of the picture is {levels:.1f} levels of 255 apart on {where}"


def _about(machines: Mapping[str, Mapping[str, Any]]) -> list[str]:
    if len(machines) == 1:
        return []
    return [
        f"{host}: {about['machine']['gl_renderer']}, {about['machine']['cpu_count']} cores, timed by the "
        f"{about['clock']} clock, copies {about['copy_gb_s']:.1f} GB/s."
        for host, about in machines.items()
    ]
