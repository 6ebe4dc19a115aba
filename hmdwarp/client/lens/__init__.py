"""Lens models on the GPU, registered by name; their coefficients belong to the headsets."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...base import InputError
from ...geometry import Fov, Hidden
from ...gpu import Compute, Gpu
from ...gpu.textures import Canvas, Owner, bind_images
from ...headsets import COLOURS, Headset, Lens, RadialLens, TableLens, ViveLens
from ..settings import DescribedRegistry

# Image unit of the picture that programs for the panel read.
_TEXELS_UNIT = 7
# Of a program that includes lib/panel.glsl. ROWS: pixels of a column per invocation. TEXELS: image
# loads instead of the sampler. On llvmpipe 32 rows take 0.8 of the time of 8, because the ends of
# the visible part are computed once per column. A GPU needs many invocations.
SOFTWARE_DEFINES = {"ROWS": 32, "TEXELS": 1}
GPU_DEFINES = {"ROWS": 4}


def bind_texels(program: Compute, picture: moderngl.Texture) -> dict[str, object]:
    """Bind the picture that a panel program reads by image loads, if any; return its uniform."""
    if not program.uniforms.declares("rendered_texels"):
        return {}
    picture.bind_to_image(_TEXELS_UNIT, read=True, write=False)
    return {"rendered_texels": _TEXELS_UNIT}


@attrs.frozen(eq=False)
class SeenPanel:
    """The pixels of an eye's panel that show something seen of its view, as a view."""

    headset: Headset
    eye: int
    fov: Fov
    area: Hidden  # of the view

    @property
    def hidden(self) -> SeenPanel:
        """Itself: what the other pixels would show is hidden."""
        return self

    def seen(self, fov: Fov, size: tuple[int, int]) -> NDArray[np.bool_]:
        """Return (h, w), the bottom row first: pixels one colour of which is seen."""
        places = (np.stack(np.meshgrid(*map(np.arange, size)), axis=-1) + 0.5) / size
        in_view = np.pad(self.area.seen(fov, size), 1)  # at its own size: finer changes little
        low, high = fov.tangents[::2], fov.tangents[1::2]
        found = np.zeros(size[::-1], bool)
        for colour in COLOURS:
            at = (self.headset.through_lens(self.eye, places, colour) - low) / (high - low) * size
            x, y = np.moveaxis(np.floor(np.nan_to_num(np.clip(at, -1, size), nan=-1)).astype(int) + 1, -1, 0)
            found |= in_view[y, x]
        return found

    def rows(self, fov: Fov, size: tuple[int, int]) -> NDArray[np.int32]:
        """Return (w, 2): each column's first seen row, and the one after its last."""
        seen = self.seen(fov, size)
        ends = np.where(seen.any(axis=0), [seen.argmax(axis=0), size[1] - seen[::-1].argmax(axis=0)], 0)
        return ends.T.astype(np.int32)


class LensPass(Owner, ABC):
    """Distort the shown picture so that the headset's lens undoes it."""

    name: ClassVar[str]
    summary: ClassVar[str]
    source: ClassVar[str]
    reads: ClassVar[tuple[str, ...]] = ("shown.colour",)
    is_pass: ClassVar[bool] = True  # False if there is nothing to do.
    # The shader library with `prepare_lens`, `vec3 lens_scales(vec2 on_lens)` and their uniforms; a
    # gather warp that is fused with the lens includes it too. "" if there is none.
    library: ClassVar[str] = ""

    def __init__(self, gpu: Gpu, headset: Headset, panel_size: tuple[int, int]) -> None:
        self.gpu, self.headset, self.panel_size = gpu, headset, panel_size
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs; run() does not.

        Errors: InputError if the headset has no coefficients for this lens.
        """

    @abstractmethod
    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        """Write the panel picture of eye 0 (left) or 1 (right) into `into`."""

    def library_defines(self) -> dict[str, object]:
        """Return the defines of a program that includes `library`, for this lens and device."""
        return dict(SOFTWARE_DEFINES if self.gpu.is_software else GPU_DEFINES)

    @property
    def panel_defines(self) -> dict[str, object]:
        """The defines of such a program, whose grid is the panel."""
        rows = {"ROWS": 8} if self.gpu.shaders.hidden.skips else {}  # those of shaders/gpu/hide.comp
        return {"LENS": self.library, **self.library_defines(), **rows}

    def library_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        """Return the uniforms of `library` for one eye."""
        raise NotImplementedError(f"lens '{self.name}' cannot be fused with a warp")


class _ResampledLens(LensPass):
    """A lens that one resample of the shown picture corrects, by a library of its own.

    Errors, when made: InputError for a headset without a lens of this model.
    """

    def prepare(self) -> None:
        self.eye_lenses = [eye.lens for eye in self.headset.eyes if eye.lens is not None]
        if not self.eye_lenses:
            raise InputError(f"headset '{self.headset.name}' has no lens: use --lens none")
        if self.eye_lenses[0].model != self.name:
            raise InputError(
                f"headset '{self.headset.name}' has a lens of model {self.eye_lenses[0].model}: "
                f"use --lens {self.eye_lenses[0].model} or none"
            )
        self._uniforms_by_eye: dict[int, tuple[Fov, dict[str, object]]] = {}
        self._program = self.gpu.shaders.compute("lens/resample.comp", grid="panel", **self.panel_defines)
        self._run = self._program.over(*self.panel_size)

    @abstractmethod
    def of_lens(self, lens: Lens) -> dict[str, object]:
        """Return the uniforms of the library that depend on the lens alone."""

    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        shown.texture.use(0)
        size = shown.size
        sizes = {"rendered_size": size, "rendered_pixel": (1 / size[0], 1 / size[1]), "shown_size": size}
        units = bind_images(write={"written": into}) | bind_texels(self._program, shown.texture)
        own = self.library_uniforms(fov, eye)
        self._program.uniforms.set(rendered_colour=0, panel_size=self.panel_size, **sizes, **units, **own)
        self._run()

    def library_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        known, uniforms = self._uniforms_by_eye.get(eye, (None, {}))
        if known != fov:
            left, right, down, up = fov.tangents
            span = np.array([right - left, up - down])
            scale, offset = self.headset.lens_from_panel(eye, self.panel_size)
            uniforms = {
                "lens_from_panel": (*scale, *offset),
                "shown_from_tangent": (*(1 / span), *(-np.array([left, down]) / span)),
                **self.of_lens(self.eye_lenses[eye]),
            }
            self._uniforms_by_eye[eye] = fov, uniforms
        return uniforms


lenses: DescribedRegistry[type[LensPass]] = DescribedRegistry(
    "lens", __name__, modules=dict.fromkeys(("none", "radial", "table", "vive"), "__init__"), columns="source"
)


@lenses.register
class NoLens(LensPass):
    """Leave the picture undistorted; the plan leaves this pass out."""

    name = "none"
    is_pass = False

    def prepare(self) -> None:
        """Do nothing."""

    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        raise AssertionError("the plan leaves this lens out")


@lenses.register
class Radial(_ResampledLens):
    """Sample once per channel for each panel pixel, which cancels the lens's colour fringes."""

    name = "radial"
    library = "lens/radial.glsl"

    def library_defines(self) -> dict[str, object]:
        terms = [self._terms(lens) for lens in self.eye_lenses]
        one_colour = {"ONE_COLOUR": 1} if all((t == t[:, :1]).all() for t in terms) else {}
        return {**super().library_defines(), "LENS_TERMS": max(map(len, terms)), **one_colour}

    def of_lens(self, lens: Lens) -> dict[str, object]:
        return {"lens_terms": self._terms(lens)}

    def _terms(self, lens: Lens) -> NDArray[np.float64]:
        """Return (n, 3) coefficients of r^0, r^2, .. in the scales of red, green and blue.

        n is the length of the longest of all.
        """
        assert isinstance(lens, RadialLens)
        longest = max(
            len(terms) for one in self.eye_lenses if isinstance(one, RadialLens) for terms in one.coefficients.values()
        )
        columns = [
            np.pad(lens.coefficients[colour], (0, longest - len(lens.coefficients[colour]))) for colour in COLOURS
        ]
        return np.stack(columns, axis=1) * lens.tangent_per_unit


# Between two rows the shader interpolates linearly. Of a lens of 100 degrees that is off by 1e-5 in
# tangents, a hundredth of a pixel of 1000 per tangent.
ROWS = 129


@lenses.register
class Table(_ResampledLens):
    """Sample once per channel; black beyond the last angle of the table."""

    name = "table"
    library = "lens/table.glsl"

    def library_defines(self) -> dict[str, object]:
        return {**super().library_defines(), "LENS_ROWS": ROWS}

    def of_lens(self, lens: Lens) -> dict[str, object]:
        assert isinstance(lens, TableLens)
        r = np.linspace(0, lens.reach, ROWS)
        ends, step, rows = np.array([lens.distances[colour][-1] for colour in COLOURS]), 1e-4, []
        for colour, end in zip(COLOURS, ends, strict=True):
            # Straight on past the end, for the row that it lies before.
            before, last = lens.scales(colour, np.array([end - step, end]))
            past = last + (r - end) * (last - before) / step
            rows.append(np.where(r <= end, lens.scales(colour, np.minimum(r, end)), past))
        return {"lens_rows": np.stack(rows, axis=1), "lens_ends": ends, "lens_row_step": lens.reach / (ROWS - 1)}


@lenses.register
class Vive(_ResampledLens):
    """Sample once per channel, each around its own centre; black beyond the cutoff."""

    name = "vive"
    library = "lens/vive.glsl"

    def library_defines(self) -> dict[str, object]:
        return {**super().library_defines(), "LENS_TANGENTS": 1}

    def of_lens(self, lens: Lens) -> dict[str, object]:
        assert isinstance(lens, ViveLens)
        return {
            "lens_terms": np.array([lens.coefficients[colour] for colour in COLOURS]),
            "lens_centres": np.array([lens.centres[colour] for colour in COLOURS]),
            "lens_focal": lens.focal,
            "lens_cutoff": lens.cutoff_r2,
        }
