"""The base class of warps, and that of warps in Python."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import Any, ClassVar, Literal

import attrs
import moderngl
import numpy as np
from numpy.typing import ArrayLike

from ...base import InputError, NoSettings, linear_from_srgb
from ...frames import Needs
from ...frames.layers import PICTURE
from ...geometry import Fovea, View
from ...gpu import Compute, Gpu
from ...gpu.textures import SCALAR, Canvas, Owner, allocate, download, upload
from ...scenes import Scene
from ..client_scene import ClientScene
from ..inputs import PassInputs
from ..lens import LensPass

# Bytes of one pixel: rgba16f colour, r32f inverse depth, 32-bit key.
KEY_BYTES = 4


@attrs.frozen(eq=False)
class Output:
    """The kind of output that a warp writes."""

    # The lens that the warp applies itself (one resample from the rendered picture to the panel);
    # None for the shown view before the lens.
    lens: LensPass | None = None
    # Whether rows light up one after the other, from PassInputs.shown to PassInputs.shown_last.
    scanout: bool = False
    # Whether run_with_depth() will be called: the inverse depth is written along with the colour.
    depth: bool = False
    # Of foveated pictures that the warp samples through their grid, see Warp.samples_grid.
    foveated: Fovea | None = None


def pixel_of(size: tuple[int, int]) -> tuple[float, float]:
    """Return (w, h) of a pixel in texture coordinates."""
    return 1 / size[0], 1 / size[1]


class Warp(Owner, ABC):
    """Warp one eye's rendered picture to the shown view; coverage is 0 where nothing is known.

    The object owns its programs and buffers for one pair of sizes. It serves both eyes in turn.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    # Gather: each shown pixel finds where it was rendered. Scatter: rendered pixels move. Draw: the
    # client draws what is shown, with all effects in it, and reads no rendered picture.
    kind: ClassVar[Literal["gather", "scatter", "draw"]]
    reads: ClassVar[tuple[str, ...]]  # Layers that it reads, by the names of client/plan.py.
    exact_when: ClassVar[str]  # When the result equals the truth, for tables.
    gets_wrong: ClassVar[str]  # Its artefacts, for tables.
    source: ClassVar[str]
    # An attrs class of the settings, each with a default (`mesh:cut=slope`).
    Settings: ClassVar[type] = NoSettings
    # Settings that trade accuracy for time; the bench runs them next to the defaults.
    variants: ClassVar[tuple[str, ...]] = ()
    # Settings with which it does what a published or shipped system does, and the name of that. The
    # bench runs and marks them too.
    baselines: ClassVar[Mapping[str, str]] = {}
    fuses: ClassVar[bool] = False  # Whether it can write the panel in one resample.
    scans_out: ClassVar[bool] = False  # Whether it can give every row a view of its own.
    resamples: ClassVar[bool] = False  # Whether its result is a resample even for an unmoved head.
    # Whether it can sample a foveated picture where it lies, without one that is expanded first.
    samples_grid: ClassVar[bool] = False
    # Whether it scatters, sorts or shares between pixels. Without, each shown pixel looks something
    # up by itself, which clients without compute shaders can do too.
    needs_compute: ClassVar[bool] = True
    # What it reads to write the shown inverse depth with the colour; None for a warp that runs a
    # second time for it, see client/carry.py.
    depth_reads: ClassVar[tuple[str, ...] | None] = None
    # Of a warp that draws: why no effect is compensated with it.
    without_effects: ClassVar[str] = "draws it as it is now: nothing is left to compensate"
    # Whether it warps other pictures than rendered.colour along, see client/carry.py.
    carries: ClassVar[bool] = True
    # Whether it stands for no compensation at all: no effect is compensated with it unless it is
    # asked for by name, and frames carry the whole picture.
    imposter: ClassVar[bool] = False

    def __init__(
        self,
        gpu: Gpu,
        rendered_size: tuple[int, int],
        shown_size: tuple[int, int],
        settings: Any = None,
        output: Output | None = None,
        geometry: ClientScene | None = None,
    ) -> None:
        """Make the warp for one pair of sizes. geometry: for warps that read client.model."""
        self.gpu, self.rendered_size, self.shown_size = gpu, rendered_size, shown_size
        self.settings = self.Settings() if settings is None else settings
        self.output = Output() if output is None else output
        self.geometry = geometry
        sizes = {"rendered_size": tuple(rendered_size), "shown_size": tuple(shown_size)}
        self._size_uniforms: dict[str, object] = {**sizes, "rendered_pixel": pixel_of(rendered_size)}
        # Where the inverse depth of this run goes.
        self.depth_into = self._run_depth = self.own(self.own_depth())
        self.prepare()

    def own_depth(self) -> moderngl.Texture | None:
        """Return where run() writes the inverse depth: one pixel that nobody reads, or nowhere."""
        return allocate(self.gpu.gl, (1, 1), SCALAR) if self.output.depth else None

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs and allocate the buffers; run() does neither."""

    @abstractmethod
    def run(self, inputs: PassInputs, into: Canvas) -> None:
        """Write the shown view's colour and coverage into `into` (rgba16f, shown_size)."""

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        """Run, and write r32f: the inverse depth of what is shown, in the shown view, -1 in holes.

        For a warp that has depth_reads and was made for an output with depth.
        """
        self.depth_into = depth
        self.run(inputs, into)
        self.depth_into = self._run_depth

    def stage(self) -> AbstractContextManager[object]:
        """Return what times run() as stage `warp`."""
        return self.gpu.timer.stage("warp", barrier=True)

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        """Return the layers that frames must carry, and the frames that the client must keep."""
        return Needs()

    @classmethod
    def unsuited(cls, scene: Scene) -> str:
        """Return why it is not for that scene, "" if it is."""
        return ""

    @classmethod
    def reads_for(cls, settings: Any) -> tuple[str, ...]:
        """Return what it reads with these settings: `reads`, or less or more of it."""
        return cls.reads

    def set_sizes(self, program: Compute) -> None:
        """Set the uniforms that depend on the sizes alone."""
        program.uniforms.settle(self._size_uniforms)


class ArrayWarp(Warp):
    """A warp whose subclass defines warp(): arrays in, arrays out, row 0 at the top.

    Its stage `warp` times warp() alone, not the copies from and to the GPU.
    """

    kind = "scatter"
    reads = PICTURE
    _is_timed = False

    def prepare(self) -> None:
        """Do nothing: a subclass may load a model here."""

    @abstractmethod
    def warp(self, colour: Any, depth_m: Any, rendered: View, shown: View, /) -> tuple[ArrayLike, ArrayLike]:
        """Return colour and coverage of the view `shown`, of self.shown_size (w, h).

        colour: (h, w, 3) float32 linear light; depth_m: (h, w) float32 metres along -z, inf
        infinitely far, NaN a hole. Both are the warp's own to change. Return colour as floats of
        linear light or as uint8 sRGB, (h, w, 3), and coverage (h, w), 0 in holes.
        """

    def arrays(self, inputs: PassInputs) -> tuple[Any, ...]:
        """Return the arguments of warp()."""
        rendered = inputs.rendered
        colour, inverse = np.array(download(rendered.colour), np.float32), download(rendered.inverse_depth)
        with np.errstate(divide="ignore", over="ignore"):
            depth_m = np.float32(1) / np.where((inverse >= 0) & (colour[..., 3] > 0), np.abs(inverse), np.nan)
        return colour[..., :3].copy(), depth_m, rendered.view, inputs.shown

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        given, shape = self.arrays(inputs), into.size[::-1]
        with self.gpu.timer.cpu_stage("warp") if self._is_timed else nullcontext():
            colour, coverage = map(np.asarray, self.warp(*given))
        if colour.shape != (*shape, 3) or coverage.shape != shape:
            raise InputError(
                f"warp '{self.name}' returned colour {colour.shape} and coverage {coverage.shape}: "
                f"expected {(*shape, 3)} and {shape}"
            )
        light: Any = linear_from_srgb(colour) if colour.dtype == np.uint8 else colour
        covered = (coverage != 0) & np.isfinite(light).all(axis=2)
        most = np.finfo(np.float16).max
        upload(into.texture, np.dstack([np.where(covered[..., None], light.clip(-most, most), 0), covered]))

    def __enter__(self) -> None:
        self._is_timed = True

    def __exit__(self, *_: object) -> None:
        self._is_timed = False

    def stage(self) -> ArrayWarp:
        """Return itself: what times its call alone."""
        return self
