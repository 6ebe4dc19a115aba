"""A layer that is no picture, registered here alone.

Drawn once a frame, sent, read by a warp and released.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np
import pytest

from hmdwarp.client import build_plan
from hmdwarp.client.warps import Warp, warps
from hmdwarp.frames import EyeImage, Needs
from hmdwarp.frames.layers import Layer, layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download
from hmdwarp.link.codec import Coding, pack
from hmdwarp.pipeline import PipelineOptions, PoseRequest, Source, Target
from hmdwarp.poses import Origin, PoseSample
from hmdwarp.run import Run
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server.parts import Part, parts

COUNT, STEP_NS, SIZE = 40, 10_000_000, (64, 48)
FOV = Fov.symmetric(1.2, 1.0)


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
        count = drawing.needs["dots"]
        points = (
            np.mean([view.pose.position_m for view in views], axis=0) + (0, 0, -2) + rng.normal(size=(count, 3)) / 3
        )
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


class TwoEyes:
    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        return tuple(View(world_from_head @ Pose((x, 0, 0)), FOV) for x in (-0.03, 0.03))


class Sliding:
    """A head that moves to the right by 1 m/s."""

    def start(self) -> None:
        pass

    def head_at(self, time_ns: int) -> PoseSample:
        return PoseSample(time_ns, Pose((time_ns * 1e-9, 1.6, 1.0)), Origin.MEASURED)

    def close(self) -> None:
        pass


@pytest.fixture
def registered(monkeypatch):
    for registry, entry in ((layers, Points), (parts, PointsPart), (warps, PointWarp)):
        list(registry)  # all are loaded before the copy, or they would be forgotten with it
        monkeypatch.setattr(registry, "_entries", dict(registry._entries))
        registry.register(entry)
    monkeypatch.setattr(PointsPart, "made", [])


@pytest.mark.usefixtures("registered")
@pytest.mark.parametrize("codec", ["none", "h264"])
def test_points_travel_with_frames_and_are_warped(gpu, codec):
    options = PipelineOptions(
        scene="planes", latency_ms=20, warp="dots", fill="none", lens="none", size=SIZE, coding=Coding(codec)
    )
    plan = build_plan((), "dots", "none", "none", client_geometry=True)
    assert plan.layers == ("rendered.dots",)
    requested = PoseRequest(Sliding(), None, SIZE, 1.0, plan.needs)
    scene = load_scene("planes")
    run = Run(options, Source(options, scene), None, [plan], plan.needs)
    with run.build(Target(gpu, TwoEyes(), 100.0, 20_000_000), requested) as made:
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
        size = refresh.transit.size_bytes
        if codec == "none":
            assert size == 12 * COUNT, "nothing else is read, so nothing else is sent"
        else:
            assert size == len(pack(shown.points_m)), "once a frame, not once an eye, and nothing that is not read"
        assert [delivery.released for delivery in sent] == [1] * 5 + [0] * 3, "frames that were shown, and no more"
    assert [delivery.released for delivery in sent] == [1] * 8


@pytest.mark.usefixtures("registered")
def test_frames_without_points_have_none(gpu):
    plan = build_plan((), "forward", "none", "none", client_geometry=True)
    options = PipelineOptions(scene="planes", warp="forward", fill="none", lens="none", size=SIZE)
    requested = PoseRequest(Sliding(), None, SIZE, 1.0, plan.needs)
    scene = load_scene("planes")
    run = Run(options, Source(options, scene), None, [plan], plan.needs)
    with run.build(Target(gpu, TwoEyes(), 100.0, 0), requested) as made:
        made.loop.draw(0)
        assert "dots" not in made.loop.show(0).inputs[0].rendered
    assert PointsPart.made == []
