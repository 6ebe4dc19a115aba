"""Backward warping: the client draws its own depth and fetches colour from the late frame."""

from __future__ import annotations

from typing import Any, Literal

import attrs

from ...errors import PlanError
from ...gpu.textures import Canvas
from ..inputs import PassInputs
from ..warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE, GatherSettings, GatherWarp, depth_limits
from . import warps


@attrs.frozen
class BackwardSettings(GatherSettings):
    """When a rendered depth agrees with the client's.

    They agree if they differ by at most tolerance * (the client's inverse depth + floor).
    """

    # off: no rendered depth is sent or compared. Every place in the rendered picture counts, so
    # what was hidden takes the colour of what hid it.
    test: Literal["on", "off"] = "on"
    tolerance: float = attrs.field(default=DEPTH_TOLERANCE, validator=attrs.validators.ge(0))
    floor: float = attrs.field(default=DEPTH_FLOOR, validator=attrs.validators.ge(0))  # 1/m


@warps.register
class Backward(GatherWarp):
    """A gather with the client's own depth; a test against the rendered depth leaves holes."""

    name = "backward"
    needs_compute = False
    summary = "the client draws its own depth now and fetches the colour from the rendered picture"
    reads = ("rendered.colour", "rendered.inverse_depth", "client.inverse_depth")
    exact_when = "always, up to one bilinear resample, where the rendered picture saw the surface"
    gets_wrong = (
        "needs the scene's geometry; shading that depends on the view stays late; with test=off, for which no "
        "rendered depth is sent, what was hidden takes the colour of what hid it"
    )
    source = "McMillan and Bishop 1995 (the map); Williams 1978 (the depth test)"
    Settings = BackwardSettings
    depth_reads = ("client.inverse_depth",)
    scans_out = False  # the client's depth is drawn at one instant

    def prepare(self) -> None:
        self._tests = self.settings.test == "on"
        self._program = self.gather("warps/backward.comp", TEST=int(self._tests))

    @classmethod
    def reads_for(cls, settings: Any) -> tuple[str, ...]:
        """Return `reads`, without the rendered depth where nothing is compared with it."""
        return cls.reads if settings.test == "on" else tuple(n for n in cls.reads if n != "rendered.inverse_depth")

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        if inputs.client_inverse_depth is None:
            raise PlanError(
                "warp 'backward' needs the client's own depth, so a scene; for frames without one use 'forward'"
            )
        inputs.client_inverse_depth.bind_to_image(2, read=True, write=False)
        tested: dict[str, object] = {}
        if self._tests:
            inputs.rendered.inverse_depth.bind_to_image(1, read=True, write=False)
            tested = {"rendered_inverse_depth": 1, **depth_limits(self.settings, inputs.rendered)}
        self.run_gather(self._program, inputs, into, client_inverse_depth=2, **tested)
