"""Runs what the figures in README.md and docs/results.md come from and writes them there: `make docs`, about twenty minutes.

`make docs OPTIONS=speed` (or picture, or quality) renews a part. Every figure is printed by the program; nothing between the
markers is edited by hand.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
WARPS = ("none", "rotation", "planar", "forward", "backward")
COMMON = ("--scene", "room", "--fill", "interpolate", "--size", "480x600", "--start", "2", "--seconds", "6", "--metrics-every", "12")
HEAD = "| PSNR dB | SSIM | FLIP | holes % | border % | flicker |\n"


def run(folder: Path, trace: str, *options: str) -> dict:
    """One replay; its summary."""
    out = folder / "-".join([trace, *options]).replace("/", "_").replace("--", "")
    command = [sys.executable, "-m", "hmdwarp", "replay", trace, *COMMON, "--against", "", "--quiet", "--out", str(out), *options]
    print(" ".join(["hmdwarp", *command[3:]]), flush=True)
    subprocess.run(command, check=True)
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


def cells(summary: dict) -> str:
    """One row of figures, in the order of HEAD."""
    q = summary["quality"]
    shares = (100 * q[name]["mean"] for name in ("hole_share", "border_share"))
    quality = [f"{q['psnr_db']['mean']:.2f}", f"{q['ssim']['mean']:.3f}", f"{q['flip']['mean']:.3f}", *(f"{s:.1f}" for s in shares)]
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
    options = ["--start", "1.1", "--seconds", "0.1", "--metrics-every", "1000", "--images", "1", "--guard", "1.5", "--size", "640x640"]
    options += ["--headset", "flat-90", "--fill", "interpolate", "--against", "", "--quiet", "--out", str(out)]
    subprocess.run([sys.executable, "-m", "hmdwarp", "replay", "look-around", *options], check=True)
    strip = Image.open(out / "images" / "frame-000000-left.png")
    late, warped, truth, error = (strip.crop((k * strip.width // 4, 0, (k + 1) * strip.width // 4, strip.height)) for k in range(4))
    ordered = Image.new("RGB", strip.size, "white")
    for k, panel in enumerate((truth, late, warped, error)):
        ordered.paste(panel, (k * strip.width // 4, 0))
    ordered.thumbnail((1920, 1920), Image.Resampling.LANCZOS)
    ordered.save(ROOT / "docs" / "opening.png", optimize=True)


def quality(folder: Path) -> None:
    """The tables of README.md and docs/results.md that compare pictures."""
    readme, results = ROOT / "README.md", ROOT / "docs" / "results.md"
    by_warp = {}
    for guard in ("1", "1.5"):
        for trace in ("look-around", "walk"):
            for warp in WARPS:
                by_warp[guard, trace, warp] = run(folder, trace, "--latency", "200", "--warp", warp, "--guard", guard)
    any_run = next(iter(by_warp.values()))
    machine = f"{any_run['machine']['gl_renderer']}, {any_run['machine']['cpu_count']} cores"
    rows = [((trace, f"`{warp}`"), by_warp["1.5", trace, warp]) for trace in ("look-around", "walk") for warp in WARPS]
    replace(readme, "results", f"{table(('recording', 'warp'), rows)}\n\nMeasured on {machine}.")
    replace(results, "machine", f"hmdwarp {any_run['hmdwarp']}; {machine}; {any_run['machine']['gl_version']}.")
    for guard in ("1", "1.5"):
        rows = [((trace, f"`{warp}`"), by_warp[guard, trace, warp]) for trace in ("look-around", "walk") for warp in WARPS]
        replace(results, f"guard {guard}", table(("recording", "warp"), rows))
    rows = [
        ((latency, f"`{warp}`"), run(folder, "look-around", "--latency", latency, "--warp", warp, "--guard", "1.5"))
        for latency in ("200", "400", "800")
        for warp in ("none", "rotation", "forward", "backward")
    ]
    replace(results, "latency", table(("latency ms", "warp"), rows))
    rows = [
        ((latency, predict), run(folder, "look-around", "--latency", latency, "--warp", "forward", "--predict", predict))
        for latency in ("200", "400")
        for predict in ("none", "constant_velocity")
    ]
    replace(results, "prediction", table(("latency ms", "predict"), rows))


def speed(_: Path) -> None:
    """The output of the benchmark against OpenCV; wants a machine that does nothing else."""
    told = subprocess.run([sys.executable, str(ROOT / "tests" / "bench_quick.py")], check=True, capture_output=True, text=True).stdout
    replace(ROOT / "docs" / "results.md", "speed", f"```text\n{told.rstrip()}\n```")


def hard_cases(_: Path) -> None:
    """The table of docs/hard-cases.md, from the docstrings of the cases."""
    sys.path.insert(0, str(ROOT / "tests"))
    import hard_cases.all_cases  # noqa: F401 (files them)
    from hard_cases.registry import markdown

    replace(ROOT / "docs" / "hard-cases.md", "hard-cases", markdown())


PARTS = {"hard-cases": hard_cases, "picture": opening_picture, "quality": quality, "speed": speed}


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        for part in sys.argv[1:] or PARTS:
            PARTS[part](Path(name))


if __name__ == "__main__":
    main()
