"""Whole pictures of frames that carry parts of them as layers, for plans without such layers."""

from __future__ import annotations

import attrs

from ..client.inputs import PassInputs
from ..client.plan import Plan
from ..frames import EyeImage, Frame
from ..frames.layers import layers
from ..pipeline.layers_read import Reads
from ..pipeline.loop import Loop, Refresh
from ..sources.server import Renderer


class WholePictures:
    """The inputs of plans that run along with others on the same frames.

    Frames for a plan with effects lack what its layers show by themselves (mirrors, glass, the
    HUD), and frames that no plan reads a picture of have none. A plan without such layers gets the
    picture as if frames were drawn for it alone: it is drawn again, once for each frame and eye,
    and held until the next frame.
    """

    def __init__(self, server: Renderer) -> None:
        self._server = server
        self._frame: Frame | None = None
        self._drawn: dict[int, EyeImage] = {}

    def inputs(self, loop: Loop, refresh: Refresh, plan: Plan) -> tuple[PassInputs, ...]:
        """Return the inputs of the plan for the refresh just shown."""
        every = loop.inputs(refresh, plan.needs)
        if not _is_apart(refresh.frame, plan) and not _lacks_pictures(refresh.frame, plan):
            return every
        if refresh.frame is not self._frame:
            self.close()
            self._frame = refresh.frame
        return tuple(attrs.evolve(eye_inputs, rendered=self._whole(eye_inputs)) for eye_inputs in every)

    def _whole(self, inputs: PassInputs) -> EyeImage:
        image = inputs.rendered
        if inputs.eye not in self._drawn:
            self._drawn[inputs.eye] = self._server.draw(image.view, image.size, time_ns=image.drawn_ns)
            self._server.gpu.timer.collect()
        drawn = self._drawn[inputs.eye]
        return attrs.evolve(image, colour=drawn.colour, inverse_depth=drawn.inverse_depth, left_out=frozenset())

    def close(self) -> None:
        """Return the pictures to the server."""
        for image in self._drawn.values():
            self._server.pool(image.size).release(image.colour)
        self._drawn, self._frame = {}, None


def _lacks_pictures(frame: Frame, plan: Plan) -> bool:
    return not frame.eyes[0].left_out.isdisjoint(Reads.of([plan]).names)


def _is_apart(frame: Frame, plan: Plan) -> bool:
    apart = [name for name in frame.eyes[0].carried if layers.get(name).apart]
    return bool(apart) and not any(name in plan.needs for name in apart)
