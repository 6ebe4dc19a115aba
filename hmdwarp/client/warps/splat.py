"""Forward warping by footprints: every rendered pixel covers the image of its square."""

from __future__ import annotations

import attrs
import numpy as np

from ...geometry import view_map
from ...gpu.textures import Canvas
from ..inputs import PassInputs
from ..warp_kinds import ScatterWarp, depth_limits
from . import warps


@attrs.frozen
class SplatSettings:
    """The size of footprints, and which neighbours are one surface.

    Neighbours are one surface if their inverse depths differ by at most tolerance * (their own +
    floor).
    """

    tolerance: float = attrs.field(default=0.03, validator=attrs.validators.ge(0))
    floor: float = attrs.field(default=0.02, validator=attrs.validators.ge(0))  # 1/m
    # Pixels that a footprint may extend from its middle. Beyond twice that magnification gaps
    # appear; one rendered pixel costs at most (2 reach + 1)^2 tests.
    reach: int = attrs.field(default=16, validator=[attrs.validators.ge(1), attrs.validators.le(256)])
    # Rendered pixels by which each square is larger on each side, against cracks on curved
    # surfaces.
    overlap: float = attrs.field(default=0.05, validator=[attrs.validators.ge(0), attrs.validators.le(0.5)])


@warps.register
class Splat(ScatterWarp):
    """Scatters the depth of each rendered pixel over its footprint, then fetches the colours back.

    The nearest depth wins; colours are fetched through that depth.
    """

    name = "splat"
    summary = (
        "each pixel covers the footprint its square becomes, nearest surface wins: no cracks, smooth between pixels"
    )
    exact_when = "always, up to one resample, where the rendered picture saw the surface"
    gets_wrong = "what was hidden is a hole; soft edges travel with their depth; magnified over 32 times it shows gaps"
    source = (
        "Westover 1990 (footprints); Zwicker et al. 2001 (EWA splatting); "
        "Mori et al. 2009 (depth forward, colour backward)"
    )
    Settings = SplatSettings

    def prepare(self) -> None:
        self._cover = self.gpu.shaders.compute("warps/splat.comp", grid="rendered", PASS=0)
        self._fetch = self.gpu.shaders.compute("warps/splat.comp", PASS=1, **self.depth_defines)
        self._keys = self.empty_keys()

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.bind(inputs, into)
        self._keys.bind_to_storage_buffer(0)
        s = self.settings
        limits = {**depth_limits(s, inputs.rendered), "reach": float(s.reach), "overlap": s.overlap}
        backward = view_map(inputs.shown, self.shown_size, inputs.rendered.view, self.rendered_size)
        passes = ((self._cover, self.forward_map(inputs), self.rendered_size), (self._fetch, backward, self.shown_size))
        for program, warp_map, size in passes:
            self.gpu.barrier()
            H, e = warp_map.H, warp_map.e
            if warp_map.moves_whole_pixels():  # each is then fetched from its very centre
                H, e = np.round(H), np.zeros(3)
            self.set(program, H=H, e=e, **limits)
            program.run(*size)

    def close(self) -> None:
        super().close()
        self._keys.release()
