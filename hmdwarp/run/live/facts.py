"""What a run is, as far as that is settled when it begins."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import attrs

from ...display import Display
from ...geometry import Pose
from .options import LiveOptions

if TYPE_CHECKING:
    from .host import Stage


@attrs.frozen(eq=False)
class Facts:
    """headset: by name. size: (w, h) of one eye. lens: what the plan had. machine: as summary.json has it."""

    options: LiveOptions
    source: str
    about: dict[str, str]
    headset: str
    rate_hz: float
    size: tuple[int, int]
    scene: str
    scene_notes: tuple[str, ...]
    effects: list[str]
    lens: str
    pixels_per_degree: float
    machine: dict[str, Any]
    clock: str

    @property
    def budget_ms(self) -> float:
        """From one refresh of the display to the next."""
        return 1e3 / self.rate_hz


def facts_of(options: LiveOptions, display: Display, stage: Stage) -> Facts:
    """From the display and what is on."""
    gpu, size = display.gpu, options.size or display.size
    (view, *_) = display.eyes.views(Pose())
    return Facts(
        options=options,
        source=display.name,
        about=dict(display.about),
        headset=display.headset.name if display.headset is not None else display.about.get("headset") or display.name,
        rate_hz=display.rate_hz,
        size=size,
        scene=stage.scene.name,
        scene_notes=tuple(stage.scene.notes),
        effects=list(stage.plan.effects),
        lens=stage.plan.lens.name,
        pixels_per_degree=view.fov.pixels_per_degree(size),
        machine={"gl_renderer": gpu.renderer, "gl_version": gpu.version, "cpu_count": os.cpu_count() or 1},
        clock=gpu.timer.clock,
    )
