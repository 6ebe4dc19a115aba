"""A layer that is no picture, registered here alone: drawn once a frame, sent, warped, released."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import attrs
import numpy as np
import pytest
from heads import Eyes, Head

from hmdwarp.client import build_plan
from hmdwarp.client.warps import Warp, warps
from hmdwarp.frames import EyeImage, Needs
from hmdwarp.frames.layers import Layer, layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download
from hmdwarp.link.codec import Coding, pack
from hmdwarp.pipeline import PipelineOptions, PoseRequest, Source, Target
from hmdwarp.run import Run
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server.parts import Part, parts

COUNT, STEP_NS, SIZE = 40, 10_000_000, (64, 48)
FOV = Fov.symmetric(1.2, 1.0)
EYES = Eyes(*((Pose((x, 0, 0)), FOV) for x in (-0.03, 0.03)))
SLIDING = Head(lambda time_ns: Pose((time_ns * 1e-9, 1.6, 1.0)))  # to the right by 1 m/s


@attrs.define(eq=False)
class PointList:
    """(n, 3) metres in the world; how often it was released."""

    points_m: np.ndarray
    released: int = 0


class Points(Layer):
    name, summary = "dots", "points of the world, for both eyes"
    drawn_by, per_frame = "dots", True

    @classmethod
    def bytes(cls, amount, sizes):
        return 12 * amount

    @classmethod
    def textures(cls, data):
        return ()

    @classmethod
    def sent(cls, data):
        return (data.points_m,)

    @classmethod
    def release(cls, data):
        data.released += 1


class PointsPart(Part):
    """Some points before the viewers, others at each instant."""

    name, order = "dots", 200
    made: list[PointList] = []  # noqa: RUF012 (emptied by the fixture)

    def add(self, eye: EyeImage, drawing) -> EyeImage:
        return eye

    def of_frame(self, views: Sequence[View], drawing) -> Mapping[str, Any]:
        rng = np.random.default_rng(drawing.time_ns)
        middle = np.mean([view.pose.position_m for view in views], axis=0) + (0, 0, -2)
        points = middle + rng.normal(size=(drawing.needs["dots"], 3)) / 3
        self.made.append(PointList(points.astype(np.float32)))
        return {"dots": self.made[-1]}


class PointWarp(Warp):
    """A white pixel for each point."""

    name, summary, kind = "dots", "points, each a pixel", "scatter"
    reads = ("rendered.dots",)
    exact_when, gets_wrong, source = "always", "everything else", "this test"

    def prepare(self) -> None:
        pass

    def run(self, inputs, into) -> None:
        into.texture.write(as_pixels(inputs.rendered["dots"].points_m, inputs.shown).tobytes(), alignment=1)

    @classmethod
    def needs(cls, settings) -> Needs:
        return Needs(dots=COUNT)


def as_pixels(points_m: np.ndarray, view: View) -> np.ndarray:
    """rgba16f, bottom row first."""
    left, right, down, up = view.fov.tangents
    in_eye = view.pose.inverse().transform(points_m.astype(np.float64))
    tangent = in_eye[:, :2] / -in_eye[:, 2:]
    x, y = ((tangent - (left, down)) / (right - left, up - down) * SIZE).astype(int).T
    picture = np.zeros((*SIZE[::-1], 4), np.float16)
    picture[y, x] = 1
    return picture


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    for registry, entry in ((layers, Points), (parts, PointsPart), (warps, PointWarp)):
        list(registry)  # all are loaded before the copy, or they would be forgotten with it
        monkeypatch.setattr(registry, "_entries", dict(registry._entries))
        registry.register(entry)
    monkeypatch.setattr(PointsPart, "made", [])


@contextmanager
def running(gpu, warp: str, codec: str = "none", latency_ms: int = 20):
    said = {"scene": "planes", "warp": warp, "fill": "none", "lens": "none", "size": SIZE, "latency_ms": latency_ms}
    options, plan = (
        PipelineOptions(**said, coding=Coding(codec)),
        build_plan((), warp, "none", "none", client_geometry=True),
    )
    run = Run(options, Source(options, load_scene("planes")), None, [plan], plan.needs)
    target = Target(gpu, EYES, 100.0, latency_ms * 1_000_000)
    with run.build(target, PoseRequest(SLIDING, None, SIZE, 1.0, plan.needs)) as made:
        assert plan.layers == ("rendered.dots",) or warp != "dots"
        yield made


@pytest.mark.parametrize("codec", ["none", "h264"])
def test_points_travel_with_frames_and_are_warped(gpu, codec):
    with running(gpu, "dots", codec) as made:
        for number in range(8):
            made.loop.draw(number * STEP_NS)
            refresh = made.loop.show(number * STEP_NS)
        sent = PointsPart.made
        assert len(sent) == 8, "drawn once a frame, not once an eye"
        shown = sent[5]
        for inputs, eye in zip(refresh.inputs, refresh.eyes, strict=True):
            assert inputs.rendered["dots"] is shown
            assert inputs.shown.pose.position_m[0] - inputs.rendered.view.pose.position_m[0] == pytest.approx(0.02)
            wanted = as_pixels(shown.points_m, inputs.shown)
            assert np.array_equal(download(eye.shown.texture)[::-1], wanted)
            assert 0.5 * COUNT < wanted[..., 3].sum() <= COUNT
        expected = 12 * COUNT if codec == "none" else len(pack(shown.points_m))
        assert refresh.transit.size_bytes == expected, "once a frame, not once an eye, and nothing that is not read"
        assert [delivery.released for delivery in sent] == [1] * 5 + [0] * 3, "frames that were shown, and no more"
    assert [delivery.released for delivery in sent] == [1] * 8
