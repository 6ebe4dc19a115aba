"""Further layers of a caller's picture, as textures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import moderngl
import numpy as np

from ..base import InputError
from ..client.effects.text import HeldPanel, panel_texture
from ..frames import Needs
from ..frames.layers import layers
from ..gpu import Gpu
from ..gpu.textures import COLOUR, Owner, allocate, release_all, upload
from ..scenes import Panel, Texture

VELOCITY, PANELS = "velocity", "panels"
# What a caller can pass beside pictures, and how.
KNOWN = {
    VELOCITY: "(h, w, 3) m/s along the eye's axes, 0 for what stands still",
    PANELS: "[hmdwarp.Panel(picture, pose, size_m), ..]",
}


class CallerLayers(Owner):
    """The layers that a plan reads and a caller can pass."""

    def __init__(self, gpu: Gpu, needs: Needs, size: tuple[int, int]) -> None:
        self._gpu, self._size = gpu, size
        self._read = [name for name in KNOWN if name in needs]
        self._velocity: Any = self.own(allocate(gpu.gl, size, COLOUR) if VELOCITY in self._read else None)
        self._panels: dict[Texture, moderngl.Texture] = {}  # those of the last picture

    def close(self) -> None:
        """Free the textures."""
        release_all(*self._panels.values())
        super().close()

    def check(self, passed: Mapping[str, Any], who: str) -> None:
        """Check that the layers passed are those that are read. Errors: InputError."""
        if not isinstance(passed, Mapping):
            raise InputError(f"layers is of type {type(passed).__name__}: expected a dict of arrays by name")
        for name in passed:
            if name not in KNOWN:
                why = "comes from a server or the feed alone" if name in layers.names() else "is unknown"
                raise InputError(f"layer '{name}' {why}: expected {', '.join(KNOWN)}")
            if name not in self._read:
                raise InputError(f"layer '{name}': {who} does not read it; leave it out, or name an effect that does")
        if VELOCITY in self._read and VELOCITY not in passed:
            raise InputError(f"{who} reads layer '{VELOCITY}': give layers={{'{VELOCITY}': ..}}, {KNOWN[VELOCITY]}")

    def hold(self, passed: Mapping[str, Any]) -> dict[str, Any]:
        """Return what passes read, by name. Errors: InputError."""
        held: dict[str, Any] = {}
        if VELOCITY in self._read:
            held[VELOCITY], (wide, high) = self._velocity, self._size
            velocity = np.asarray(passed[VELOCITY])
            if velocity.shape != (high, wide, 3) or velocity.dtype.kind not in "fiu":
                raise InputError(
                    f"layer '{VELOCITY}' is {velocity.dtype} {velocity.shape}: expected numbers of shape "
                    f"{(high, wide, 3)}"
                )
            if not np.isfinite(velocity).all():
                raise InputError(f"layer '{VELOCITY}' has NaN or infinite values: expected finite numbers")
            moves = (velocity != 0).any(axis=2, keepdims=True)
            upload(self._velocity, np.concatenate([velocity, moves], axis=2).astype(np.float32))
        if PANELS in self._read:
            panels = passed.get(PANELS, ())
            if not isinstance(panels, list | tuple) or not all(isinstance(panel, Panel) for panel in panels):
                raise InputError(f"layer '{PANELS}' is a {type(panels).__name__}: expected {KNOWN[PANELS]}")
            # Pictures that the call before had too stay where they are.
            pictures, before = {panel.pictures[0] for panel in panels}, self._panels
            self._panels = {picture: before.pop(picture) for picture in pictures if picture in before}
            for picture in pictures - self._panels.keys():
                self._panels[picture] = panel_texture(self._gpu, picture.image)
            release_all(*before.values())
            held[PANELS] = tuple(HeldPanel(panel, self._panels[panel.pictures[0]]) for panel in panels)
        return held
