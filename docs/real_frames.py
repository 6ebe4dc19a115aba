"""Measure warps, repairs and fills on ten real frames with depth.

    python docs/real_frames.py fetch [FOLDER]   fetch the frames, by default into the cache folder
    python docs/real_frames.py [FOLDER]         print the figures, as JSON for `make docs`

The frames are those of a public repository under the MIT licence. They are never part of this one.
Without FOLDER they are looked for in HMDWARP_RGBD, then in the cache folder.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
import os
import sys
import time
import timeit
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from flip_evaluator import evaluate
from numpy.typing import NDArray
from pages import markdown

from hmdwarp import InputError, Warper
from hmdwarp.client.fills import fills
from hmdwarp.image import usable_fills, usable_warps
from hmdwarp.metrics import psnr
from hmdwarp.sources import sequences
from hmdwarp.sources.repairs import parse_repairs
from hmdwarp.sources.sequences import Sequence, SequenceOptions

COMMIT = "e62d9cd1f95bab337fb4251608543b71d004c420"
SOURCE = f"https://raw.githubusercontent.com/gaoxiang12/slambook2/{COMMIT}"
VARIABLE = "HMDWARP_RGBD"
REPAIRS = ("none", "edges", "complete", "edges+complete")
ROUNDS = 15


@attrs.frozen
class RealFrames:
    """One set of frames: where it comes from, and what is known of its camera."""

    name: str
    place: str  # in the repository
    depths: str  # how names of its depth pictures end
    options: SequenceOptions
    # Pixels of the rim that rectification left white: neither seen nor judged.
    rim: int
    # Frames, from which and to which is warped.
    pairs: tuple[tuple[int, int], ...]
    digest: str  # SHA-256 of all its files in the order of files()

    def files(self) -> list[str]:
        """Return the names of its files, in its folder."""
        kinds = (("color", "png"), ("depth", self.depths))
        return [*(f"{kind}/{number}.{ending}" for kind, ending in kinds for number in range(1, 6)), "pose.txt"]


_CAMERA = SequenceOptions(intrinsics=sequences.parse_intrinsics("518,519,325.5,253.5"), depth_scale=1 / 1000)
_ICL = SequenceOptions(intrinsics=sequences.parse_intrinsics("481.2,-480,319.5,239.5"), depth_scale=1 / 5000)
_DIGESTS = (
    "88095d49b03eecd3460e30f39d09c90cb295c4f0aae7dcdd73448332c9fc136c",
    "64d75e6cb6a57f9bac6b13f1b6085bfa06382ad8fc94ba8ca411be09eb119b61",
)
SETS = (
    RealFrames("camera", "ch5/rgbd", "pgm", _CAMERA, 12, ((4, 5), (3, 4)), _DIGESTS[0]),
    RealFrames("icl", "ch12/dense_RGBD/data", "png", _ICL, 0, ((4, 5),), _DIGESTS[1]),
)


def cache_folder() -> Path:
    """Return the folder of this user where fetched frames lie."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hmdwarp" / "rgbd"


def folder_of(given: str | None = None) -> Path | None:
    """Return the folder with both sets, None where there is none."""
    places = [given] if given else [os.environ.get(VARIABLE), str(cache_folder())]
    found = (Path(place) for place in places if place)
    return next((place for place in found if all((place / each.name / "pose.txt").is_file() for each in SETS)), None)


def why_absent() -> str:
    """Return what to do for the frames."""
    return f"the ten real frames are not here: python docs/real_frames.py fetch, or {VARIABLE}=FOLDER"


def fetch(folder: Path) -> None:
    """Fetch all files that are not there yet, 6 MB.

    Raises: SystemExit for files that are not those of the commit.
    """
    for frames in SETS:
        for name in frames.files():
            path = folder / frames.name / name
            if not path.is_file():
                path.parent.mkdir(parents=True, exist_ok=True)
                with urllib.request.urlopen(f"{SOURCE}/{frames.place}/{name}", timeout=60) as answer:
                    path.write_bytes(answer.read())
        if digest_of(folder / frames.name, frames) != frames.digest:
            raise SystemExit(f"{folder / frames.name}: not the files of commit {COMMIT[:7]}; delete it, and try again")


def digest_of(folder: Path, frames: RealFrames) -> str:
    """Return the SHA-256 of all files of a set."""
    return hashlib.sha256(b"".join((folder / name).read_bytes() for name in frames.files())).hexdigest()


def measured(folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Return rows of figures for each set: one for each warp and repair."""
    found: dict[str, list[dict[str, Any]]] = {}
    for frames in SETS:
        texts, rows = different_repairs(folder, frames), found.setdefault(frames.name, [])
        for warp in usable_warps():
            ratios = time_ratios(folder, frames, warp, texts)
            for repair in texts:
                rows.append(figures_of(folder, frames, warp, repair) | {"time_ratio": ratios[repair]})
                print(frames.name, json.dumps(rows[-1]), file=sys.stderr, flush=True)
    return found


def time_ratios(folder: Path, frames: RealFrames, warp: str, texts: list[str]) -> dict[str, float]:
    """Return the time of a warp with each repair over that of `iterative` without: repair and warp.

    All take turns, and the least time of each counts: what else the machine does makes none faster.
    """
    sequence = sequences.open(folder / frames.name, frames.options)
    late, now = (sequence.frames[number - 1] for number in frames.pairs[0])
    pictures = without_rim(late.colour, frames.rim), late.depth_m, late.view, now.view
    chosen = {("iterative", "none"), *((warp, text) for text in texts)}
    least = dict.fromkeys(sorted(chosen), float("inf"))
    with ExitStack() as stack:
        warpers = {
            pair: stack.enter_context(Warper(late.size, warp=pair[0], fill="none", repair=pair[1])) for pair in least
        }
        for _, (pair, warper) in itertools.product(range(ROUNDS), warpers.items()):
            took = warper.warp(*pictures).time_ms
            least[pair] = min(least[pair], sum(took.get(stage, 0) for stage in ("repair", "warp", "carry")))
    return {text: least[warp, text] / least["iterative", "none"] for text in texts}


def figures_of(folder: Path, frames: RealFrames, warp: str, repair: str) -> dict[str, Any]:
    """Return the figures of one warp, with one repair and every fill: means over the pairs."""
    sequence = sequences.open(folder / frames.name, frames.options)
    inside = (slice(frames.rim, -frames.rim or None),) * 2
    rows: list[tuple[float, float]] = []
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in fills_of_one_picture()}
    with_fill = {name: Warper(sequence.frames[0].size, warp=warp, fill=name, repair=repair) for name in found}
    for late, now in frames.pairs:
        given, truth = sequence.frames[late - 1], sequence.frames[now - 1]
        colour, depth = without_rim(given.colour, frames.rim), given.depth_m
        wanted = np.ascontiguousarray(truth.colour[inside])
        for name, warper in with_fill.items():
            out = warper.warp(colour, depth, given.view, truth.view)
            shown = np.ascontiguousarray(out.colour[inside])
            found[name].append((psnr(shown, wanted), _flip(shown, wanted, truth.fov.pixels_per_degree(truth.size))))
            if name == "none":
                covered = out.coverage[inside] > 0
                covered_db = psnr(shown[covered][None], wanted[covered][None])
                rows.append((covered_db, float(1 - covered.mean())))
    for warper in with_fill.values():
        warper.close()
    covered_db, hole_share = map(float, np.mean(rows, axis=0))
    by_fill = {name: list(map(float, np.mean(values, axis=0))) for name, values in found.items()}
    return {"warp": warp, "repair": repair, "covered_db": covered_db, "hole_share": hole_share, "by_fill": by_fill}


def _flip(shown: NDArray[np.uint8], truth: NDArray[np.uint8], pixels_per_degree: float) -> float:
    reference, test = (picture.astype(np.float32) / np.float32(255) for picture in (truth, shown))
    how: dict[str, Any] = {"inputsRGB": True, "applyMagma": False, "computeMeanError": False}
    error = evaluate(reference, test, "LDR", parameters={"ppd": float(pixels_per_degree)}, **how)[0]
    return float(error.mean(dtype=np.float64))


def without_rim(colour: NDArray[np.uint8], rim: int) -> NDArray[np.uint8]:
    """Return the colour with coverage: none on the rim."""
    coverage = np.zeros(colour.shape[:2], np.uint8)
    coverage[rim : len(coverage) - rim, rim : coverage.shape[1] - rim] = 255
    return np.dstack([colour, coverage])


def fills_of_one_picture() -> list[str]:
    """Return the fills that a single picture is enough for: `none` first."""
    names = [name for name in usable_fills() if not fills.get(name).remembers]
    return ["none", *(name for name in names if name != "none")]


def table(rows: list[dict[str, Any]], chosen: tuple[str, ...] = ()) -> str:
    """Return every warp x repair x fill of one set; the best figures are bold. chosen: fills."""
    rows = [row | {"by_fill": {name: row["by_fill"][name] for name in chosen or row["by_fill"]}} for row in rows]
    fills_of_rows = list(rows[0]["by_fill"])
    heads = ["warp", "repair", "PSNR dB of covered", "holes %", "time"]
    heads += [f"`{name}`: dB, FLIP" for name in fills_of_rows]
    lines = []
    pairs = [pair for row in rows for pair in row["by_fill"].values()]
    best_db, best_flip = max(db for db, _ in pairs), min(error for _, error in pairs)

    def cell(db: float, error: float) -> str:
        words, best = (f"{db:.2f}", f"{error:.3f}"), (db == best_db, error == best_flip)
        return ", ".join(f"**{word}**" if is_best else word for word, is_best in zip(words, best, strict=True))

    for row in rows:
        figures = [f"{row['covered_db']:.2f}", f"{100 * row['hole_share']:.1f}", f"{row['time_ratio']:.1f}"]
        cells = [f"`{row['warp']}`", f"`{row['repair']}`", *figures, *(cell(*pair) for pair in row["by_fill"].values())]
        lines.append(cells)
    return markdown(heads, lines, texts=2)


def different_repairs(folder: Path, frames: RealFrames) -> list[str]:
    """Return the repairs of which none leaves the same depth as one before it."""
    sequence, seen = sequences.open(folder / frames.name, frames.options), {}
    for text in REPAIRS:
        chain = parse_repairs(text)
        left = b"".join(chain.run(*each).inverse_depth.tobytes() for each in depth_of(sequence, frames.rim))
        seen.setdefault(left, text)
    return list(seen.values())


def depth_of(sequence: Sequence, rim: int) -> Iterator[tuple[NDArray[np.float32], NDArray[np.float32]]]:
    """Yield sRGB colour of 0 to 1 and inverse depth of each frame, as a repair takes them."""
    for frame in sequence.frames:
        depth = frame.depth_m.copy()
        depth[without_rim(frame.colour, rim)[..., 3] == 0] = 0
        with np.errstate(divide="ignore"):
            inverse = np.where(depth > 0, 1 / depth, np.nan)
        yield frame.colour.astype(np.float32) / 255, inverse.astype(np.float32)


def repairs_table(folder: Path) -> str:
    """Return what each repair takes and does on the frames, and how good its guesses are.

    Guesses are judged where depth was measured and is hidden from the repair: by the gaps of
    another frame of the camera. One is right within 10 % of the true inverse depth + 0.05 /m.
    """
    heads = ("repair", "ms", "depth taken out %", "depth guessed %", "camera: right %", "icl: right %", "sure of it %")
    lines = []
    camera, icl = (list(depth_of(sequences.open(folder / frames.name, frames.options), frames.rim)) for frames in SETS)
    gaps = [np.isnan(inverse) for _, inverse in camera]
    for text in REPAIRS[1:]:
        chain = parse_repairs(text)
        lost, guessed = [], []
        for colour, inverse in camera:
            found = chain.run(colour, inverse)
            lost.append((~np.isnan(inverse) & (found.confidence < 1)).mean())
            guessed.append(((found.confidence > 0) & (found.confidence < 1)).mean())
        right, sure = [], []
        for which in (camera, icl):
            hits, confidences = [], []
            for number, (colour, inverse) in enumerate(which):
                hidden = gaps[(number + 2) % len(gaps)] & ~np.isnan(inverse)
                found = chain.run(colour, np.where(hidden, np.float32(np.nan), inverse))
                off = np.abs(found.inverse_depth - inverse)[hidden]
                hits.append(off <= 0.1 * (inverse[hidden] + 0.05))
                confidences.append(found.confidence[hidden])
            right.append(np.concatenate(hits).mean())
            sure.append(np.concatenate(confidences).mean())
        shares = [f"{100 * float(np.mean(values)):.1f}" for values in (lost, guessed)]
        if "complete" in text:
            shares += [f"{100 * value:.1f}" for value in (*right, float(np.mean(sure)))]
        shares += [""] * (len(heads) - 2 - len(shares))
        # The least processor time of many: what else the machine does counts little.
        timer = timeit.Timer(functools.partial(chain.run, *camera[0]), timer=time.process_time)
        lines.append([f"`{text}`", f"{1e3 * min(timer.repeat(ROUNDS, number=1)):.0f}", *shares])
    return markdown(heads, lines)


def main() -> None:
    fetching, *rest = sys.argv[1:] or [""]
    if fetching == "fetch":
        fetch(Path(rest[0]) if rest else cache_folder())
    elif (folder := folder_of(fetching or None)) is None:
        raise InputError(why_absent())
    else:
        print(json.dumps(measured(folder)))


if __name__ == "__main__":
    main()
