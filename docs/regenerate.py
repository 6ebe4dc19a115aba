"""Run what the figures in README.md and docs/ come from, and write them there: `make docs`.

`make docs OPTIONS=fills` renews one table (or picture), `OPTIONS="fills link"` two, `OPTIONS=help`
lists their names; without OPTIONS all that need nothing but this machine. Edit nothing between the
markers by hand. A name may have files of earlier runs to use instead of a new one:
`bench:FILE,FILE` takes bench.json at 200 ms and at later ones, `strategies:FILE` compare.json,
`thesis:FILE,..` results.json, `gpu:FILE,..` gpu.json of `make bench-gpu`, `fill-fronts:FOLDER,..`
recorded frames.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import json
import math
import os
import re
import shlex
import subprocess
import sys
import tempfile
import textwrap
import time
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import gpu_tables
import real_frames
from pages import DOCS, ROOT, lines_of, markdown, replace, rows_of, text_of

RECORDINGS = ("look-around", "walk")
DK1 = "--headset rift-dk1"  # of every figure in docs/ that names no other
REPLAYS = tomllib.loads((DOCS / "tables.toml").read_text(encoding="utf-8"))
COLUMNS = REPLAYS.pop("columns")
BASELINES = ("none", "rotation:edge=clamp", "mesh:grid=64", "mesh:grid=512,ring=0.002", "cv2.warpFrame")
SHOWN = (*BASELINES, "planar", "forward", "iterative", "layered", "multi")
TRIED = ("interpolate", "constant", "stretch+constant", "stretch+pyramid", "pyramid", "memory+pyramid")
# Tables that a command or a script prints; True for Markdown, False for a block of text.
PRINTED: Mapping[str, tuple[str, bool]] = {
    "codecs": ("docs/measure/codec_rates.py", True),
    "check rates": ("docs/measure/check_rates.py", True),
    "warper cost": ("docs/measure/warper_cost.py", True),
    "refresh calls": ("docs/measure/refresh_calls.py", False),
    "averaging": ("docs/measure/averaging_cost.py", True),
    "averaging gain": ("docs/measure/averaging_gain.py", True),
    "foveation": ("docs/measure/foveated.py", True),
    "hidden area": ("docs/measure/hidden_area.py", True),
    "page reads": ("docs/measure/page_reads.py", True),
}


def run(command: str, folder: Path, *, said: bool = False, **environment: str) -> str:
    """Run Python and return what it prints, said: on stderr. Raises: SystemExit."""
    print(command, flush=True)
    words, how = [sys.executable, *shlex.split(command.format(folder=folder))], {"cwd": ROOT, "text": True}
    done = subprocess.run(words, check=False, capture_output=True, env={**os.environ, **environment}, **how)
    if done.returncode:
        raise SystemExit(done.stderr)
    return (done.stderr if said else done.stdout).rstrip()


def hmdwarp(command: str, out: Path, result: str) -> dict[str, Any]:
    """Run a command of the program and return the JSON file that it writes into `out`."""
    run(f"-m hmdwarp {command} --quiet --out {out}", out)
    return json.loads((out / result).read_text(encoding="utf-8"))


def printed(name: str, folder: Path) -> None:
    """Write what a command prints, without the line that names this run's folder."""
    command, is_markdown = PRINTED[name]
    text = "\n".join(line for line in run(command, folder).splitlines() if str(folder) not in line)
    replace(name, text if is_markdown else f"```text\n{text}\n```")


def replays(name: str, folder: Path) -> None:
    """Run the replays of a table of tables.toml and write their figures."""
    table = REPLAYS[name]
    across, first = table.get("across", [""]), table.get("first", [])
    heads = [*(axis["head"] for axis in table["axes"]), *first]
    heads += [f"{label}: {column}" if label else column for label in across for column in table["columns"]]
    rows = []
    for number, choice in enumerate(itertools.product(*map(_values, table["axes"]))):
        runs = []
        for label in across:
            options = " ".join([label, table["options"], *(options for _, options in choice)])
            out = folder / f"{name}-{number}-{label}".replace(" ", "-")
            runs.append(hmdwarp(f"replay {DK1} {options} --images 0 --against ''", out, "summary.json"))
        cells = [label for label, _ in choice]
        for column in first:  # the mean of what stands beside each other
            mean = sum(float(figure(column, each)) for each in runs) / len(runs)
            cells.append(format(mean, COLUMNS[column][1]))
        rows.append([*cells, *(figure(column, summary) for summary in runs for column in table["columns"])])
    replace(name, markdown(heads, rows, texts=len(table["axes"])))


def _values(axis: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return (label, options) of each value of an axis."""
    values, option = axis["values"], axis.get("option", "")
    if isinstance(values, dict):
        return list(values.items())
    return [(f"`{value}`" if option and not value[0].isdigit() else value, f"{option} {value}") for value in values]


def figure(column: str, summary: Mapping[str, Any]) -> str:
    """Return a figure of a summary as it is written, "" where there is none."""
    path, form = COLUMNS[column]
    value: Any = summary
    for key in path.split("."):
        value = value.get(key) if value is not None else None
    return "" if value is None else format(value, form).removesuffix("%")


def read(paths: Iterable[str]) -> list[dict[str, Any]]:
    """Return the content of JSON files."""
    return [json.loads(Path(path).read_text(encoding="utf-8")) for path in paths]


def bench(folder: Path, *ready: str) -> None:
    """Measure every warp at 200, 400, 600 and 800 ms: two tables, the plot, the front page."""
    later = "--latency 400,600,800 --instants 3 --rounds 1"
    plain = f"bench {DK1} --predict none --size 800x500"
    runs = {"200": plain, "later": f"{plain} {later}"}
    made = read(ready) or [hmdwarp(command, folder / name, "bench.json") for name, command in runs.items()]
    rows = [row for data in made for row in data["rows"]]
    replace("machine", gpu_tables.machine_line(made[0]))
    replace("warps", warps_table([row for row in rows if row["latency_ms"] == 200]))
    replace("warps later", later_table([row for row in rows if row["latency_ms"] > 200]))
    pareto(folder)
    replace("results", front_page())


def pareto(_: Path) -> None:
    """Draw pareto.png: error against time of the table of warps, on `walk` at 200 ms."""
    from hmdwarp.report import paper_bytes
    from hmdwarp.report.bench.page import pareto_chart
    from hmdwarp.report.bench.rows import cases

    rows = []
    for line in rows_of("warps"):
        warp, system = re.fullmatch(r"`(.+?)`(?: \((.+)\))?", line["warp"]).groups("")
        quality = {"flip": {"mean": float(line["walk: FLIP"])}}
        times = {"total": {"median": float(line["walk: ms"])}}
        named = {"warp": warp, "fill": line["fill"].strip("`"), "baseline": system}
        rows.append({"trace": "walk", "latency_ms": 200.0, **named, "quality": quality, "time_ms": times})
    (case,) = cases(rows)
    (DOCS / "pareto.png").write_bytes(paper_bytes(pareto_chart(case), "png", 7.0))


def _flip(row: Mapping[str, Any]) -> float:
    return row["quality"]["flip"]["mean"]


def _best(rows: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    """Return each warp of SHOWN with the fill of its lowest FLIP over all rows, the best first."""
    sums: dict[tuple[str, str], float] = {}
    for row in rows:
        sums[row["warp"], row["fill"]] = sums.get((row["warp"], row["fill"]), 0.0) + _flip(row)
    ordered = sorted((pair for pair in sums if pair[0] in SHOWN), key=lambda pair: sums[pair])
    best = {warp: next(pair for pair in ordered if pair[0] == warp) for warp, _ in ordered}
    return sorted({*best.values(), ("forward", "interpolate")}, key=lambda pair: sums[pair])


def warps_table(rows: Sequence[dict[str, Any]]) -> str:
    """Return time and error of the best of each warp. rows: of bench.json, at one latency."""
    figures = ("ms", "PSNR dB", "FLIP", "holes %")
    heads = ["warp", "fill", *(f"{trace}: {name}" for trace in RECORDINGS for name in figures)]
    cells = []
    for warp, fill in _best(rows):
        found = {row["trace"]: row for row in rows if (row["warp"], row["fill"]) == (warp, fill)}
        system = next(iter(found.values()))["baseline"]
        line = [f"`{warp}`" + (f" ({system})" if system else ""), f"`{fill}`"]
        for row in map(found.__getitem__, RECORDINGS):
            quality, holes = row["quality"]["psnr_db"]["mean"], row["quality"]["hole_share"]["mean"]
            total = row["time_ms"]["total"]["median"]
            line += [f"{total:.2f}", f"{quality:.2f}", f"{_flip(row):.3f}", f"{100 * holes:.1f}"]
        cells.append(line)
    return markdown(heads, cells, texts=2)


def later_table(rows: Sequence[dict[str, Any]]) -> str:
    """Return PSNR and FLIP of the best of each warp at the later latencies."""
    places = list(itertools.product(RECORDINGS, sorted({row["latency_ms"] for row in rows})))
    heads = ["warp", "fill", *(f"{trace}, {latency:g} ms" for trace, latency in places)]
    by = {(row["warp"], row["fill"], row["trace"], row["latency_ms"]): row["quality"] for row in rows}
    cells = []
    for warp, fill in _best(rows):
        found = [by[warp, fill, *place] for place in places]
        figures = [f"{quality['psnr_db']['mean']:.2f}, {quality['flip']['mean']:.3f}" for quality in found]
        cells.append([f"`{warp}`", f"`{fill}`", *figures])
    return markdown(heads, cells, texts=2)


def front_page() -> str:
    """Return both tables of README.md, each with a line that says what it shows."""
    defaults = "From the thesis's method to the default: 200 ms late, 480x600 an eye, antialiased."
    machine = text_of("machine").split(";")[1].strip()
    warps = f"200 ms late, guard band 1.5, 800x500 an eye, antialiased, {machine}; "
    warps += "each warp with the fill of the lowest FLIP."
    warps = textwrap.fill(" ".join(warps.split()), 100, break_on_hyphens=False)
    return "\n\n".join((defaults, _without("defaults", "flicker"), warps, _without("warps", "holes %")))


def _without(name: str, column: str) -> str:
    """Return a table of docs/ without these columns and without warps that need more than depth."""
    kept = [head for head in lines_of(name)[0] if not head.endswith(f": {column}")]
    rows = [row for row in rows_of(name) if row.get("warp") not in ("`multi`", "`layered`")]
    return markdown(kept, [[row[head] for head in kept] for row in rows], texts=1 + ("fill" in kept))


def suite(folder: Path, *ready: str) -> None:
    """Run a named suite: the means over heads and scenes, and what is sure of them."""
    data = read(ready)[0] if ready else hmdwarp("bench --suite brief", folder / "suite", "bench.json")
    about, rows = data["suite"], data["suite"]["over_all"]
    heads = ["latency ms", "warp", "fill", "FLIP", "FLIP p95", "behind the best", "PSNR dB", "PSNR where seen", "rank"]
    heads += ["best in %", "FLIP, fitted on", "FLIP, held out", "behind, held out"]
    counts = "{} heads, {} scenes".format(max(row["heads"] for row in rows), max(row["scenes"] for row in rows))
    told = f"Suite `{about['name']}` {about['version']}, {counts}, {data['rows'][0]['frames']} pictures a case."
    told += "\nEach warp with its better fill, `iterative` with both."
    best: dict[tuple[float, str], float] = {}
    for row in rows:
        place = row["latency_ms"], row["warp"]
        best[place] = min(best.get(place, math.inf), row["flip"]["mean"])
    shown = [
        r for r in rows if r["warp"] == "iterative" or r["flip"]["mean"] == best.pop((r["latency_ms"], r["warp"]), None)
    ]
    replace("suite", f"{told}\n\n{markdown(heads, map(_suite_cells, shown), texts=3)}")


def _ranged(entry: Mapping[str, Any], form: str, sign: str = "") -> str:
    ends = entry["interval"]
    return format(entry["mean"], sign + form) + (f" ±{format((ends[1] - ends[0]) / 2, form)}" if ends else "")


def _ranks(row: Mapping[str, Any]) -> tuple[str, str]:
    rank = row["rank"]
    return (" to ".join(map(str, rank["interval"])), f"{rank['best']:.0%}") if rank else ("", "")


def _suite_cells(row: Mapping[str, Any]) -> list[str]:
    return [
        *(format(row["latency_ms"], "g"), f"`{row['warp']}`", f"`{row['fill']}`"),
        *(_ranged(row["flip"], ".3f"), format(row["flip"]["p95"], ".3f"), _ranged(row["behind"], ".4f", "+")),
        *(_ranged(row["psnr_db"], ".2f"), _ranged(row["where_seen_db"], ".2f"), *_ranks(row)),
        *(format(row["halves"][half]["flip"], ".3f") for half in ("fit", "held_out")),
        _ranged(row["halves"]["held_out"]["behind"], ".4f", "+"),
    ]


def strategies_suite(folder: Path, *ready: str) -> None:
    """Compare some strategies over people, scenes and lived links: means with intervals."""
    from hmdwarp.report.compare_page import ran_text

    command = "compare --suite brief --strategy rotation,proxy,depth_image,multi,difference"
    data = read(ready)[0] if ready else hmdwarp(command, folder / "compare-suite", "compare.json")
    about, rows = data["suite"], data["suite"]["over_all"]
    heads = ["link", "strategy", "FLIP", "FLIP p95", "behind the best", "PSNR dB", "rank", "best in %"]
    cells = [
        [row["over"], f"`{row['strategy']}`", _ranged(row["flip"], ".3f"), format(row["flip"]["p95"], ".3f"),
         _ranged(row["behind"], ".3f", "+"), _ranged(row["psnr_db"], ".2f"), *_ranks(row)]
        for row in rows
    ]  # fmt: skip
    counts = "{} heads, {} scenes".format(max(row["heads"] for row in rows), max(row["scenes"] for row in rows))
    told = f"Suite `{about['name']}` {about['version']} at {rows[0]['latency_ms']:g} ms, {counts}. Each run: "
    told += f"{ran_text(data['rows'])}."
    replace("strategies suite", f"{told}\n\n{markdown(heads, cells, texts=2)}\n\n{_by_pair(data['rows'])}")


def _by_pair(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return who leads in each pair of head and scene, and what loss costs at most."""
    flips: dict[tuple[str, str, str], dict[str, float]] = {}
    frames = {"sent": 0, "lost": 0}
    for row in rows:
        pair = row["over"], row["scene"], row["trace"]
        flips.setdefault(pair, {})[row["strategy"]] = row["quality"]["flip"]["mean"]
        if "lost" in row["over"]:
            frames = {name: count + row["link"]["frames"].get(name, 0) for name, count in frames.items()}
    orders = [sorted(found, key=found.__getitem__) for found in flips.values()]
    first, second, third = (dict.fromkeys(order[at] for order in orders) for at in range(3))
    behind = [found[order[2]] - found[order[1]] for found, order in zip(flips.values(), orders, strict=True)]
    whole = {pair[1:]: found for pair, found in flips.items() if "lost" not in pair[0]}
    costs = [
        found[name] - whole[pair[1:]][name] for pair, found in flips.items() if "lost" in pair[0] for name in found
    ]
    lines = [
        f"Least FLIP in each of {len(flips)} sets of head, scene and link: {', '.join(first)}; next: "
        f"{', '.join(second)}, "
        f"{min(behind):.3f} to {max(behind):.3f} before {', '.join(third)}.",
        f"Loss, {frames['lost']} frames of {frames['sent']}, costs {max(costs):.3f} at most; no run takes more than "
        f"{max(row['mbit_s'] for row in rows):.1f} Mbit/s.",
    ]
    return "\n".join(textwrap.wrap(" ".join(lines), 100))


def strategies(folder: Path, *ready: str) -> None:
    """Compare all strategies: what each is, which for whom, and figures, at 400 ms."""
    from report_tables import chosen_markdown, compare_markdown

    from hmdwarp.client.strategies import strategies as every
    from hmdwarp.report.compare_page import ran_text

    command = f"compare {DK1} --client class-1,class-2,class-3,picture --seconds 0.6 --rate 30 --metrics-every 6"
    data = read(ready)[0] if ready else hmdwarp(command, folder / "compare", "compare.json")
    told = "{0.crosses}. The client {0.client}. Late: {0.late}."
    replace(
        "strategies", bullets((f"`{each.name}`", told.format(each)) for each in sorted(every, key=lambda s: s.name))
    )
    rows = [row for row in data["rows"] if row["latency_ms"] == 400]
    ran = f"Each run: {ran_text(rows)}.\n\n"
    replace("strategies chosen", ran + chosen_markdown({**data, "rows": rows}, (5,)))
    replace("strategies measured", ran + compare_markdown(row for row in rows if row["trace"] == "walk"))


def rgbd(_: Path, *ready: str) -> None:
    """Measure warps, repairs and fills on ten real frames, where they are: half an hour."""
    folder = real_frames.folder_of()
    if folder is None:
        print(f"rgbd is left out: {real_frames.why_absent()}")
        return
    found = read(ready)[0] if ready else real_frames.measured(folder)
    replace("rgbd repairs", real_frames.repairs_table(folder))
    rows, fills = found["camera"], ("none", "interpolate", "pyramid")
    shown = [row for row in rows if row["warp"] in SHOWN + ("mesh",) and row["repair"] in ("none", "edges+complete")]
    replace("rgbd camera", real_frames.table(shown, fills))
    replace("rgbd gains", real_frames.table([row for row in rows if row["warp"] == "iterative"], fills))


def thesis(folder: Path, *ready: str, marker: str = "thesis again") -> None:
    """Run the experiments of the thesis; what several runs have is taken from the last."""
    from report_tables import summary_markdown

    replace(marker, summary_markdown(read(ready) or [hmdwarp("thesis", folder / "thesis", "results.json")]))


def fill_fronts(folder: Path, *sequences: str) -> None:
    """Show which fills are on a front of time and error: of made borders and of recorded frames."""
    if not sequences:
        print("fill-fronts is left out: it takes folders of recorded frames, as in fill-fronts:FOLDER,FOLDER")
        return
    sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tests" / "client")]
    import test_fill_regions as made

    seconds = _least_seconds(made)
    found = {fill: {"of `pyramid`'s time": seconds[fill] / seconds["pyramid"]} for fill in TRIED}
    by_region: dict[str, list[dict[str, float]]] = {}
    for name in made.SCENES:
        for region, (_, by_fill) in made.of_regions(name, TRIED).items():
            by_region.setdefault(f"made: {region}", []).append(by_fill)
    for column, parts in by_region.items():
        for fill in TRIED:
            found[fill][column] = sum(part[fill] for part in parts) / len(parts)
    for number, place in enumerate(sequences):
        more = "--warp iterative --size 320x240 --guard 1.25 --instants 4 --rounds 1"
        command = f"bench --frames {place} {more} --fill {','.join(TRIED)}"
        for row in hmdwarp(command, folder / str(number), "bench.json")["rows"]:
            for region in ("border", "inside"):
                found[row["fill"]][f"{row['scene']}: {region}"] = row["regions"][f"{region}_holes"]["psnr_db"]
            found[row["fill"]][f"{row['scene']}: all"] = row["quality"]["psnr_db"]["mean"]
    heads = list(found[TRIED[0]])
    rows = []
    for fill, figures in found.items():
        fronts = [head for head in heads[1:] if _is_on_front(found, fill, heads[0], head)]
        cells = (format(figures[head], ".2f") for head in heads)
        marked = (f"**{cell}**" if head in fronts else cell for head, cell in zip(heads, cells, strict=True))
        rows.append([f"`{fill}`", *marked])
    replace("fill fronts", markdown(["fill", *heads], rows))


def _is_on_front(found: Mapping[str, Mapping[str, float]], fill: str, cost: str, head: str) -> bool:
    """Return whether it is better by 0.05 dB than each fill that is quicker."""
    own = found[fill]
    return all(each[head] < own[head] - 0.05 for each in found.values() if each[cost] < own[cost])


def _least_seconds(made: Any) -> dict[str, float]:
    """Return the CPU time of each fill beyond that of `none`, in turns: the least of each."""
    from hmdwarp import Warper
    from hmdwarp.geometry import Pose, View

    scene, head = made.SCENES["a step back from a post, and a turn"]
    rendered, shown = View(Pose(), made.FOV), View(head, made.FOV)
    colour, depth = made.drawn(scene, rendered)
    with contextlib.ExitStack() as stack:
        warpers = {
            fill: stack.enter_context(Warper(made.SIZE, warp="iterative", fill=fill)) for fill in ("none", *TRIED)
        }
        least = dict.fromkeys(warpers, float("inf"))
        for _, (fill, warper) in itertools.product(range(9), warpers.items()):
            started = time.process_time()
            warper.warp(colour, depth, rendered, shown)
            least[fill] = min(least[fill], time.process_time() - started)
    return {fill: least[fill] - least["none"] for fill in TRIED}


def kills(folder: Path) -> None:
    """Kill sweeps at random moments; needs the extra `cluster`."""
    replace("kills", run("-m tests.experiments.sweep.killing 40", folder).splitlines()[-1])


def keys(_: Path) -> None:
    """Write the keys of a live run and the scales, from the program's lists."""
    from hmdwarp.cli.catalogue import entries
    from hmdwarp.display import CONTROLS, MOVING, and_mouse

    live = [(f"`{key}`", what) for key, what in MOVING]
    live += [(f"`{f'{each.key} {each.back}'.strip()}`{and_mouse(each)}", each.what) for each in CONTROLS]
    replace("controls", bullets(live))
    scales = [(f"`{row['name']}`", row["summary"], row["source"]) for row in entries("scales")]
    replace("scales", bullets(scales))


def bullets(rows: Iterable[Sequence[str]]) -> str:
    """Return a list of what each is; a third text stands behind it."""
    return "\n".join(f"- {first}: {'; '.join(filter(None, rest))}" for first, *rest in rows)


def assumed_list(kind: str) -> str:
    """Return what the formats or layouts read, and what each assumes where nothing states it."""
    from hmdwarp.cli.catalogue import entries

    rows = []
    for row in entries(kind):
        assumed = ", ".join(name.replace("_", " ") for name, text in row.items() if " (not stated" in text)
        rows.append((f"`{row['name']}`", row["summary"], assumed and f"assumed: {assumed}"))
    return bullets(rows)


def lists_of_tests(_: Path) -> None:
    """Write the hard cases and the layouts of traces, which tests/ lists."""
    sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tests" / "poses")]
    import hard_cases.all_cases  # noqa: F401 (files them)
    import layouts
    from hard_cases.registry import markdown as hard_cases_table

    replace("hard-cases", hard_cases_table())
    replace("trace layouts", layouts.layouts_table())
    replace("contradicted", layouts.contradicted_text())


def bounds(_: Path) -> None:
    """Write what the numbers of the feed's messages may be."""
    from hmdwarp.sources.feed.bounds import BOUNDS

    replace("bounds", bullets((bound.what, bound.text) for bound in BOUNDS))


def pictures(folder: Path) -> None:
    """Draw opening.png (late frame, truth, warped, error), headsets.png and the web page."""
    from PIL import Image

    run("-m hmdwarp headset show index --force --out docs/headsets.png", folder)
    run("docs/web_pictures.py", folder)
    options = "--start 1.1 --seconds 0.1 --metrics-every 1000 --images 1 --guard 1.5 --size 640x640 --headset flat-90"
    hmdwarp(f"replay look-around {options} --against ''", folder / "opening", "summary.json")
    strip = Image.open(folder / "opening" / "images" / "frame-000000-left.png").convert("RGB")
    strip.thumbnail((1920, 1920), Image.Resampling.LANCZOS)
    strip.save(DOCS / "opening.png", optimize=True)


OWN: Mapping[str, Callable[..., None]] = {
    "bench": bench,
    "pareto": pareto,
    "strategies": strategies,
    "strategies-suite": strategies_suite,
    "rgbd": rgbd,
    "thesis": thesis,
    "fill-fronts": fill_fronts,
    "kills": kills,
    "trace formats": lambda _: replace("trace formats", assumed_list("formats")),
    "layouts": lambda _: replace("layouts", assumed_list("layouts")),
    "keys": keys,
    "hard-cases": lists_of_tests,
    "trace layouts": lists_of_tests,
    "bounds": bounds,
    "suite": suite,
    "pictures": pictures,
    "readme": lambda _: replace("results", front_page()),
    # From files of runs on a machine with a GPU: gpu.json of `make bench-gpu`, results.json.
    "gpu": lambda _, *ready: [gpu_tables.file_section(data) for data in read(ready)],
    "thesis-gpu": lambda folder, *ready: thesis(folder, *ready, marker="thesis gpu"),
}


def main() -> None:
    jobs: dict[str, Callable[..., None]] = {name: functools.partial(printed, name) for name in PRINTED}
    jobs |= {name: functools.partial(replays, name) for name in REPLAYS} | OWN
    jobs = {name.replace(" ", "-"): job for name, job in jobs.items()}
    with tempfile.TemporaryDirectory() as folder:
        for part in sys.argv[1:] or [name for name in jobs if not name.endswith("gpu")]:
            which, _, ready = part.partition(":")
            if which == "help":
                print("\n".join(jobs))
            elif which not in jobs:
                raise SystemExit(f"{which}: expected one of {', '.join(jobs)}")
            else:
                jobs[which](Path(folder), *filter(None, ready.split(",")))


if __name__ == "__main__":
    main()
