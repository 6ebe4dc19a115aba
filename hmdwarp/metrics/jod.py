"""ColorVideoVDP: how much worse people would rate a clip than the truth, in JOD.

10 is the same as the truth, and 1 JOD less means that 75 % of people would prefer the truth.
Source: Mantiuk et al. 2024, ColorVideoVDP: A visual difference predictor for image, video and
display distortions, ACM TOG 43(4); the package cvvdp. Scale: Perez-Ortiz and Mantiuk 2017, A
practical guide and software for analysing pairwise comparison experiments, arXiv:1712.03686.

It brings PyTorch, whose LLVM and that of Mesa's llvmpipe end a process that loads both: clips are
rated in processes of their own, which never open OpenGL.
"""

from __future__ import annotations

import importlib.util
import os
import pickle
import signal
import statistics
import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from ..base import MachineError, import_extra, missing_extra
from .metric import Figure
from .picture_pairs import Compared

EXTRA, MODULES = "jod", {"pycvvdp": "cvvdp", "torch": "torch"}
TRUTH_JOD = 10.0
# Of a headset that does not say: those of the HTC Vive Pro in cvvdp's list of displays, after
# Mehrfard et al. 2019, arXiv:1912.02913.
_PEAK_CD_M2, BLACK_CD_M2 = 133.3, 0.1
# How the columns of a table are called, where clips were rated.
JOD = Figure("jod", "JOD", "", 2, higher_is_better=True)
TRUTH_PREFERRED = Figure("truth_preferred", "truth preferred", "% of people", 0, 100)
_OF_ONE_JOD = statistics.NormalDist().inv_cdf(0.75)


def preferring(jod: float, other_jod: float) -> float:
    """Return the share of people, 0..1, who would prefer what has `jod` to the other."""
    # Thurstone's case V with the deviation at which 1 JOD is 75 %.
    return statistics.NormalDist().cdf((jod - other_jod) * _OF_ONE_JOD)


def ratings_of(row: Mapping[str, Any]) -> dict[str, float]:
    """Return the figures of those columns from a row's `jod`; empty where it was not rated."""
    rated = row.get("jod")
    if rated is None:
        return {}
    return {JOD.name: rated["mean"], TRUTH_PREFERRED.name: rated["truth_preferred"]}


@attrs.frozen
class ShownOn:
    """The display on which people would see the pictures: luminances in cd/m^2."""

    rate_hz: float
    pixels_per_degree: float
    peak_cd_m2: float = _PEAK_CD_M2
    black_cd_m2: float = BLACK_CD_M2


def rate() -> None:
    """Write the JOD of the clip that standard input holds: (display, shown, truth)."""
    on, shown, truth = pickle.load(sys.stdin.buffer)
    with os.fdopen(os.dup(1), "w") as answer:
        os.dup2(2, 1)  # what libraries print
        module, torch = import_extra("pycvvdp", "cvvdp", EXTRA), import_extra("torch", "torch", EXTRA)
        torch.set_num_threads(1)  # so that a run repeats bit for bit
        light = module.vvdp_display_photo_eotf(
            on.peak_cd_m2, contrast=on.peak_cd_m2 / on.black_cd_m2, source_colorspace="sRGB", E_ambient=0
        )
        place = module.vvdp_display_geometry((shown.shape[2], shown.shape[1]), ppd=on.pixels_per_degree)
        with torch.inference_mode():
            metric = module.cvvdp(
                display_photometry=light, display_geometry=place, quiet=True, device=torch.device("cpu")
            )
            found = metric.predict(shown, truth, dim_order="FHWC", frames_per_second=on.rate_hz)[0]
        answer.write(repr(float(found)))


class Clips:
    """Rate runs of neighbouring refreshes as clips of `seconds`, each in a process of its own.

    Where that fails, `failure` says why and nothing is rated any more. Errors: MachineError without
    the package.
    """

    def __init__(self, seconds: float, display: ShownOn) -> None:
        for module, package in MODULES.items():  # loads nothing
            if importlib.util.find_spec(module) is None:
                raise MachineError(missing_extra(package, EXTRA))
        self.display = display
        self.length = max(2, round(seconds * display.rate_hz))  # pictures of a whole clip
        self.failure = ""  # in one line; empty while all went well
        # By (eye, which warp): the pictures of the present clip.
        self._open: dict[tuple[int, int], list[tuple[int, Compared]]] = defaultdict(list)
        # By which warp: (first refresh, pictures, JOD) of each clip of each eye.
        self._clips: dict[int, list[tuple[int, int, float]]] = defaultdict(list)

    def add(self, number: int, eye: int, which: int, pictures: Compared) -> None:
        """Add what an eye saw at refresh `number` and what it should have seen."""
        if self.failure:
            return
        clip = self._open[eye, which]
        clip.append((number, pictures))
        if len(clip) == self.length:
            self._rate(eye, which)

    def finish(self) -> None:
        """Rate what no clip is full with; a single picture is left out where there are others."""
        for (eye, which), clip in self._open.items():
            if len(clip) > 1 or (clip and which not in self._clips):
                self._rate(eye, which)

    def _rate(self, eye: int, which: int) -> None:
        clip, self._open[eye, which] = self._open[eye, which], []
        if self.failure:
            return
        shown, truth = (np.stack([getattr(one, name) for _, one in clip]) for name in ("shown", "truth"))
        done = subprocess.run(
            [sys.executable, "-P", "-c", f"import {__name__} as rating; rating.rate()"],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
            input=pickle.dumps((self.display, shown, truth)), capture_output=True, check=False,
            start_new_session=True,  # Ctrl-C is not for it
        )  # fmt: skip
        if done.returncode == 0:
            self._clips[which].append((clip[0][0], len(clip), float(done.stdout)))
            return
        why = (done.stderr.decode(errors="replace").strip() or f"exit status {done.returncode}").splitlines()[-1]
        if done.returncode < 0:
            why = f"the process that rates ended ({signal.strsignal(-done.returncode)})"
        self.failure = f"JOD could not be measured: {why}; the run goes on without it"

    def entry(self, which: int) -> dict[str, Any]:
        """Return the `jod` of summary.json: of the run and its clips.

        mean: over clips and eyes, by their lengths. truth_preferred: the share of people who would
        prefer the truth.
        """
        clips = self._clips[which]
        mean = sum(count * jod for _, count, jod in clips) / sum(count for _, count, _ in clips)
        by_start: dict[int, list[float]] = defaultdict(list)
        for first, _, jod in clips:
            by_start[first].append(jod)
        return {
            "mean": mean,
            "clips": [{"frame": first, "jod": statistics.fmean(jods)} for first, jods in sorted(by_start.items())],
            "truth_preferred": preferring(TRUTH_JOD, mean),
            "display": attrs.asdict(self.display),
        }
