"""One bench: its rows and files; benches of several machines as one; what a suite takes besides."""

from __future__ import annotations

import functools
import itertools
import json
import math
import os
import platform
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any

import attrs

from ...base import PAPER, HmdwarpError, InputError, MachineError, import_extra, memory_bytes
from ...base.documents import json_in
from ...base.identity import hash_of_files, program_hash
from ...base.named_files import RESULTS
from ...client import needs_of
from ...client.capability import lacking
from ...client.classes import Client, load_client
from ...gpu import Gpu
from ...headsets import Headset
from ...metrics import (
    BOUND,
    PRIMARY,
    QUALITY,
    MeasuringThreads,
    QualityJob,
    QualityPool,
    at_instants,
    blocks_apart,
    blocks_text,
    db_of,
    pooled,
)
from ...pipeline import Source
from ...pipeline.recorded_source import RecordingSource
from ...pipeline.sizes import build_plan_for
from ...report import SCHEMA, OutputFolder, summary_faults, write_paper
from ...report.bench.crops import Crops, packed, unpacked
from ...report.bench.page import bench_page
from ...report.bench.rows import COLUMNS, Columns, cases, first_cases, row_name, table_of
from ...run import ReplayRun, measuring, set_up_replay
from ...run.options import refuse_one_name
from ...run.run_summary import machine_of, summary_of_rows
from ..sweep import MOST_SHOWN, ExperimentResult, Result, SweepCase, experiment, with_threads
from .cases import (
    BenchCase,
    baselines,
    cases_of,
    combinations_of,
    common_start_s,
    heads_of,
    notes_on_warps,
    options_of_case,
    prepared,
    run_options,
    source_of,
)
from .options import DEFAULT_SIZES, BenchOptions, MergeOptions
from .suite_means import suite_entry
from .suites import suites

_OUTSIDE_LACKS = "it is another library's, run on the CPU to compare with"
_ORACLE_LACKS = "it knows the depth of the truth, which no client has"
Row = Mapping[str, Any]
# What a notebook shows of each row.
_SHOWN = ("trace", "scene", "latency_ms", "strategy", "warp", "fill", "flip", "psnr_db", "ssim", "total_ms")
OF_NOTEBOOK = tuple(COLUMNS[name] for name in _SHOWN)
# The columns of bench.csv.
NAMES = [column.name for column in COLUMNS.values() if column.is_filed]


def row_of(
    setup: ReplayRun, case: measuring.Case, measured: measuring.Measured, pool: QualityPool, client: Client
) -> dict[str, Any]:
    """Return a row of bench.json: the keys of summary.json, and those of a bench alone."""
    combination = measured.combination
    # Nothing without an oracle.
    pixels, seen, error = (math.fsum(column) for column in zip((0, 0, 0.0), *measured.where_seen, strict=True))
    figures, regions = pool.results, pool.regions
    pictures = [{"frame": key[3], **figures[key]} for key in measured.keys]
    passes = combination.warp, combination.fill, combination.plan.lens.name
    base = summary_of_rows(setup, passes, [*measured.times, *pictures])
    lacks = _ORACLE_LACKS if combination.warp == measuring.ORACLE else _OUTSIDE_LACKS
    return {
        **base,
        "latency_ms": case.latency_ms,  # of the whole way, with a proxy too
        **({"strategy": combination.strategy} if combination.strategy else {}),
        "frames": len(pictures),
        "client": client.name,
        # Why the client cannot run it.
        "lacks": lacks if combination.warp in measuring.PLANLESS else lacking(combination.plan, client),
        # The system that the warp stands for.
        "baseline": baselines().get(combination.warp, ""),
        "at_instants": {
            name: {str(frame): value for frame, value in at_instants(pictures, name).items()} for name in QUALITY
        },
        "blocks": {str(frame): blocks_text(blocks) for frame, blocks in measured.blocks.items()},
        "regions": pooled(regions[key] for key in measured.keys),
        **({"where_seen": {"share": seen / pixels, "psnr_db": db_of(error / seen)}} if seen else {}),
    }


def flat(rows: Iterable[Row], columns: Columns) -> Iterator[dict[str, Any]]:
    """Yield the rows of a file under its columns."""
    filed = [column for column in columns.values() if column.is_filed]
    return ({column.name: column.value(row) for column in filed} for row in rows)


class Rows(list[dict[str, Any]]):
    """The rows of a bench by the columns of bench.csv: texts, numbers, None for what is unknown."""

    def __repr__(self) -> str:
        return f"<Rows: {len(self)} of a bench; to_pandas() returns the table>"

    def _repr_html_(self) -> str:
        """Return the first rows, a notebook shows them."""
        columns = [attrs.evolve(one, value=itemgetter(one.name), shown=None) for one in OF_NOTEBOOK]
        return table_of("", columns, self[:MOST_SHOWN]).html()

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame with one row for each."""
        frame = import_extra("pandas", "pandas", "study").DataFrame(list(self), columns=NAMES)
        kinds = {int: "Int64", float: "float64"}  # Int64 may lack a value, int64 may not
        return frame.astype({name: kinds[COLUMNS[name].kind] for name in NAMES if COLUMNS[name].is_number})


ROWS, CROPS = "rows", "crops.npz"
_MOST_METHODS = 5  # side by side
_MOST_CROPS = 3  # cases of a page that have crops: a megabyte each


@functools.cache
def examined() -> tuple[dict[str, Any], float]:
    """Return what bench.json says of this machine, and the bytes for the passes of a batch."""
    with Gpu() as gpu:
        clocks = gpu.timer.check
        about = {
            "machine": {**machine_of(gpu), "host": platform.node()},
            "clock": clocks.clock,
            "clocks": {"wall_ms": clocks.wall_ms, "gpu_ms": clocks.gpu_ms, "note": clocks.note},
        }
        most = measuring.MEMORY_PART * memory_bytes() if gpu.is_software else measuring.GPU_BATCH_BYTES
        return about, most


def _run_case(threads: MeasuringThreads, case: SweepCase, step: Callable[[float], None]) -> Result:
    """Time and measure all combinations of a case; return the machine and ROWS."""
    work: BenchCase = prepared(case.what)
    options, client, pool = work.options, load_client(work.options.client), QualityPool(threads)
    about, most = examined()
    chosen = work.batched(most)
    shares = (done / (work.instants * len(chosen)) for done in itertools.count(1))

    def steps() -> None:
        step(next(shares))

    rows: list[tuple[measuring.Combination, dict[str, Any]]] = []
    for batch in chosen:
        with set_up_replay(work.run_of(batch), needs_of(c.plan for c in batch)) as setup:
            comparison = measuring.Comparison(setup, work.case, batch, pool, options.rounds)
            comparison.run(options.instants, steps)
            pool.wait()
            rows += [(each.combination, row_of(setup, work.case, each, pool, client)) for each in comparison.measured]
    measured = [{**row, "machine": about["machine"]} for _, row in rows]
    crops = [] if options.suite else _crops(work, chosen, rows, QualityPool(threads))
    return Result({**about, ROWS: measured}, {CROPS: packed(crops)} if crops else {})


def _crops(
    work: BenchCase,
    chosen: Sequence[Sequence[measuring.Combination]],
    rows: Sequence[tuple[measuring.Combination, Row]],
    pool: QualityPool,
) -> list[Crops]:
    """Show the best of each of the first warps again: at the worst instant and a typical one."""
    (case,), made_by = cases(row for _, row in rows), {id(row): c for c, row in rows}
    ranked = [row for row in case.ordered() if row["quality"][PRIMARY]["mean"] is not None]
    warps = [*dict.fromkeys(row["warp"] for row in ranked)][:_MOST_METHODS]
    best = [next(row for row in ranked if row["warp"] == warp) for warp in warps]
    flips = sorted((flip, int(number)) for row in best[:1] for number, flip in row["at_instants"][PRIMARY].items())
    numbers = {"worst": flips[-1][1], "typical": flips[(len(flips) - 1) // 2][1]} if flips else {}
    for batch in chosen:
        wanted = {row_name(row): made_by[id(row)] for row in best if made_by[id(row)] in batch}
        if not wanted:
            continue
        with set_up_replay(work.run_of(batch), needs_of(c.plan for c in wanted.values())) as setup:
            beside = measuring.SideBySide(setup, [*wanted.values()])
            measured = measuring.instants_of(setup.schedule.count, work.options.instants)
            turns = {number: measured.index(number) for number in numbers.values()}
            for number, refresh in beside.refreshes(turns, turns):
                pictures = beside.pictures(refresh, turns[number] % len(refresh.inputs))
                for name, picture in zip(wanted, pictures, strict=True):
                    setup.hand_in(pool, (number, name), QualityJob(picture), keep=True)
            pool.wait()
    kept = {each.key: each for each in pool.kept}
    names = [row_name(row) for row in best]
    return [Crops.of(which, {name: kept[number, name] for name in names}) for which, number in numbers.items()]


# A recording shows no more than was taken, so its guard band is cut off what is shown.
_GUARD = 1.25


def further(options: BenchOptions, place: Path) -> tuple[BenchOptions, Source, dict[str, Any]]:
    """Return the options and source of what a suite takes besides, and what bench.json says of it.

    place: a scene file, or a folder of recorded frames, which has at most as many pixels as the
    suite. A figure above the noise floor of such a sequence is noise.
    """
    if not place.is_dir():
        options = attrs.evolve(options, also=(), scenes=(str(place),))
        source, floor_db = source_of(options, str(place)), None
    else:
        options = attrs.evolve(options, also=(), frames=place, recordings=("",), guard=_GUARD)
        source = source_of(options, "")
        assert isinstance(source, RecordingSource)
        (wide, high), (w, h) = source.headset.eye_size_px, options.sizes[0]
        scale, floor_db = min(1.0, math.sqrt(w * h / (wide * high))), source.sequence.noise_floor_db
        size = (round(wide * scale), round(high * scale))
        options = attrs.evolve(options, scenes=(source.scene.name,), sizes=(size,))
    return options, source, {"name": source.scene.name, "sha256": hash_of_files(place), "noise_floor_db": floor_db}


FILES = ("bench.csv", "bench.html", *PAPER, "bench.json")
Progress = Callable[[int, int], None]


def bench(
    options: BenchOptions, progress: Progress = lambda done, total: None, say: Callable[[str], None] = lambda text: None
) -> ExperimentResult:
    """Run a bench and write bench.csv, bench.json and bench.html into options.out.

    Parameters
    ----------
    options
        All of them are checked before anything runs.
    progress
        Called with (done, total) after each measured refresh.
    say
        Called with a sentence for the user.

    Returns
    -------
    ExperimentResult
        The content of bench.json, and the cases that failed.

    Raises
    ------
    InputError
        For wrong options; the error of the case where none of several was done.
    MachineError
        For what the machine lacks.
    """
    options = BenchOptions.checked(options)
    source = source_of(options, options.scenes[0])
    headset = source.headset
    client = load_client(options.client)
    if isinstance(source, RecordingSource):
        sizes = options.sizes if options.sizes != DEFAULT_SIZES else (headset.eye_size_px,)
        options = attrs.evolve(options, scenes=(source.scene.name,), recordings=("",), sizes=sizes)
    works, notes = _checked(options, headset, source)
    also = [further(options, place) for place in options.also]
    for part, its_source, _ in also:
        added, told = _checked(part, its_source.headset, its_source)
        works, notes = works + added, notes + told
    if options.suite:
        pictures = sum(case.instants * len(case.combinations) for case in works)
        say(f"suite {options.suite} {suites()[options.suite].version}: {len(works)} cases, {pictures} pictures")
    work = partial(with_threads, _run_case, options.sweep.measuring(options.workers))
    with experiment(options, FILES, work, list(map(_case, works)), progress, say) as (out, swept, described):
        rows = swept.rows(lambda result: result.get(ROWS, ()))
        if unfit := [row_name(row) for row in rows if row["warp"] != measuring.ORACLE and row["lacks"]]:
            names = ", ".join(dict.fromkeys(unfit))
            about = f"client '{client.name}' ({client.summary}) cannot run {names}"
            notes.append(f"Not in the front: {about}. --client names another.")
        first = next(result for _, result in swept.results())
        data = described(
            {
                "program": program_hash(),
                **{key: first[key] for key in _MACHINE},
                "client": client.name,
                "notes": [
                    *notes,
                    *(f"{failure.name}: failed: {failure.why}" for failure in swept.failed),
                ],
                "rows": rows,
                **suite_entry(options.suite, rows, [about for _, _, about in also]),
            }
        )
        files = (swept.kept.file(case.identity, CROPS) for case in itertools.islice(swept.done, _MOST_CROPS))
        write_bench(out, data, options, [unpacked(path.read_bytes()) if path.exists() else [] for path in files])
    return ExperimentResult(options.out, data, options.out / "bench.html", swept, OF_NOTEBOOK)


def _case(work: BenchCase) -> SweepCase:
    case = work.case
    rate = () if case.server_rate_hz is None else (f"server {case.server_rate_hz:g} Hz",)
    named = (case.recording, f"{case.latency_ms:g} ms", case.scene, "x".join(map(str, case.size)), *rate)
    return SweepCase.of("bench", ", ".join(filter(None, named)), work.options, steps=work.instants)


def _checked(options: BenchOptions, headset: Headset, source: Source) -> tuple[list[BenchCase], list[str]]:
    """Check everything that needs no GPU; return the cases, and notes on the scenes."""
    rate_hz = options.rate_hz or headset.refresh_hz
    combinations_of(options, None)  # names, before any scene is built
    called, notes = {}, [*notes_on_warps(options), *headset.notes]
    for name in options.scenes:
        scene = source.scene if source.kind.has_head else source_of(options, name).scene
        build_plan_for(
            run_options(options, measuring.Case(name, options.recordings[0], 0.0, options.sizes[0]), lens=options.lens),
            headset,
            scene,
        )
        combinations_of(options, scene)
        called[name] = scene.name
        notes += scene.notes
    refuse_one_name("scenes", called)
    heads = heads_of(options, source)
    starts = {recording: common_start_s(options, head.track, rate_hz) for recording, head in heads.items()}
    works = [prepared(options_of_case(options, case, starts[case.recording])) for case in cases_of(options)]
    if isinstance(source, RecordingSource):
        notes.append(RecordingSource(source.sequence, works[0].run.guard_factors).about)
    return works, notes


def write_bench(
    out: OutputFolder, data: dict[str, Any], options: BenchOptions | MergeOptions, crops: Sequence[Sequence[Crops]] = ()
) -> None:
    """Write table, page and bench.json, whose content is `data`; crops: of the first cases."""
    out.write_csv("bench.csv", flat(data["rows"], COLUMNS), NAMES)
    rows, count = first_cases(data["rows"], MOST_SHOWN)
    data["winners"] = [case.verdict() for case in cases(rows.values())]
    notes = [f"This page shows the first {MOST_SHOWN} of {count} cases; bench.csv and bench.json have all."]
    notes = [*(notes if count > MOST_SHOWN else []), *data["notes"]]
    out.write_text("bench.html", bench_page({**data, "rows": [*rows.values()], "notes": notes}, crops).html())
    if isinstance(options, BenchOptions) and options.paper.is_wanted:
        write_paper(out, bench_page(data, crops), options.paper)
    out.write_json("bench.json", data)


# What tells combinations and their conditions apart.
_KEY = (
    *("trace", "scene", "latency_ms", "size", "headset", "lens", "guard", "predict", "rate_hz", "server_rate_hz"),
    *("strategy", "warp", "fill"),
)
# Of the picture, not of the machine that made it.
_QUALITY = ("quality", "measured", "at_instants", "regions", "blocks", "frames", "jod", "where_seen")
_MACHINE = ("machine", "clock", "clocks")


def merge(options: MergeOptions) -> ExperimentResult:
    """Join benches and write them as one.

    Rows of one combination in one case are one picture: their quality is that of the first bench
    that has it, and each machine has a row with its own times. Of several rows of one machine the
    first counts.

    Parameters
    ----------
    options
        The folders, and where to write.

    Returns
    -------
    ExperimentResult
        The content of the bench.json of all.

    Raises
    ------
    InputError
        For a folder without a bench, and for benches of different programs or instants.
    MachineError
        Where two machines showed different pictures.
    """
    try:
        benches = [_read(folder) for folder in options.folders]
        folders = options.folders
        for folder, bench in zip(folders, benches, strict=True):
            if bench["program"] != benches[0]["program"]:
                raise InputError(
                    f"{folder} and {folders[0]} were made by different programs (hmdwarp {bench['hmdwarp']} and "
                    f"{benches[0]['hmdwarp']}), so their pictures may differ: run one of them again"
                )
        # Machines of one host that draw with different GPUs are named by their GPUs too.
        of_all = [each["machine"] for bench in benches for each in (bench, *bench["rows"])]
        gpus: dict[str, set[str]] = {}
        for machine in of_all:
            gpus.setdefault(machine["host"], set()).add(machine["gl_renderer"])
        for machine in of_all:
            if len(gpus[machine["host"]]) > 1:
                machine["host"] += f" ({machine['gl_renderer']})"
        rows = _joined([row for bench in benches for row in bench["rows"]])
        machines = {bench["machine"]["host"]: {key: bench[key] for key in _MACHINE} for bench in reversed(benches)}
        notes = list(dict.fromkeys(note for bench in benches for note in bench["notes"]))
        for host, each in machines.items() if len(machines) > 1 else ():
            timed = f"{each['machine']['cpu_count']} cores, timed by the {each['clock']} clock."
            notes.append(f"{host}: {each['machine']['gl_renderer']}, {timed}")
        data = {
            **benches[0],
            "command": options.command,
            "notes": notes,
            "rows": rows,
            "seconds": sum(bench["seconds"] for bench in benches),
        }
        with OutputFolder(options.out, owned=FILES[:-1], last=FILES[-1], force=options.force) as out:
            write_bench(out, data, options)
        return ExperimentResult(options.out, data, options.out / "bench.html", columns=OF_NOTEBOOK)
    except HmdwarpError:
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        # Of all that a row may hold, `summary_faults` checks what summaries have.
        said = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        found = " and ".join(map(str, options.folders))
        raise InputError(f"{found}: what one of them says is damaged ({said}): run that bench again") from error


def read(folder: str | os.PathLike[str]) -> Rows:
    """Return the rows of a bench in a folder, one for each combination in each case.

    Parameters
    ----------
    folder
        What `hmdwarp bench` wrote.

    Returns
    -------
    Rows
        Under the columns of bench.csv (docs/scale.md).

    Raises
    ------
    InputError
        For a folder without a bench, or with a damaged one.
    """
    rows = flat(_read(Path(folder))["rows"], COLUMNS)
    return Rows(
        {name: None if value is None else COLUMNS[name].kind(value) for name, value in row.items()} for row in rows
    )


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
    """Return how two rows' pictures differ, "" if they do not. Errors: InputError."""
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
