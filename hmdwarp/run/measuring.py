"""Comparison of every n-th shown picture with a renderer without latency.

Around where the eye looks its PSNR too, and how late the gaze that frames had was.
"""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.compensator import Compensator, EyeResult
from ..colour import picture_from_linear
from ..frames import EyeImage
from ..frames.layers import PICTURE
from ..geometry import View, gaze_tangent, looking
from ..gpu.textures import download, flip_rows
from ..metrics import Compared, QualityJob, QualityPool, psnr
from ..pipeline.loop import Refresh
from ..pipeline.recorded_source import RecordedRenderer
from ..pipeline.remote_source import NoTruth
from ..pipeline.sizes import build_plan_for, plan_against
from .replay_setup import ReplayRun
from .side_by_side import clips_of
from .truth import MOST_BANDS, WholePictures, coverage, draw_truth, is_measured, shown_picture

# Degrees from the gaze: the fovea and what is nearly as sharp (Strasburger, Rentschler and Jüttner
# 2011, Peripheral vision and pattern recognition: a review).
NEAR_DEG = 5.0


@attrs.define
class NearGaze:
    """Figures of measured pictures whose gaze is known, or asked for."""

    looks_ahead: bool = False  # whether frames without a gaze are drawn for one straight ahead
    _psnr_db: list[float] = attrs.field(factory=list)
    _off_deg: list[float] = attrs.field(factory=list)

    def add(self, now: Compared, shown: View, rendered: View) -> None:
        """Take a picture in. shown: of the eye, with its gaze at that instant. rendered: drawn."""
        near = flip_rows(near_gaze(shown, now.shown.shape[1::-1]))
        if near.any():  # as a picture one pixel high
            self._psnr_db.append(psnr(now.shown[near][None], now.truth[near][None]))
        if rendered.gaze is not None or shown.gaze is None or self.looks_ahead:  # else, as of recordings, not known
            off = float(_in_world(shown) @ _in_world(rendered))
            self._off_deg.append(math.degrees(math.acos(min(1.0, off))))

    def entry(self) -> dict[str, Any]:
        """Return the `gaze` of summary.json.

        psnr_db: mean over pictures, within within_deg of the gaze. off_deg: from the gaze that a
        frame was drawn for to that when it is seen, in the world; None where that is never known.
        """
        if not self._off_deg and not self._psnr_db:
            return {}
        off = self._off_deg and {f"p{share}": float(np.percentile(self._off_deg, share)) for share in (50, 95)}
        psnr = math.fsum(self._psnr_db) / len(self._psnr_db) if self._psnr_db else None
        return {"gaze": {"within_deg": NEAR_DEG, "psnr_db": psnr, "off_deg": off or None}}


def near_gaze(view: View, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Return (h, w), the bottom row first: which pixels lie near the gaze."""
    ray = np.array([*gaze_tangent(view), -1.0])
    rays = view.rays(size)
    cosine = rays @ (ray / np.linalg.norm(ray)) / np.linalg.norm(rays, axis=-1)
    return np.asarray(cosine >= math.cos(math.radians(NEAR_DEG)))


def _in_world(view: View) -> NDArray[np.float64]:
    ray = view.pose.rotation_matrix @ np.array([*gaze_tangent(view), -1.0])
    return np.asarray(ray / np.linalg.norm(ray))


# The run's own warp; those that it is compared with have 1, 2 and so on.
MAIN = 0
Key = tuple[int, int, int]  # (refresh, eye, which warp)


class Probe:
    """Read pictures back: draw the truth for the shown views and submit both for measuring.

    The picture is measured as the eye sees it, before the lens. A warp that is fused with the lens
    makes no such picture, so the same warp without the lens runs for it; its time is not counted.
    The truth of a display that lights up row by row is drawn in bands. Flicker needs the refresh
    before a measured one too, so that one is drawn and read as well, but not measured.
    """

    def __init__(self, setup: ReplayRun, pool: QualityPool, keep_every: int | None) -> None:
        self._setup, self._pool, self._keep_every = setup, pool, keep_every
        self._every = setup.options.metrics_every
        self._unfused = self._without_lens()
        self._against = [setup.compensator(plan_against(setup.options, *pair)) for pair in setup.options.compared]
        # Rates all pictures; None where the options do not ask for it.
        self.clips = clips_of(setup) if setup.options.jod_s else None
        self._whole = WholePictures(setup.server)
        self._before: dict[tuple[int, int], tuple[int, Compared]] = {}
        self._empty: dict[str, list[float]] = {}
        # Pictures that were to be measured.
        self.without_truth = 0
        # Of each comparison, by refresh and eye.
        self.against_ms: list[dict[tuple[int, int], tuple[tuple[str, float], ...]]] = [{} for _ in self._against]
        # Of an eye whose frames were not sent, by refresh: the share of its pixels that the warp
        # left empty, and its PSNR where what it should see was recorded.
        self.second_eye: dict[str, dict[int, float]] = {"hole_share": {}, "psnr_db": {}}
        self.near_gaze = NearGaze(setup.options.fovea is not None)
        if setup.options.scanout_ms:
            how = "follows it row by row" if setup.plans[0].scanout else "shows all rows as in its middle"
            setup.notes.append(
                f"The display scans out for {setup.options.scanout_ms:g} ms; warp '{setup.options.warp}' {how}. The "
                f"truth is drawn in up to {MOST_BANDS} bands, each for its own instant; holes and flicker are told as "
                "in its middle."
            )

    def _without_lens(self) -> Compensator | None:
        setup = self._setup
        if not setup.plans[0].fused:
            return None
        setup.notes.append(
            "Warp and lens are one pass: quality was measured on the same warp without the lens, whose time is not "
            "counted."
        )
        alone = attrs.evolve(setup.options, fused=False, lens="none", fill="none")
        return setup.compensator(build_plan_for(alone, setup.source.headset, setup.source.scene))

    def wants(self, number: int) -> bool:
        """Return whether refresh `number` is measured, precedes a measured one, or is in a clip."""
        return self.clips is not None or is_measured(number, self._every) or is_measured(number + 1, self._every)

    def read(self, number: int, refresh: Refresh) -> None:
        """Read back the eyes of refresh `number`, and submit them if it is a measured one.

        An eye that no frames were sent for has holes alone, and a PSNR.
        """
        if len(refresh.eyes) > self._setup.source.kind.eyes and is_measured(number, self._every):
            second, server = self._setup.source.kind.eyes, self._setup.server
            result = self._before_lens(refresh, second)
            self.second_eye["hole_share"][number] = _hole_share(coverage(result))
            if isinstance(server, RecordedRenderer) and server.right is not None:
                truth = draw_truth(server.right, refresh.inputs[second], self._setup.sizes.shown, depth=False)
                self.second_eye["psnr_db"][number] = psnr(shown_picture(result), truth.picture)
        for eye in range(min(len(refresh.eyes), self._setup.source.kind.eyes)):
            rendered = refresh.frame.eyes[eye]
            # The predecessor of a measured refresh is read for flicker only.
            measured = is_measured(number, self._every)
            try:
                truth = draw_truth(self._setup.server, refresh.inputs[eye], self._setup.sizes.shown, depth=measured)
            except NoTruth:
                self.without_truth += measured
                continue
            picture, depth = truth.picture, truth.inverse_depth
            result = self._before_lens(refresh, eye)
            job = self._job(number, eye, MAIN, rendered, result, picture, depth)
            if depth is not None:
                for name, canvas in (("warp", None), *result.filled):
                    alpha = coverage(result) if canvas is None else download(canvas.texture)[..., 3]
                    self._empty.setdefault(name, []).append(_hole_share(alpha))
            others = [
                self._read_comparison(which, against, (number, eye), refresh, picture, depth)
                for which, against in enumerate(self._against, 1)
            ]
            if job is not None:
                if refresh.head.gaze is not None or self._setup.options.fovea is not None:
                    (shown,) = looking([result.view], refresh.head.gaze)
                    self.near_gaze.add(job.now, shown, rendered.view)
                keep = self._keep_every is not None and number // self._every % self._keep_every == 0
                job = attrs.evolve(job, beside=tuple(filter(None, others)))
                self._setup.hand_in(self._pool, (number, eye, MAIN), job, keep=keep)

    def _read_comparison(
        self,
        which: int,
        against: Compensator,
        where: tuple[int, int],
        refresh: Refresh,
        truth: NDArray[np.uint8],
        depth: NDArray[np.float32] | None,
    ) -> tuple[str, NDArray[np.uint8], NDArray[np.uint8]] | None:
        """Measure the comparison warp; return its name, picture and FLIP map.

        It does not compensate effects: its rendered picture has all of them drawn in.
        """
        number, eye = where
        inputs = self._whole.inputs(self._setup.loop, refresh, against.plan)[eye]
        other = against.run(inputs)
        self.against_ms[which - 1][where] = tuple(self._setup.target.gpu.timer.collect())
        job = self._job(number, eye, which, inputs.rendered, other, truth, depth)
        if job is None:
            return None
        levels = 255 * self._setup.hand_in(self._pool, (number, eye, which), job).flip_map
        return method_name(*self._setup.options.compared[which - 1]), job.now.shown, np.rint(levels).astype(np.uint8)

    def filled_shares(self) -> dict[str, float]:
        """Return the share of pixels that each fill of the chain filled, and the rest ("empty")."""
        if not self._empty:
            return {}
        left = {name: sum(shares) / len(shares) for name, shares in self._empty.items()}
        names = list(left)
        filled = {name: left[before] - left[name] for before, name in zip(names, names[1:], strict=False)}
        return {**filled, "empty": left[names[-1]]}

    def _before_lens(self, refresh: Refresh, eye: int) -> EyeResult:
        if self._unfused is None:
            return refresh.eyes[eye]
        made = self._unfused.run(refresh.inputs[eye])
        self._setup.target.gpu.timer.collect()
        return made

    def _job(
        self,
        number: int,
        eye: int,
        which: int,
        rendered: EyeImage,
        result: EyeResult,
        truth: NDArray[np.uint8],
        truth_inverse_depth: NDArray[np.float32] | None,
    ) -> QualityJob | None:
        """Return what is to be measured; None for a refresh that only flicker and clips need."""
        now = Compared(shown_picture(result), truth, result.view)
        if self.clips is not None:
            self.clips.add(number, eye, which, now)
        before_number, before = self._before.get((eye, which), (None, None))
        self._before[eye, which] = (number, now)
        if truth_inverse_depth is None:
            return None
        late = None
        if which == MAIN and PICTURE[0] not in rendered.left_out:
            late = picture_from_linear(download(rendered.colour))
        return QualityJob(
            now,
            before if before_number == number - 1 else None,
            coverage(result),
            truth_inverse_depth,
            rendered.view,
            rendered.size,
            rendered_picture=late,
            regions=which == MAIN,
        )


def method_name(warp: str, fill: str) -> str:
    """Return "mesh" or "mesh + pyramid"."""
    return warp if fill == "none" else f"{warp} + {fill}"


def _hole_share(alpha: NDArray[np.floating]) -> float:
    return float((alpha == 0).mean())
