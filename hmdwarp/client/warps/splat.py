"""Forward warping by footprints: every drawn pixel covers what its square becomes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from ...geometry import WarpMap
from ..warp_kinds import ScatterWarp
from . import COLOUR_BYTES, DEPTH_BYTES, KEY_BYTES, warps

if TYPE_CHECKING:
    from ...gpu.textures import Canvas
    from ..inputs import PassInputs


@attrs.frozen
class SplatSettings:
    """Neighbours are of one surface if their inverse depths differ by at most tolerance * (their own + floor), floor in 1/m.

    reach: pixels that a footprint may go from its middle: what is magnified more than twice that much shows gaps, and one drawn pixel
    costs at most (2 reach + 1)^2 tests. overlap: late pixels by which each square is larger on each side, against cracks on curved
    surfaces.
    """

    tolerance: float = attrs.field(default=0.03, validator=attrs.validators.ge(0))
    floor: float = attrs.field(default=0.02, validator=attrs.validators.ge(0))
    reach: int = attrs.field(default=16, validator=[attrs.validators.ge(1), attrs.validators.le(256)])
    overlap: float = attrs.field(default=0.05, validator=[attrs.validators.ge(0), attrs.validators.le(0.5)])


@warps.register
class Splat(ScatterWarp):
    """Scatters the depth of each drawn pixel over its footprint, nearest first, then fetches the colours back through that depth."""

    name = "splat"
    summary = (
        "each pixel covers the footprint its square becomes, nearest surface wins: no cracks, smooth between pixels"
    )
    exact_when = "always, up to one resample, where the late picture saw the surface"
    gets_wrong = "what was hidden is a hole; soft edges travel with their depth; magnified over 32 times it shows gaps"
    source = "Westover 1990 (footprints); Zwicker et al. 2001 (EWA splatting); Mori et al. 2009 (depth forward, colour backward)"
    Settings = SplatSettings

    def prepare(self) -> None:
        self._cover, self._fetch = (self.gpu.shaders.compute("warps/splat.comp", PASS=k) for k in range(2))
        self._keys = self.empty_keys()

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.bind(inputs, into)
        self._keys.bind_to_storage_buffer(0)
        s = self.settings
        limits = {"depth_tolerance": s.tolerance, "depth_floor": s.floor, "reach": float(s.reach), "overlap": s.overlap}
        backward = WarpMap.between(inputs.shown, self.shown_size, inputs.rendered.view, self.rendered_size)
        passes = ((self._cover, self.forward_map(inputs), self.rendered_size), (self._fetch, backward, self.shown_size))
        for program, warp_map, size in passes:
            self.gpu.barrier()
            H, e = _exact(warp_map)
            self.set(program, H=H, e=e, **limits)
            program.run(*size)

    @classmethod
    def bytes_moved(cls, rendered_pixels: int, shown_pixels: int, settings: Any) -> int:
        """Each drawn pixel's depth twice and colour once; the shown keys raised (read, written), read and emptied; the result written."""
        return rendered_pixels * (2 * DEPTH_BYTES + COLOUR_BYTES) + shown_pixels * (4 * KEY_BYTES + COLOUR_BYTES)

    def close(self) -> None:
        self._keys.release()


def _exact(warp_map: WarpMap) -> tuple[np.ndarray, np.ndarray]:
    """A map that moves whole pixels without what rounding left beside them, so that each pixel is fetched from its very centre."""
    if not warp_map.moves_whole_pixels():
        return warp_map.H, warp_map.e
    return np.round(warp_map.H), np.zeros(3)
