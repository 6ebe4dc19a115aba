"""A table for docs/results-warps.md: what is left of a picture that is warped again and again.

Each step warps what the step before showed, colour and depth, to the head's pose one refresh later.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.client import CLIENT_DEPTH, PassInputs, ShownPicture, parse_fills, parse_warp
from hmdwarp.client.warps import Output
from hmdwarp.colour import srgb_from_linear
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Pose, View, WarpMap
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, Gpu, allocate, download, flip_rows
from hmdwarp.headsets import load_headset
from hmdwarp.metrics import near_discontinuity, psnr_db
from hmdwarp.poses import load_trace
from hmdwarp.run.replay_setup import placed
from hmdwarp.scenes import Scene, load_scene
from hmdwarp.sources.server import Server

RECORDINGS = ("look-around", "walk")
SIZE = (480, 600)
STEPS, REFRESH_NS = 30, 16_666_667  # half a second at 60 Hz
STARTS_S = (2.0, 4.0)
ROUNDS = 30  # of the two kinds of sample by turns, for the CPU time; the least counts
RESAMPLES = ("bilinear", "catmull-rom")
# rotation is exact for a head that turns alone; so that is the head it gets.
WARPS = {"rotation": True, "iterative": False, "search": False, "backward": False}
BORDER = 1.0  # pixels inside a picture that a place must lie to count as seen there
SAME_PLACE = 0.03, 0.02  # inverse depths may differ by the one times (the expected one + the other, 1/m)

Mask = NDArray[np.bool_]
Picture = NDArray[np.float32]


@attrs.frozen(eq=False)
class Truth:
    """What a renderer without latency shows at one pose, bottom row first."""

    view: View
    colour: Picture  # (h, w, 3), sRGB
    inverse_depth: Picture  # (h, w)


def views_of(scene: Scene, recording: str, start_s: float, *, turns_only: bool) -> list[View]:
    """Return the left eye's views at STEPS + 1 refreshes."""
    headset, (track, _) = load_headset("rift-dk1"), placed(load_trace(recording).track, scene)
    times = track.start_ns + round(start_s * 1e9) + REFRESH_NS * np.arange(STEPS + 1)
    eyes = [headset.views(track.at(int(now)).pose)[0] for now in times]
    if not turns_only:
        return eyes
    return [View(Pose(eyes[0].pose.position_m, eye.pose.orientation_xyzw), eye.fov) for eye in eyes]


def truths_of(server: Server, views: Sequence[View]) -> list[Truth]:
    """Draw every view."""
    target = server.acquire(SIZE)
    drawn = []
    for view in views:
        eye = server.draw(view, SIZE, target)
        colour, depth = flip_rows(download(eye.colour)), flip_rows(download(eye.inverse_depth))
        drawn.append(Truth(view, srgb_from_linear(colour[..., :3].astype(np.float32)), depth.copy()))
    return drawn


def visible_all_along(truths: Sequence[Truth]) -> Mask:
    """Return (h, w): what the last pose shows and every earlier one showed too."""
    last, seen = truths[-1], np.ones(SIZE[::-1], bool)
    centres = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in SIZE)), axis=-1)
    depth = np.maximum(last.inverse_depth, 0).astype(np.float64)
    for truth in truths[:-1]:
        places, expected, _ = WarpMap.between(last.view, SIZE, truth.view, SIZE).apply(centres, depth)
        inside = ((places >= BORDER) & (places < np.array(SIZE) - BORDER)).all(axis=-1)
        x, y = np.moveaxis(np.where(inside[..., None], places, 0).astype(int), -1, 0)
        share, floor = SAME_PLACE
        seen &= inside & (np.abs(truth.inverse_depth[y, x] - expected) <= share * (expected + floor))
    return seen


class Chain:
    """A warp that goes on from what it showed."""

    def __init__(self, gpu: Gpu, server: Server, warp: str) -> None:
        choice = parse_warp(warp)
        self._gpu, self._server = gpu, server
        self._warp = choice.entry(gpu, SIZE, SIZE, choice.settings, Output(depth=True))
        self._own = allocate(gpu.gl, SIZE, SCALAR) if CLIENT_DEPTH in choice.entry.reads else None
        self._pictures = [(Canvas(gpu.gl, SIZE), allocate(gpu.gl, SIZE, SCALAR)) for _ in range(2)]

    def run(self, first: EyeImage, through: Sequence[View]) -> Picture:
        """Return (h, w, 4) what the last view shows, linear, bottom row first."""
        image = first
        for step, view in enumerate(through):
            canvas, depth = self._pictures[step % 2]
            if self._own is not None:
                self._server.draw_depth(view, SIZE, self._own)
            self._warp.run_with_depth(PassInputs(image, view, client_inverse_depth=self._own), canvas, depth)
            self._gpu.barrier()
            image = EyeImage(view, canvas.texture, depth)
        return flip_rows(download(image.colour)).astype(np.float32)

    def seconds(self, first: EyeImage, view: View) -> float:
        """Return the CPU time of one warp in all threads, which other programs hardly change."""
        canvas, depth = self._pictures[0]
        self._gpu.gl.finish()
        started = time.process_time()
        self._warp.run_with_depth(PassInputs(first, view, client_inverse_depth=self._own), canvas, depth)
        self._gpu.gl.finish()
        return time.process_time() - started

    def close(self) -> None:
        """Free everything."""
        self._warp.close()
        for canvas, depth in self._pictures:
            canvas.release()
            depth.release()
        if self._own is not None:
            self._own.release()


def remembered(gpu: Gpu, first: EyeImage, through: Sequence[View]) -> Picture:
    """Return (h, w, 4) what `memory` alone shows at the last view of the first picture.

    From the second refresh on empty pictures arrive, from where the first was drawn, so that they
    are not kept: every pixel comes out of the memory.
    """
    (choice,) = parse_fills("memory")
    fill = choice.entry(gpu, SIZE, SIZE, choice.settings, None, depth_read=False)
    nothing, into = (ShownPicture(Canvas(gpu.gl, SIZE), None) for _ in range(2))
    nothing.colour.clear()
    blank, far = allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR)
    blank.write(bytes(8 * SIZE[0] * SIZE[1]), alignment=1)
    far.write(np.full(SIZE[::-1], -1, np.float32).tobytes(), alignment=1)
    fill.run(PassInputs(first, first.view), nothing, into)
    for step, view in enumerate(through):
        arrived = EyeImage(attrs.evolve(first.view), blank, far, drawn_ns=first.drawn_ns + (step + 1) * REFRESH_NS)
        fill.run(PassInputs(arrived, view), nothing, into)
        gpu.barrier()
    shown = flip_rows(download(into.colour.texture)).astype(np.float32)
    fill.close()
    for thing in (nothing.colour, into.colour, blank, far):
        thing.release()
    return shown


@attrs.frozen
class Left:
    """What is left at the last pose."""

    psnr_db: float
    surfaces_db: float  # farther than two pixels from a jump of depth
    kept: float  # share of what was visible all along that is still covered

    @classmethod
    def of(cls, shown: Picture, truth: Truth, visible: Mask) -> Left:
        """Compare a linear picture with the truth."""
        colour, covered = srgb_from_linear(shown[..., :3]), visible & (shown[..., 3] > 0)
        surfaces = covered & ~near_discontinuity(truth.inverse_depth)
        figures = (psnr_db(colour[mask][None], truth.colour[mask][None]) for mask in (covered, surfaces))
        return cls(*figures, float(covered.sum() / visible.sum()))

    @classmethod
    def mean(cls, several: Sequence[Left]) -> Left:
        """Return the mean of each figure."""
        return cls(*np.mean([attrs.astuple(one) for one in several], axis=0))


@attrs.frozen(eq=False)
class Stretch:
    """STEPS refreshes of a recording."""

    first: EyeImage
    through: list[View]
    last: Truth
    visible: Mask

    def left(self, shown: Picture) -> Left:
        """Compare what is shown at the end with the truth."""
        return Left.of(shown, self.last, self.visible)


def stretches(server: Server, recording: str, *, turns_only: bool) -> list[Stretch]:
    """Draw each stretch of a recording."""
    drawn = []
    for start_s in STARTS_S:
        first, *rest = views_of(server.scene, recording, start_s, turns_only=turns_only)
        truths = truths_of(server, [first, *rest])
        drawn.append(Stretch(server.draw(first, SIZE), rest, truths[-1], visible_all_along(truths)))
    return drawn


def _row(recording: str, what: str, resample: str, once: Left, thirty: Left, times: str) -> str:
    figures = f"{once.psnr_db:.2f} | {thirty.psnr_db:.2f} | {thirty.surfaces_db:.2f} | {100 * thirty.kept:.0f}"
    return f"| {recording} | {what} | {resample} | {figures} | {times} |"


def _rows_of_warp(gpu: Gpu, server: Server, recording: str, warp: str) -> list[str]:
    several = stretches(server, recording, turns_only=WARPS[warp])
    chains = {name: Chain(gpu, server, f"{warp}:resample={name}") for name in RESAMPLES}
    rows = []
    for name, chain in chains.items():
        once = Left.mean([one.left(chain.run(one.first, one.through[-1:])) for one in several])
        thirty = Left.mean([one.left(chain.run(one.first, one.through)) for one in several])
        rows.append((name, once, thirty))
    first, view = several[0].first, several[0].through[-1]
    took = [[chains[name].seconds(first, view) for name in RESAMPLES] for _ in range(ROUNDS)]
    least = np.min(took, axis=0)
    for chain in chains.values():
        chain.close()
    label = f"`{warp}`, turns alone" if WARPS[warp] else f"`{warp}`"
    return [
        _row(recording, label, name, once, thirty, f"{ms / least[0]:.2f}x")
        for (name, once, thirty), ms in zip(rows, least, strict=True)
    ]


def _row_of_memory(gpu: Gpu, server: Server, recording: str) -> str:
    several = stretches(server, recording, turns_only=False)
    once, thirty = (
        Left.mean([one.left(remembered(gpu, one.first, one.through[-steps:])) for one in several])
        for steps in (1, STEPS)
    )
    return _row(recording, "fill `memory` alone", "bilinear", once, thirty, "")


def table() -> str:
    """Return one line for each recording, warp and kind of sample, and for the memory."""
    head = "| recording | warp | sample | one warp, dB | thirty, dB | away from edges, dB | covered % | CPU time |"
    lines = [head, "| --- | --- | --- |" + " ---: |" * 5]
    with Gpu() as gpu:
        server = Server(gpu, load_scene("room"))
        for recording in RECORDINGS:
            for warp in WARPS:
                lines += _rows_of_warp(gpu, server, recording, warp)
            lines.append(_row_of_memory(gpu, server, recording))
        server.close()
    return "\n".join(lines)
