"""Gathers that test each shown pixel against the rendered depth, or search along its ray."""

from __future__ import annotations

from typing import Any, Literal

import attrs

from ...errors import PlanError
from ...gpu.textures import Canvas, tiles
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


LEVELS, FACTOR = 4, 4  # of the pyramid: blocks of 4, 16, 64 and 256 texels on each side; as in shaders/lib/pyramid.glsl
BOUND_BYTES = 8
NEAREST = 2.0**11  # 1/m; the search ends half a millimetre before the eye


@attrs.frozen
class SearchSettings(GatherSettings):
    """How far rays run, and which neighbours are one surface.

    Neighbours are connected if they differ by at most tolerance * (the farther one's inverse depth
    + floor).
    """

    steps: int = 512  # Cells that a ray may pass before it ends in a hole.
    # Pixels by which a ray may miss the end of a surface and still meet it, so that steep surfaces
    # stay connected.
    gap: float = 0.05
    tolerance: float = DEPTH_TOLERANCE
    floor: float = DEPTH_FLOOR  # 1/m

    def __attrs_post_init__(self) -> None:
        if not 1 <= self.steps <= 65536:
            raise ValueError(f"steps={self.steps}: expected 1 to 65536")
        if not all(0 <= limit < float("inf") for limit in (self.tolerance, self.floor, self.gap)):
            raise ValueError("tolerance, floor and gap must be 0 or more")


@warps.register
class Search(GatherWarp):
    """A gather to the first hit along the epipolar segment, which skips by a pyramid of bounds.

    Rays that hit nothing are holes.
    """

    name = "search"
    summary = "follows each pixel's ray through the rendered picture to the first surface it meets"
    reads = ("rendered.colour", "rendered.inverse_depth")
    exact_when = (
        "the rendered picture saw the surface, up to one bilinear resample; of several on a ray always the front one"
    )
    gets_wrong = "silhouettes end half way between rendered pixels; slow where rays run long past many edges"
    source = "McMillan 1997 (search along the epipolar line); Tevs, Ihrke and Seidel 2008, Maximum Mipmaps"
    Settings = SearchSettings
    rows = 4

    def prepare(self) -> None:
        self._program = self.gather("warps/search.comp")
        self._build = tuple(self.gpu.shaders.compute("warps/search_pyramid.comp", FROM_DEPTH=k) for k in (1, 0))
        self._sizes = [self.rendered_size]
        for _ in range(LEVELS):
            self._sizes.append(tiles(self._sizes[-1], FACTOR))
        counts = [w * h for w, h in self._sizes[1:]]
        self._first = tuple(sum(counts[:k]) for k in range(LEVELS))
        self._bounds = self.gpu.gl.buffer(reserve=BOUND_BYTES * sum(counts))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        inputs.rendered.inverse_depth.bind_to_image(1, read=True, write=False)
        self._bounds.bind_to_storage_buffer(0)
        levels = {"level_first": self._first, "level_width": tuple(w for w, _ in self._sizes[1:])}
        for level in range(1, LEVELS + 1):
            program, (below, blocks) = self._build[min(level, 2) - 1], self._sizes[level - 1 : level + 1]
            own = {"rendered_inverse_depth": 1, "rendered_size": self.rendered_size} if level == 1 else {}
            program.uniforms.set(level=level, blocks=blocks, below=below, **levels, **own)
            program.run(*blocks)
            self.gpu.barrier()
        wide, high = self.rendered_size
        chosen = self.settings
        surface = {"rendered_inverse_depth": 1, "last_centre": (wide - 0.5, high - 0.5)}
        surface |= depth_limits(chosen, inputs.rendered)
        self.run_gather(
            self._program, inputs, into, gap=chosen.gap, steps=chosen.steps, nearest=NEAREST, **surface, **levels
        )

    def close(self) -> None:
        super().close()
        self._bounds.release()
