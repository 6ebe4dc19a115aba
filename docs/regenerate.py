"""Runs what the figures in README.md and docs/ come from and writes them there: `make docs`, about an hour, alone on the machine.

`make docs OPTIONS=bench` renews a part (or another of PARTS). Every figure is printed by the program; nothing between the markers is
edited by hand. `make docs OPTIONS=bench:FILE,FILE` takes what two runs left, the first with the defaults; `guard:FILE` the rows that a
run left.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import aims
import guard
import panel
import passes
import studies
from PIL import Image, ImageDraw

from hmdwarp.report.bench_cases import cases
from hmdwarp.report.bench_charts import pareto_plot_png
from hmdwarp.report.bench_tables import markdown_table

ROOT = Path(__file__).resolve().parents[1]
README, RESULTS, LIVE = ROOT / "README.md", ROOT / "docs" / "results.md", ROOT / "docs" / "live.md"
STUDY = ROOT / "docs" / "study.md"
FIGURES = ("psnr_db", "ssim", "flip", "hole_share", "border_share", "flicker", "mismatch")
SMALL = (
    "--scene",
    "room",
    "--fill",
    "interpolate",
    "--size",
    "480x600",
    "--start",
    "2",
    "--seconds",
    "6",
    "--metrics-every",
    "12",
)
HEAD = "| PSNR dB | SSIM | FLIP | holes % | border % | flicker |\n"


def program(*arguments: str) -> None:
    """One run of the program."""
    print(" ".join(["hmdwarp", *arguments]), flush=True)
    subprocess.run([sys.executable, "-m", "hmdwarp", *arguments], check=True)


def run(folder: Path, trace: str, *options: str) -> dict:
    """One replay; its summary."""
    out = folder / "-".join([trace, *options]).replace("/", "_").replace("--", "")
    program("replay", trace, *SMALL, "--against", "", "--images", "0", "--quiet", "--out", str(out), *options)
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


def cells(summary: dict) -> str:
    """One row of figures, in the order of HEAD."""
    q = summary["quality"]
    shares = (100 * q[name]["mean"] for name in ("hole_share", "border_share"))
    quality = [
        f"{q['psnr_db']['mean']:.2f}",
        f"{q['ssim']['mean']:.3f}",
        f"{q['flip']['mean']:.3f}",
        *(f"{s:.1f}" for s in shares),
    ]
    return " | ".join([*quality, f"{q['flicker']['mean']:.3f}"]) + " |"


def table(first: tuple[str, ...], rows: list[tuple[tuple[str, ...], dict]]) -> str:
    """A Markdown table with the columns `first` before the figures."""
    lines = ["| " + " | ".join(first) + " " + HEAD + "|" + " --- |" * (len(first) + HEAD.count("|") - 1)]
    lines += ["| " + " | ".join(names) + " | " + cells(summary) for names, summary in rows]
    return "\n".join(lines)


def replace(path: Path, name: str, text: str) -> None:
    """Put `text` between the markers of that name."""
    old = path.read_text(encoding="utf-8")
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not pattern.search(old):
        raise SystemExit(f"{path}: no markers <!-- {name} --> .. <!-- end -->")
    path.write_text(pattern.sub(lambda m: m.group(1) + text.rstrip() + "\n" + m.group(2), old), encoding="utf-8")


def opening_picture(folder: Path) -> None:
    """docs/opening.png: truth, late frame, warped, error, of one refresh of `look-around`."""
    out = folder / "opening"
    options = [
        "--start",
        "1.1",
        "--seconds",
        "0.1",
        "--metrics-every",
        "1000",
        "--images",
        "1",
        "--guard",
        "1.5",
        "--size",
        "640x640",
    ]
    options += ["--headset", "flat-90", "--fill", "interpolate", "--against", "", "--quiet", "--out", str(out)]
    subprocess.run([sys.executable, "-m", "hmdwarp", "replay", "look-around", *options], check=True)
    strip = Image.open(out / "images" / "frame-000000-left.png")
    rendered, warped, truth, error = (
        strip.crop((k * strip.width // 4, 0, (k + 1) * strip.width // 4, strip.height)) for k in range(4)
    )
    ordered = Image.new("RGB", strip.size, "white")
    for k, part in enumerate((truth, rendered, warped, error)):
        ordered.paste(part, (k * strip.width // 4, 0))
    ordered.thumbnail((1920, 1920), Image.Resampling.LANCZOS)
    ordered.save(ROOT / "docs" / "opening.png", optimize=True)


def bench(folder: Path, *ready: str) -> None:
    """Every warp at 200, 400 and 800 ms: tables, the plot of README.md, and what became of the aims."""
    if not ready:
        ready = (str(folder / "200" / "bench.json"), str(folder / "later" / "bench.json"))
        program("bench", "--quiet", "--out", str(folder / "200"))
        later = ("--latency", "400", "--latency", "800", "--instants", "3", "--rounds", "1", "--no-grid", "--no-fused")
        program("bench", *later, "--quiet", "--out", str(folder / "later"))
    data, *more = (json.loads(Path(name).read_text(encoding="utf-8")) for name in ready)
    rows = [*data["rows"], *(row for other in more for row in other["rows"])]
    at_200 = [row for row in rows if row["latency_ms"] == 200]
    machine = f"{data['machine']['gl_renderer']}, {data['machine']['cpu_count']} cores"
    clock = "GPU timers" if data["clock"] == "gpu" else "wall clock after every pass"
    minutes = f"the bench with its defaults took {data['seconds'] / 60:.1f} minutes"
    told = (
        f"hmdwarp {data['hmdwarp']}",
        machine,
        data["machine"]["gl_version"],
        clock,
        f"{data['copy_gb_s']:.1f} GB/s copied",
        minutes,
    )
    replace(RESULTS, "machine", "; ".join(told) + ".")
    for group in cases(rows):
        name = f"bench {group.rows[0]['trace']} {group.rows[0]['latency_ms']:g}"
        replace(
            RESULTS,
            name,
            markdown_table(group.ordered(), ("warp", "fill", "total_ms", "total_ms_p95", *FIGURES), mark="flip"),
        )
    regions = [row for case in cases(at_200) for row in case.ordered() if row["fill"] == "none"]
    wanted = ("holes_share", "holes_flip", "edges_share", "edges_flip", "elsewhere_share", "elsewhere_flip")
    replace(RESULTS, "regions", markdown_table(regions, ("trace", "warp", *wanted)))
    replace(RESULTS, "displacement", displacement_table(data["grid"]))
    replace(RESULTS, "fused", fused_table(data["fused"]))
    replace(RESULTS, "traffic", traffic_table(at_200))
    replace(RESULTS, "aims", aims.table(data))
    replace(README, "results", short_table(at_200) + f"\nMeasured on {machine}.")
    pareto_plot_png(ROOT / "docs" / "pareto.png", at_200)


def short_table(rows: list[dict]) -> str:
    """For the README: of each recording what nobody beats in error and time, and the usual ones beside them."""
    usual = {("none", "none"), ("rotation", "none"), ("forward", "interpolate")}
    chosen = []
    for case in cases(rows):
        best = {id(row) for row in case.front()}
        chosen += [row for row in case.ordered() if id(row) in best or (row["warp"], row["fill"]) in usual]
    return markdown_table(chosen, ("trace", "warp", "fill", "total_ms", "psnr_db", "flip", "hole_share"), mark="flip")


def displacement_table(grid: list[dict]) -> str:
    """FLIP of each warp by how far the head moved, the mean of both directions and of the axes of one kind."""
    steps = [("xyz", 0.1), ("xyz", 0.2), ("xyz", 0.3), ("turn", 10), ("turn", 20), ("turn", 30)]
    lines = [
        "| warp | "
        + " | ".join(f"{step * 100:.0f} cm" if kind == "xyz" else f"{step} degrees" for kind, step in steps)
        + " |"
    ]
    lines.append("|" + " --- |" * (len(steps) + 1))
    for warp in dict.fromkeys(row["warp"] for row in grid):
        means = []
        for kind, step in steps:
            found = [
                row["flip"]
                for row in grid
                if row["warp"] == warp
                and (row["axis"] in "xyz") == (kind == "xyz")
                and abs(abs(row["offset"]) - step) < 1e-6
            ]
            means.append(f"{sum(found) / len(found):.3f}")
        lines.append(f"| `{warp}` | " + " | ".join(means) + " |")
    return "\n".join(lines)


def fused_table(rows: list[dict]) -> str:
    """Warp and lens in one resample against two."""
    lines = [
        "| warp | one resample ms | two ms | faster | PSNR dB one / two | FLIP one / two | sharpness one / two |",
        "|" + " --- |" * 7,
    ]
    for row in rows:
        pairs = [(row[name]["fused"], row[name]["separate"]) for name in ("psnr_db", "flip", "sharpness")]
        told = [f"{a:.{digits}f} / {b:.{digits}f}" for (a, b), digits in zip(pairs, (2, 3, 2), strict=True)]
        lines.append(
            f"| `{row['warp']}` | {row['fused_ms']:.1f} | {row['separate_ms']:.1f} | {row['speedup']:.2f}x | {' | '.join(told)} |"
        )
    return "\n".join(lines)


def traffic_table(rows: list[dict]) -> str:
    """What each pass must move, the least time that takes, and how far above it the pass runs; the first row of each pass."""
    lines = ["| pass | MB | bound ms | measured ms | times the bound |", "|" + " --- |" * 5]
    seen = set()
    for row in rows:
        for one in row["passes"]:
            kind = one["name"]
            name = row["warp"] if kind == "warp" else f"{kind} {row.get(kind, '')}".strip()
            if name not in seen:
                seen.add(name)
                figures = f"{one['bytes'] / 1e6:.1f} | {one['bound_ms']:.2f} | {one['median_ms']:.2f} | {one['times_bound']:.1f}"
                lines.append(f"| `{name}` | {figures} |")
    return "\n".join(lines)


def border(folder: Path) -> None:
    """Without a guard band."""
    options = ("--guard", "1", "--size", "480x600", "--fill", "interpolate", "--no-grid", "--no-fused", "--quiet")
    warps = ("none", "rotation", "forward", "iterative", "backward", "environment")
    program("bench", *options, "--out", str(folder / "border"), *(part for warp in warps for part in ("--warp", warp)))
    rows = json.loads((folder / "border" / "bench.json").read_text(encoding="utf-8"))["rows"]
    ordered = [row for case in cases(rows) for row in case.ordered()]
    replace(RESULTS, "border", markdown_table(ordered, ("trace", "warp", *FIGURES[:5])))


def prediction(folder: Path) -> None:
    """A server that draws for the predicted pose."""
    rows = [
        (
            (latency, predict),
            run(folder, "look-around", "--latency", latency, "--warp", "forward", "--predict", predict),
        )
        for latency in ("200", "400")
        for predict in ("none", "constant_velocity")
    ]
    replace(RESULTS, "prediction", table(("latency ms", "predict"), rows))


LABEL_PX, WORDS_PX = 62, 36  # of the line of words over each picture of a strip, and of ours in its place
EFFECT_SCENES = ("gallery", "workshop", "greenhouse", "cockpit")


def effects_picture(folder: Path) -> None:
    """docs/effects.png: a row for each of four scenes, 400 ms late: without its passes, with them, what should be seen."""
    usual = (
        "--latency",
        "400",
        "--guard",
        "1.5",
        "--size",
        "480x400",
        "--headset",
        "flat-90",
        "--rate",
        "30",
        "--start",
        "1.7",
        "--seconds",
        "0.1",
    )
    usual += (
        "--warp",
        "iterative",
        "--fill",
        "pyramid",
        "--lens",
        "none",
        "--against",
        "",
        "--metrics-every",
        "100",
        "--images",
        "1",
        "--quiet",
    )
    rows = []
    for scene in EFFECT_SCENES:
        panels = []
        for asked in ("none", "auto"):
            out = folder / f"picture-{scene}-{asked}"
            program("replay", "walk", "--scene", scene, "--effects", asked, *usual, "--out", str(out))
            strip = Image.open(out / "images" / "frame-000000-left.png")
            panels += [strip.crop((k * strip.width // 4, 0, (k + 1) * strip.width // 4, strip.height)) for k in (1, 2)]
        rows.append((panels[0], panels[2], panels[3]))
    wide, high = rows[0][0].size
    picture = Image.new("RGB", (3 * wide, len(rows) * high), "white")
    for y, row in enumerate(rows):
        for x, part in enumerate(row):
            picture.paste(part, (x * wide, y * high))
    words = ImageDraw.Draw(picture)
    for y in range(len(rows)):
        words.rectangle((0, y * high, 3 * wide, y * high + LABEL_PX - 1), fill="white")
    for x, told in enumerate(("400 ms late, without its pass", "with it", "what should be seen")):
        words.text((x * wide + 4, 4), told, fill="black", font_size=WORDS_PX)
    picture.thumbnail((1080, 4000), Image.Resampling.LANCZOS)
    picture.save(ROOT / "docs" / "effects.png", optimize=True)


def effects(folder: Path) -> None:
    """Each effect's scene with and without its pass."""
    from hmdwarp.scenes import scenes
    from hmdwarp.scenes.effects import effect_names

    calling = [(source.name, effect_names(source.effects)) for source in scenes if source.effects]
    replace(RESULTS, "effects", passes.effects_table(partial(run, folder), calling))


def fills(folder: Path) -> None:
    """Every fill, in former holes and over the whole picture."""
    replace(RESULTS, "fills", passes.fills_table(partial(run, folder)))
    memory(folder)


def memory(folder: Path) -> None:
    """A head that comes back to what it saw."""
    replace(RESULTS, "memory", passes.memory_table(partial(run, folder)))


def guard_bands(folder: Path, *ready: str) -> None:
    """What a guard band or a wide view costs and saves. ready: the rows that a run left."""
    rows = json.loads(Path(ready[0]).read_text(encoding="utf-8")) if ready else guard.measure(folder / "guard", program)
    replace(RESULTS, "guard", guard.band_table(rows))
    replace(RESULTS, "thesis", guard.finding_table(rows))


def link(folder: Path) -> None:
    """Networks and codecs."""
    replace(RESULTS, "link", passes.link_table(partial(run, folder)))


def speed(_: Path) -> None:
    """The output of the benchmark against OpenCV; wants a machine that does nothing else."""
    told = subprocess.run(
        [sys.executable, str(ROOT / "tests" / "bench_quick.py")], check=True, capture_output=True, text=True
    ).stdout
    replace(RESULTS, "speed", f"```text\n{told.rstrip()}\n```")


def hard_cases(_: Path) -> None:
    """The table of docs/hard-cases.md, from the docstrings of the cases."""
    sys.path.insert(0, str(ROOT / "tests"))
    import hard_cases.all_cases  # noqa: F401 (files them)
    from hard_cases.registry import markdown

    replace(ROOT / "docs" / "hard-cases.md", "hard-cases", markdown())


def controls(_: Path) -> None:
    """The keys of a live run, from the list that the window and the panel are made from."""
    from hmdwarp.display.controls import CONTROLS, MOVING

    rows = [(keys, what) for keys, what in MOVING]
    rows += [(f"{one.key} {one.back}".strip(), one.what) for one in CONTROLS]
    lines = ["| key | what it does |", "| --- | --- |", *(f"| `{key}` | {what} |" for key, what in rows)]
    replace(LIVE, "controls", "\n".join(lines))


def live_cost(_: Path) -> None:
    """What the loop costs outside GL, and what the garbage collector does; wants a machine that does nothing else."""
    parts = []
    for options in ((), ("--gc",)):
        command = [sys.executable, str(ROOT / "tests" / "bench_live.py"), *options]
        done = subprocess.run(
            command, check=False, capture_output=True, text=True, env={**os.environ, "COLUMNS": "110"}
        )
        if done.returncode not in (0, 1):  # 1: the limit is not kept, which the table says
            raise SystemExit(done.stderr)
        parts.append(f"```text\n{done.stdout.rstrip()}\n```")
    replace(LIVE, "live-cost", "\n\n".join(parts))


def live_picture(_: Path) -> None:
    """docs/live.png: the window with its panel, on a virtual screen."""
    panel.panel_picture(ROOT / "docs" / "live.png")


def study(folder: Path) -> None:
    """docs/study.md but for what takes minutes."""
    replace(STUDY, "scales", studies.scales_table())
    replace(STUDY, "keys", studies.keys_table())
    replace(STUDY, "thesis", studies.thesis_table(folder, program))
    studies.question_picture(ROOT / "docs" / "question.png")


def study_simulated(folder: Path) -> None:
    """How often the analysis is right, and how many people a study needs: a few minutes of made-up studies."""
    replace(STUDY, "coverage", studies.coverage_table(ROOT))
    replace(STUDY, "power", studies.power_told(folder))


PARTS = {
    "study": study,
    "study-simulated": study_simulated,
    "hard-cases": hard_cases,
    "controls": controls,
    "live-picture": live_picture,
    "live-cost": live_cost,
    "picture": opening_picture,
    "effects-picture": effects_picture,
    "speed": speed,
    "bench": bench,
    "border": border,
    "prediction": prediction,
    "effects": effects,
    "fills": fills,
    "memory": memory,
    "guard": guard_bands,
    "link": link,
}


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        for part in sys.argv[1:] or PARTS:
            which, _, ready = part.partition(":")
            PARTS[which](Path(name), *filter(None, ready.split(",")))


if __name__ == "__main__":
    main()
