"""Run what the figures in README.md and docs/ come from, and write them there: `make docs`.

All of it takes some two hours, alone on the machine. `make docs OPTIONS=bench` renews one part (or
another of PARTS). Every figure is printed by the program; edit nothing between the markers by hand.
`make docs OPTIONS=bench:FILE,FILE` takes the bench.json of two earlier runs, the first one with the
defaults; `thesis:FILE,..` takes the results.json of earlier runs, `gpu:FILE,FILE` the gpu.json of
`make bench-gpu` on machines with a GPU.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import tempfile
from functools import partial
from itertools import product
from pathlib import Path

import aims
import before
import bench_tables
import chains
import front_page
import gpu_tables
import guard
import layouts
import light
import models
import panel
import passes
import prediction_tables
import real_frames
import soft
import studies
import users as user_tables
from pages import DOCS, ROOT, replace
from PIL import Image, ImageDraw

from hmdwarp.client.classes import client_names
from hmdwarp.client.strategies import strategies as every_strategy
from hmdwarp.experiments.bench.cases import WITH_COMPLETE_FILLS
from hmdwarp.metrics import QUALITY
from hmdwarp.pipeline.options import PipelineOptions
from hmdwarp.report import summary_markdown
from hmdwarp.report.bench import cases, markdown_table, pareto_plot_png
from hmdwarp.report.compare_page import assigned_markdown, chosen_markdown, compare_markdown
from hmdwarp.run.outside import OUTSIDE

FIGURES = (*QUALITY, "mismatch")
# What a table varies comes after it, and wins.
SMALL = shlex.split(
    "--scene room --warp forward --fill interpolate --guard 1 --predict none --size 480x600 --start 2 --seconds 6"
    " --metrics-every 12"
)
RECORDINGS = ("look-around", "walk")
USUAL = PipelineOptions()
# From the thesis's method to the default, one change after the other.
STEPS = {
    "`forward` + `interpolate`, no guard band": (),
    "guard band 1.5": ("--guard", f"{USUAL.guard:g}"),
    "`iterative`": ("--warp", "iterative"),
    "`pyramid`": ("--fill", "pyramid"),
    "`memory+pyramid`": ("--fill", "memory+pyramid"),
    "prediction: the default": ("--predict", USUAL.predict),
}
QUIET = ("--against", "", "--quiet", "--out")  # followed by the folder
HEAD = "| PSNR dB | SSIM | FLIP | holes % | border % | flicker |\n"


def program(*arguments: str) -> None:
    """Run one command of the program."""
    print(" ".join(["hmdwarp", *arguments]), flush=True)
    subprocess.run([sys.executable, "-m", "hmdwarp", *arguments], check=True)


def run(folder: Path, trace: str, *options: str) -> dict:
    """Run one replay and return its summary."""
    out = folder / "-".join([trace, *options]).replace("/", "_").replace("--", "")
    program("replay", trace, *SMALL, "--images", "0", *QUIET, str(out), *options)
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


def cells(summary: dict) -> str:
    """Return one row of figures, in the order of HEAD."""
    means = {name: figure["mean"] for name, figure in summary["quality"].items()}
    figures = [f"{means['psnr_db']:.2f}", f"{means['ssim']:.3f}", f"{means['flip']:.3f}"]
    figures += [f"{100 * means[name]:.1f}" for name in ("hole_share", "border_share")]
    return " | ".join([*figures, f"{means['flicker']:.3f}"]) + " |"


def table(first: tuple[str, ...], rows: list[tuple[tuple[str, ...], dict]]) -> str:
    """Return a Markdown table with the columns `first` before the figures."""
    lines = ["| " + " | ".join(first) + " " + HEAD + "|" + " --- |" * (len(first) + HEAD.count("|") - 1)]
    lines += ["| " + " | ".join(names) + " | " + cells(summary) for names, summary in rows]
    return "\n".join(lines)


def strip_of(folder: Path) -> list[Image.Image]:
    """Return the four pictures of a replay's first kept refresh: rendered, warped, truth, error."""
    strip = Image.open(folder / "images" / "frame-000000-left.png")
    step = strip.width // 4
    return [strip.crop((k * step, 0, (k + 1) * step, strip.height)) for k in range(4)]


def opening_picture(folder: Path) -> None:
    """Draw docs/opening.png: truth, late frame, warped and error of one refresh."""
    options = "--start 1.1 --seconds 0.1 --metrics-every 1000 --images 1 --guard 1.5 --size 640x640"
    options += " --headset flat-90"
    program("replay", "look-around", *shlex.split(options), *QUIET, str(folder / "opening"))
    rendered, warped, truth, error = strip_of(folder / "opening")
    ordered = Image.new("RGB", (4 * rendered.width, rendered.height), "white")
    for k, part in enumerate((truth, rendered, warped, error)):
        ordered.paste(part, (k * rendered.width, 0))
    ordered.thumbnail((1920, 1920), Image.Resampling.LANCZOS)
    ordered.save(DOCS / "opening.png", optimize=True)


def bench(folder: Path, *ready: str) -> None:
    """Measure every warp at 200, 400, 600 and 800 ms: tables, the plots, and which aims were met.

    ready: bench.json of two earlier runs, to use instead.
    """
    if not ready:
        ready = (str(folder / "200" / "bench.json"), str(folder / "later" / "bench.json"))
        program("bench", "--quiet", "--out", str(folder / "200"))
        later = "--latency 400,600,800 --instants 3 --rounds 1 --no-grid --no-fused --quiet --out"
        program("bench", *shlex.split(later), str(folder / "later"))
    data, *more = (json.loads(Path(name).read_text(encoding="utf-8")) for name in ready)
    rows = [*data["rows"], *(row for other in more for row in other["rows"])]
    at_200 = [row for row in rows if row["latency_ms"] == 200]
    replace("machine", bench_tables.machine_line(data))
    columns = ("warp", "fill", "total_ms", "total_ms_p95", *FIGURES)
    for group in cases(rows):
        name = f"bench {group.rows[0]['trace']} {group.rows[0]['latency_ms']:g}"
        replace(name, markdown_table(group.ordered(), columns, mark="flip"))
    unfilled = [row for case in cases(at_200) for row in case.ordered() if row["fill"] == "none"]
    shares = ("holes_share", "holes_flip", "edges_share", "edges_flip", "elsewhere_share", "elsewhere_flip")
    replace("regions", markdown_table(unfilled, ("trace", "warp", *shares)))
    replace("displacement", bench_tables.displacement_table(data["grid"]))
    replace("fused", bench_tables.fused_table(data["fused"]))
    replace("traffic", bench_tables.traffic_table(at_200))
    replace("aims", aims.table(data))
    pareto_plot_png(DOCS / "pareto.png", sorted(rows, key=lambda row: (row["latency_ms"], row["trace"])))
    readme(folder)


LARGE_SIZE = "2064x2208"


def bench_large(folder: Path, *ready: str) -> None:
    """Measure the warps of the front and the baselines at the size of present displays.

    ready: bench.json of an earlier run, to use instead.
    """
    if not ready:
        warps = ("none", "rotation", "rotation:edge=clamp", "planar", *WITH_COMPLETE_FILLS, *OUTSIDE)
        named = [part for warp in warps for part in ("--warp", warp)]
        options = ("--size", LARGE_SIZE, "--instants", "3", "--rounds", "1", "--no-grid", "--no-fused", "--quiet")
        program("bench", *named, *options, "--out", str(folder / "large"))
        ready = (str(folder / "large" / "bench.json"),)
    data = json.loads(Path(ready[0]).read_text(encoding="utf-8"))
    replace("large machine", bench_tables.machine_line(data, defaults=False))
    rows = [row for case in cases(data["rows"]) for row in case.ordered()]
    replace("bench large", markdown_table(rows, ("trace", "warp", "fill", "total_ms", *FIGURES[:5]), mark="flip"))


def readme(_: Path) -> None:
    """Select the tables of README.md from those of docs/. Runs nothing."""
    replace("results", front_page.tables())


def border(folder: Path) -> None:
    """Measure six warps without a guard band."""
    options = shlex.split("--guard 1 --size 480x600 --fill interpolate --no-grid --no-fused --quiet --out")
    warps = ("none", "rotation", "forward", "iterative", "backward", "environment")
    program("bench", *options, str(folder / "border"), *(part for warp in warps for part in ("--warp", warp)))
    rows = json.loads((folder / "border" / "bench.json").read_text(encoding="utf-8"))["rows"]
    ordered = [row for case in cases(rows) for row in case.ordered()]
    replace("border", markdown_table(ordered, ("trace", "warp", *FIGURES[:5])))


def sharpness(folder: Path) -> None:
    """Measure what each kind of sample leaves of a picture: after thirty warps, and after one."""
    replace("sharpness", chains.table())
    single_warps(folder)


def single_warps(folder: Path) -> None:
    """Measure each kind of sample on the two recordings at 200 ms."""
    options = shlex.split("--fill pyramid --guard 1.5 --latency 200 --seconds 4 --rate 20 --metrics-every 10")
    rows = []
    for name in RECORDINGS:
        for warp in (f"iterative:resample={kind}" for kind in chains.RESAMPLES):
            rows.append(((name, f"`{warp}`"), run(folder, name, "--warp", warp, *options)))
    replace("single warps", table(("recording", "warp"), rows))


def prediction(folder: Path) -> None:
    """Measure the predictors' errors, and a server that renders for the predicted pose."""
    replace("prediction errors", prediction_tables.errors_table())
    rows = []
    for latency in ("100", "200", "400"):
        for predict in prediction_tables.PREDICTORS:
            options = ("--latency", latency, "--warp", "forward", "--predict", predict)
            rows.append(((latency, predict), run(folder, "look-around", *options)))
    replace("prediction", table(("latency ms", "predict"), rows))


LINKS_MBIT_S = (2, 5)


def strategies_listed(folder: Path) -> None:
    """Write what each strategy is."""
    heads = ("strategy", "crosses the link", "the client", "late")
    lines = ["| " + " | ".join(heads) + " |", "|" + " --- |" * len(heads)]
    for one in sorted(every_strategy, key=lambda each: each.name):
        lines.append("| " + " | ".join((f"`{one.name}`", one.crosses, one.client, one.late)) + " |")
    replace("strategies", "\n".join(lines))


def strategies_compared(folder: Path, *ready: str) -> None:
    """Compare all strategies: what each is, the figures, and who can run it.

    ready: compare.json of an earlier run, to use instead.
    """
    if not ready:
        clients = [part for name in client_names() for part in ("--client", name)]
        shorter = ("--seconds", "0.6", "--rate", "30", "--metrics-every", "6")
        program("compare", *clients, *shorter, "--quiet", "--out", str(folder / "compare"))
        ready = (str(folder / "compare" / "compare.json"),)
    data = json.loads(Path(ready[0]).read_text(encoding="utf-8"))
    strategies_listed(folder)
    replace("strategies chosen", chosen_markdown(data, LINKS_MBIT_S))
    replace("strategies measured", compare_markdown(data["rows"]))
    replace("strategies assigned", assigned_markdown(data))


def frames_of_cameras(_: Path, *ready: str) -> None:
    """Measure warps, repairs and fills on ten real frames, where they are: half an hour.

    ready: the figures of an earlier run, to use instead.
    """
    folder = real_frames.folder_of()
    if folder is None:
        print(f"rgbd is left out: {real_frames.why_absent()}")
        return
    found = json.loads(Path(ready[0]).read_text(encoding="utf-8")) if ready else real_frames.measured(folder)
    replace("rgbd repairs", real_frames.repairs_table(folder))
    for name, rows in found.items():
        replace(f"rgbd {name}", real_frames.table(rows))
    chosen = [row for row in found["camera"] if row["warp"] == USUAL.warp]
    replace("rgbd gains", real_frames.table(chosen, ("none", "interpolate", "pyramid")))


def scene_on_the_client(folder: Path) -> None:
    """Measure what it takes and brings that the client has the scene: some ten minutes."""
    (folder / "models").mkdir()
    replace("models", models.table(folder / "models", program))


def soft_bodies(folder: Path) -> None:
    """Measure what deforms, moved and drawn: some five minutes."""
    (folder / "soft").mkdir()
    replace("soft bodies", soft.table(folder / "soft", program))


def moving_light(folder: Path) -> None:
    """Measure late light in scenes whose light moves: some five minutes."""
    (folder / "light").mkdir()
    replace("light", light.table(folder / "light", program))


def users(_: Path) -> None:
    """Measure a server's time for several users in a scene whose light moves: two minutes."""
    replace("users", user_tables.table())


def difference(folder: Path) -> None:
    """Measure coded difference images beside coded pictures, and warped ones beside warps."""
    common = ("--size", "480x400", "--headset", "flat-90", "--start", "1", "--seconds", "1", "--rate", "30")
    rows = []
    for crf in ("16", "22", "28", "34"):
        for warp in ("none", "difference:warped=off", "difference:share=0.05,warped=off"):
            options = ("--warp", warp, "--fill", "none", "--guard", "1", "--predict", "none", "--latency", "0")
            measured = run(folder, "look-around", *common, *options, "--codec", "h264", "--crf", crf)
            rows.append(((crf, f"`{warp}`", f"{measured['link']['mbit_s']:.2f}"), measured))
    replace("difference coded", table(("crf", "warp", "Mbit/s"), rows))
    rows = []
    for trace in RECORDINGS:
        for latency in ("200", "400"):
            for warp, fill in (
                ("none", "none"), ("iterative", "memory+pyramid"), ("backward", "model"), ("difference", "none"),
                ("difference:share=0.05", "none"),
            ):  # fmt: skip
                options = ("--warp", warp, "--fill", fill, "--guard", "1.5", "--latency", latency, "--codec", "h264")
                measured = run(folder, trace, *common, *options)
                megabits = f"{measured['link']['mbit_s']:.2f}"
                rows.append(((trace, latency, f"`{warp}`", f"`{fill}`", megabits), measured))
    replace("difference warped", table(("recording", "latency ms", "warp", "fill", "Mbit/s"), rows))


def points(folder: Path) -> None:
    """Measure points beside warps of pictures that have more than one surface."""
    common = ("--size", "240x300", "--start", "1", "--seconds", "4", "--rate", "20", "--guard", "1.5")
    rows = []
    for trace in RECORDINGS:
        for latency in ("200", "400", "800"):
            for warp in ("points", "layered", "multi", "iterative"):
                options = ("--warp", warp, "--fill", "pyramid", "--latency", latency, "--codec", "h264")
                measured = run(folder, trace, *common, *options)
                megabits = f"{measured['link']['mbit_s']:.2f}"
                rows.append(((trace, latency, f"`{warp}`", megabits), measured))
    replace("points", table(("recording", "latency ms", "warp", "Mbit/s"), rows))


def defaults(folder: Path) -> None:
    """Measure what each part of the default gains and costs, at 200 ms."""
    shorter = ("--seconds", "4", "--rate", "20", "--metrics-every", "10")
    head = "| | pixels drawn | ms an eye | " + " | ".join(
        f"{name}: {what}" for name in RECORDINGS for what in ("PSNR dB", "FLIP", "flicker", "empty %")
    )
    lines = [head + " |", "| --- |" + " ---: |" * (head.count("|") - 1)]
    chosen: dict[str, tuple[str, ...]] = {}
    for step, change in STEPS.items():
        chosen |= {change[k]: change[k : k + 2] for k in range(0, len(change), 2)}
        runs = [
            run(folder, name, *shorter, *(word for pair in chosen.values() for word in pair)) for name in RECORDINGS
        ]
        drawn = runs[0]["rendered"]["pixels"]
        took = [one["time_ms"]["total"]["median"] for one in runs]
        figures = [f"{drawn:.2f}", f"{sum(took) / len(took):.1f}"]
        for one in runs:
            means = {name: figure["mean"] for name, figure in one["quality"].items()}
            empty = one["filled"]["empty"]
            figures += [
                f"{means['psnr_db']:.2f}",
                *(f"{means[n]:.3f}" for n in ("flip", "flicker")),
                f"{100 * empty:.1f}",
            ]
        lines.append("| " + " | ".join([step, *figures]) + " |")
    replace("defaults", "\n".join(lines))


LABEL_PX, WORDS_PX = 62, 36  # the label above each picture of a strip, and the size of ours in its place
EFFECT_SCENES = ("gallery", "workshop", "greenhouse", "cockpit")


def effects_picture(folder: Path) -> None:
    """Draw docs/effects.png, 400 ms late: each scene without and with its passes, and truth."""
    usual = "--latency 400 --guard 1.5 --size 480x400 --headset flat-90 --rate 30 --start 1.7 --seconds 0.1"
    usual += " --warp iterative --fill pyramid --lens none --metrics-every 100 --images 1"
    rows = []
    for scene in EFFECT_SCENES:
        pictures = {}
        for effects in ("none", "auto"):
            out = folder / f"picture-{scene}-{effects}"
            program("replay", "walk", "--scene", scene, "--effects", effects, *shlex.split(usual), *QUIET, str(out))
            pictures[effects] = strip_of(out)
        rows.append((pictures["none"][1], *pictures["auto"][1:3]))
    wide, high = rows[0][0].size
    picture = Image.new("RGB", (3 * wide, len(rows) * high), "white")
    for y, row in enumerate(rows):
        for x, part in enumerate(row):
            picture.paste(part, (x * wide, y * high))
    words = ImageDraw.Draw(picture)
    for y in range(len(rows)):
        words.rectangle((0, y * high, 3 * wide, y * high + LABEL_PX - 1), fill="white")
    for x, label in enumerate(("400 ms late, without its pass", "with it", "what should be seen")):
        words.text((x * wide + 4, 4), label, fill="black", font_size=WORDS_PX)
    picture.thumbnail((1080, 4000), Image.Resampling.LANCZOS)
    picture.save(DOCS / "effects.png", optimize=True)


def effects(folder: Path) -> None:
    """Measure each effect's scene with and without its pass."""
    from hmdwarp.scenes import scenes

    calling = [(source.name, list(source.effects)) for source in scenes if source.effects]
    replace("effects", passes.effects_table(partial(run, folder), calling))


def reflections(folder: Path) -> None:
    """Measure reflections from pictures alone, also where there are no mirrors."""
    replace("reflections", passes.pictures_table(partial(run, folder)))


def fills(folder: Path) -> None:
    """Measure every fill, in former holes and over the whole picture."""
    replace("fills", passes.fills_table(partial(run, folder)))
    memory(folder)
    readme(folder)


def memory(folder: Path) -> None:
    """Measure the memory fill on a head that returns to what it saw."""
    replace("memory", passes.memory_table(partial(run, folder)))


def guard_bands(folder: Path) -> None:
    """Measure what guard bands and the wide view cost and save."""
    replace("guard", guard.band_table(guard.measure(folder / "guard", program)))


def thesis_guard_bands(folder: Path) -> None:
    """Measure which of the thesis's picture sizes suffices for which motion and speed."""
    (folder / "thesis-guard").mkdir()
    replace("thesis guard", guard.finding_table(guard.measure_thesis(folder / "thesis-guard", program)))


def link(folder: Path) -> None:
    """Measure networks and codecs."""
    replace("link", passes.link_table(partial(run, folder)))
    layers(folder)
    depth_codes(folder)
    server_rates(folder)
    proxies(folder)
    chosen_views(folder)


def proxies(folder: Path) -> None:
    """Measure a proxy between server and client: ten minutes."""
    replace("proxy", passes.proxy_table(partial(run, folder)))


def chosen_views(folder: Path) -> None:
    """Measure views that the server chooses."""
    replace("views", passes.views_table(partial(run, folder)))


def layers(folder: Path) -> None:
    """Measure what each kind of layer sends."""
    replace("layers", passes.layers_table(partial(run, folder)))


def depth_codes(folder: Path) -> None:
    """Measure the codes of depth: at most five minutes."""
    replace("depth codes", passes.depth_codes_table(partial(run, folder)))


def governors(folder: Path) -> None:
    """Run a client that is slow for a while with and without its governor: five minutes."""
    times = folder / "times.csv"
    times.write_text("14\n" * 120 + "25\n" * 150 + "14\n" * 90, encoding="utf-8")
    heads = ("recording", "a late picture", "governor", "missed %", "judder deg", "PSNR dB", "FLIP")
    lines = ["| " + " | ".join(heads) + " |", "|" + " --- |" * 3 + " ---: |" * 4]
    for trace, show in product(RECORDINGS, ("turn", "hold")):
        out = folder / f"governor-{trace}-{show}"
        miss = ("--client-time", str(times), "--compare-governor", "--on-miss", show)
        options = shlex.split("--warp auto --budget 8.3 --seconds 6 --size 160x200 --metrics-every 7")
        program("replay", trace, *options, *miss, "--images", "0", *QUIET, str(out))
        on = json.loads((out / "summary.json").read_text(encoding="utf-8"))
        (off,) = on["against"]
        levels = [one["name"] for one in on["auto"]["ladder"] if one["refreshes"]]
        for named, one in ((f"on: {', '.join(levels)}", on), (f"off: {off['warp']} + {off['fill']}", off)):
            missed, quality = one["miss"], {name: entry["mean"] for name, entry in one["quality"].items()}
            cells = (trace, show, named, f"{100 * missed['stale_share']:.1f}", f"{missed['judder_deg']:.3f}")
            lines.append(f"| {' | '.join(cells)} | {quality['psnr_db']:.2f} | {quality['flip']:.3f} |")
    replace("governor", "\n".join(lines))


def server_rates(folder: Path) -> None:
    """Measure the error over the server's rate, on a display of 60 Hz."""
    options = "--server-rate 10,15,30,60 --warp none,rotation,forward,iterative,backward --fill pyramid"
    options += " --size 480x600 --no-grid --no-fused --quiet --out"
    program("bench", "look-around", *shlex.split(options), str(folder / "server-rates"))
    rows = json.loads((folder / "server-rates" / "bench.json").read_text(encoding="utf-8"))["rows"]
    replace("server rates", passes.server_rates_table(rows))


def printed(
    script: str, *options: str, statuses: tuple[int, ...] = (0,), markdown: bool = False, **environment: str
) -> str:
    """Run a script of tests/ and return its output as a block, or as it is if that is Markdown.

    Raises: SystemExit for a status that is not among `statuses`.
    """
    command = [sys.executable, str(ROOT / "tests" / script), *options]
    done = subprocess.run(command, check=False, capture_output=True, text=True, env={**os.environ, **environment})
    if done.returncode not in statuses:
        raise SystemExit(done.stderr)
    return done.stdout.rstrip() if markdown else f"```text\n{done.stdout.rstrip()}\n```"


def on_a_gpu(_: Path, *ready: str) -> None:
    """Write docs/gpu.md. ready: gpu.json of `make bench-gpu`, one for each GPU."""
    if not ready:
        raise SystemExit("gpu: expected gpu.json of 'make bench-gpu' on a GPU, as in OPTIONS=gpu:FILE,FILE")
    for name in ready:
        gpu_tables.file_section(json.loads(Path(name).read_text(encoding="utf-8")))


def feed_ways(_: Path) -> None:
    """Measure what a frame costs between two processes of one machine."""
    replace("feed", printed("bench_feed.py", markdown=True))


def speed(_: Path) -> None:
    """Measure the passes against OpenCV; needs an otherwise idle machine."""
    replace("speed", printed("bench_quick.py"))


def before_and_after(folder: Path, *older: str) -> None:
    """Measure this version and an older one in turns: an hour.

    older: the folder of its checkout.
    """
    if not older:
        print("before is left out: it needs the folder of an older checkout, as in OPTIONS=before:FOLDER")
        return
    (folder / "before").mkdir()
    replace("before", before.table(Path(older[0]).resolve(), folder / "before"))


def speed_aims(_: Path) -> None:
    """Measure how near the warps' aims of speed are, in processor time."""
    replace("speed aims", printed("bench_aims.py", markdown=True))


def hard_cases(_: Path) -> None:
    """Write the table of docs/hard-cases.md from the docstrings of the cases."""
    sys.path.insert(0, str(ROOT / "tests"))
    import hard_cases.all_cases  # noqa: F401 (files them)
    from hard_cases.registry import markdown

    replace("hard-cases", markdown())


def controls(_: Path) -> None:
    """Write the keys of a live run, from the list that the window and the panel use."""
    from hmdwarp.display import CONTROLS, MOVING

    rows = [(keys, what) for keys, what in MOVING]
    rows += [(f"{one.key} {one.back}".strip(), one.what) for one in CONTROLS]
    lines = ["| key | what it does |", "| --- | --- |", *(f"| `{key}` | {what} |" for key, what in rows)]
    replace("controls", "\n".join(lines))


def clients(_: Path) -> None:
    """Write what the shipped client classes can do."""
    command = [sys.executable, "-m", "hmdwarp", "list", "clients", "--markdown"]
    replace("clients", subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def live_cost(_: Path) -> None:
    """Measure the loop outside OpenGL and the garbage collector; needs an idle machine."""
    # Status 1: the limit is exceeded, which the table says.
    parts = [printed("bench_live.py", *options, statuses=(0, 1), COLUMNS="110") for options in ((), ("--gc",))]
    replace("live-cost", "\n\n".join(parts))


def live_picture(_: Path) -> None:
    """Draw docs/live.png: the window with its panel, on a virtual screen."""
    panel.panel_picture(DOCS / "live.png")


def study(folder: Path) -> None:
    """Write the tables and the picture of docs/study*.md that take seconds."""
    replace("scales", studies.scales_table())
    replace("keys", studies.keys_table())
    replace("thesis ratings", studies.thesis_table(folder, program))
    studies.question_picture(DOCS / "question.png")


def study_simulated(folder: Path) -> None:
    """Simulate studies: how often the analysis is right, and how many people a study needs."""
    replace("coverage", studies.coverage_table(ROOT))
    replace("power", studies.power_text(folder))
    replace("pairs-power", studies.pairs_power_table())


def thesis(folder: Path, *ready: str) -> None:
    """Run the experiments of the thesis.

    ready: results.json of earlier runs, to use instead; what several have is taken from the last.
    """
    if not ready:
        ready = (str(folder / "thesis-again" / "results.json"),)
        program("thesis", "--quiet", "--out", str(Path(ready[0]).parent))
    replace("thesis again", summary_markdown([json.loads(Path(name).read_text(encoding="utf-8")) for name in ready]))


def thesis_on_a_gpu(_: Path, *ready: str) -> None:
    """Write the verdicts that hang on times. ready: results.json of a run on a GPU."""
    if not ready:
        raise SystemExit("thesis-gpu: expected results.json of a run on a GPU, as in OPTIONS=thesis-gpu:FILE")
    replace("thesis gpu", summary_markdown([json.loads(Path(name).read_text(encoding="utf-8")) for name in ready]))


def trace_layouts(_: Path) -> None:
    """Read files of twenty layouts with known truth."""
    replace("layouts", layouts.layouts_table())
    replace("contradicted", layouts.contradicted_text())


def sweeps(_: Path) -> None:
    """Kill sweeps at random moments, and measure what one costs; needs the extra `cluster`."""
    command = [sys.executable, "-m", "tests.experiments.sweep.killing", "40"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    replace("kills", done.stdout.splitlines()[-1])
    replace("sweeps", printed("sweep_scale.py", markdown=True))


def ratings(folder: Path) -> None:
    """Rate the steps from the thesis's method to the default by ColorVideoVDP, beside FLIP.

    Needs the extra `jod`. Small and short, since every refresh is rated.
    """
    heads = (
        "",
        *(f"{trace}: {name}" for trace in RECORDINGS for name in ("PSNR dB", "FLIP", "JOD", "truth preferred %")),
    )
    lines = ["| " + " | ".join(heads) + " |", "| --- |" + " ---: |" * (len(heads) - 1)]
    size = ("--size", "160x200", "--seconds", "0.3", "--metrics-every", "3", "--jod", "0.3")
    rows, so_far = {"no warp": ("--warp", "none", "--fill", "none")}, ()
    for name, step in STEPS.items():
        rows[name] = so_far = (*so_far, *step)
    for name, options in rows.items():
        cells = []
        for trace in RECORDINGS:
            found = run(folder, trace, *size, *options)
            rated, means = found["jod"], {key: found["quality"][key]["mean"] for key in ("psnr_db", "flip")}
            cells += [f"{means['psnr_db']:.2f}", f"{means['flip']:.3f}"]
            cells += [f"{rated['mean']:.2f}", f"{100 * rated['truth_preferred']:.0f}"]
        lines.append(f"| {' | '.join((name, *cells))} |")
    replace("jod", "\n".join(lines))


def warper_cost(_: Path) -> None:
    """Measure a Warper beside its passes, on this machine's processor."""
    replace("warper cost", printed("bench_warper.py", markdown=True))


def check_rates(_: Path) -> None:
    """Misread a thousand recordings of a depth camera, and count what `hmdwarp check` names."""
    replace("check rates", printed("check_rates.py", markdown=True))


PARTS = {
    "rgbd": frames_of_cameras,
    "warper-cost": warper_cost,
    "check-rates": check_rates,
    "layouts": trace_layouts,
    "study": study,
    "study-simulated": study_simulated,
    "hard-cases": hard_cases,
    "controls": controls,
    "clients": clients,
    "live-picture": live_picture,
    "live-cost": live_cost,
    "picture": opening_picture,
    "effects-picture": effects_picture,
    "speed": speed,
    "speed-aims": speed_aims,
    "before": before_and_after,
    "gpu": on_a_gpu,
    "bench": bench,
    "bench-large": bench_large,
    "border": border,
    "sharpness": sharpness,
    "single-warps": single_warps,
    "defaults": defaults,
    "strategies": strategies_compared,
    "strategies-list": strategies_listed,
    "difference": difference,
    "points": points,
    "models": scene_on_the_client,
    "light": moving_light,
    "soft": soft_bodies,
    "users": users,
    "prediction": prediction,
    "effects": effects,
    "reflections": reflections,
    "fills": fills,
    "memory": memory,
    "guard": guard_bands,
    "thesis-guard": thesis_guard_bands,
    "link": link,
    "thesis": thesis,
    "thesis-gpu": thesis_on_a_gpu,
    "layers": layers,
    "depth-code": depth_codes,
    "server-rates": server_rates,
    "governor": governors,
    "proxy": proxies,
    "views": chosen_views,
    "feed": feed_ways,
    "sweeps": sweeps,
    "jod": ratings,
    "readme": readme,
}


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        # All but what needs a GPU, which the machine that writes the pages may not have.
        for part in sys.argv[1:] or [part for part in PARTS if not part.endswith("gpu")]:
            which, _, ready = part.partition(":")
            PARTS[which](Path(name), *filter(None, ready.split(",")))


if __name__ == "__main__":
    main()
