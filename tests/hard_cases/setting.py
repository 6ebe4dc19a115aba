"""One rendered picture and one shown view, given as arrays, run through a warp and through its
float64 twin."""

from __future__ import annotations

import functools
from collections.abc import Iterator

import attrs
import numpy as np
from reference.picture import GPU_SAMPLER_PIXELS
from worlds import World, has_twin

from hmdwarp.client import parse_warp
from hmdwarp.geometry import Fov, Pose, View, WarpMap

Size = tuple[int, int]
SQUARE = Fov.from_tangents([-1, 1, -1, 1])
SIZE = (33, 27)
HALF = 2.0**-10  # of a stored half float, which llvmpipe truncates


def reads(name: str) -> tuple[str, ...]:
    """What the warp reads with its settings."""
    choice = parse_warp(name)
    return choice.entry.reads_for(choice.settings)


def reads_depth(name: str) -> bool:
    """Whether the warp moves things by their depth. The others (none, rotation, environment) see no
    parallax at all."""
    return any(part.endswith(("inverse_depth", "layers", "others")) for part in reads(name))


def is_warped_by_the_frame_alone(name: str) -> bool:
    """Whether what it shows comes from the rendered picture: `environment` has pictures of its own.
    With settings or without."""
    return "rendered.colour" in parse_warp(name).entry.reads


def brings_more_pictures(name: str) -> bool:
    """Whether it shows other pictures than the rendered one too, which are noise here."""
    return bool({"rendered.peeled", "rendered.others"} & set(parse_warp(name).entry.reads))


@attrs.frozen(eq=False)
class Picture:
    """colour (h, w, 4) with coverage in alpha, bottom row first; decided. Where rounding may not
    choose otherwise; maker: "shader" or "twin"."""

    maker: str
    colour: np.ndarray
    decided: np.ndarray

    @property
    def covered(self) -> np.ndarray:
        return self.colour[..., 3] > 0


@functools.cache  # each warp has the same cases
def landed(depths: bytes, size: Size, h: bytes, e: bytes, shown_size: Size, per_pixel: int = 8) -> np.ndarray:
    """The nearest of what lands in each shown pixel, -1 where nothing does. Each rendered pixel is
    a small square of points. depths, h, e: arrays of float64 as bytes."""
    out, inverse_depth = np.full(shown_size[::-1], -1.0), np.frombuffer(depths).reshape(size[::-1])
    forward = WarpMap(np.frombuffer(h).reshape(3, 3), np.frombuffer(e))
    usable = np.isfinite(inverse_depth) & (inverse_depth >= 0)
    y, x = np.nonzero(usable)
    for within in np.ndindex(per_pixel, per_pixel):
        places = np.stack([x, y], axis=-1) + (np.array(within) + 0.5) / per_pixel
        pixels, depth, w = forward.apply(places, inverse_depth[usable])
        lands = (w > 0) & np.isfinite(depth) & ((pixels >= 0) & (pixels < shown_size)).all(axis=-1)
        at = np.floor(pixels[lands]).astype(int)
        np.maximum.at(out, (at[:, 1], at[:, 0]), depth[lands])
    out = np.minimum(out, np.finfo(np.float32).max).astype(np.float32).astype(np.float64)
    out.flags.writeable = False
    return out


class Setting(World):
    """colour: (h, w, 3) linear; inverse_depth: (h, w), whatever the case calls for.

    Bottom row first. client: the client's own depth in the shown view, by default what of the
    rendered depth lands there.
    """

    def __init__(
        self,
        gpu,
        inverse_depth: np.ndarray,
        shown: Pose | View,
        colour: np.ndarray | None = None,
        rendered: Pose | View | None = None,
        shown_size: tuple[int, int] | None = None,
        client: np.ndarray | None = None,
    ) -> None:
        self.rng = np.random.default_rng(99)
        self.size = inverse_depth.shape[::-1]
        self.shown_size = shown_size or self.size
        self.layers, self.others, self.other_images, self.cube = (), (), (), None
        self.rendered_view = rendered if isinstance(rendered, View) else View(rendered or Pose(), SQUARE)
        self.shown_view = shown if isinstance(shown, View) else View(shown, self.rendered_view.fov)
        covered = np.isfinite(inverse_depth) & (inverse_depth >= 0)
        drawn = self.rng.uniform(0.1, 1, (*inverse_depth.shape, 3)) if colour is None else colour
        rgba = np.concatenate([drawn * covered[..., None], covered[..., None]], axis=2)
        self.colour = rgba.astype(np.float16).astype(np.float64)
        with np.errstate(over="ignore"):
            self.inverse_depth = inverse_depth.astype(np.float32).astype(np.float64)
        there = WarpMap.between(self.rendered_view, self.size, self.shown_view, self.shown_size)
        self.client = (
            landed(self.inverse_depth.tobytes(), self.size, there.H.tobytes(), there.e.tobytes(), self.shown_size)
            if client is None
            else client.astype(np.float32).astype(np.float64)
        )
        self.upload(gpu)
        self.sampler_pixels = 4 * 2.0**-24 * max(self.size) if gpu.is_software else GPU_SAMPLER_PIXELS
        self.gpu = gpu

    def _draw(self) -> None:
        """For World's further pictures: noise on the case's own depth."""
        covered = self.colour[..., 3:]
        noise = self.rng.uniform(0.1, 1, (*self.inverse_depth.shape, 3))
        self.colour = np.concatenate([noise * covered, covered], axis=2).astype(np.float16).astype(np.float64)

    def pictures(self, name: str) -> Iterator[Picture]:
        """The shader's picture and the twin's, if the warp has one, after the checks that hold in
        every case."""
        shader = Picture("shader", self.warp(self.gpu, name), np.ones(self.shown_size[::-1], bool))
        if not has_twin(name):
            self._check(shader, name)
            yield shader
            return
        wanted = self.reference(name)
        twin = Picture("twin", wanted.colour, ~wanted.undecided)
        for picture in (shader, twin):
            self._check(picture, name)
        same = shader.covered == twin.covered
        assert same[twin.decided].all(), (
            f"coverage differs from the twin at {np.argwhere(~same & twin.decided)[:3].tolist()}"
        )
        difference = np.abs(shader.colour[..., :3] - twin.colour[..., :3]).max(axis=-1)
        beyond = (difference > wanted.tolerance) & twin.decided
        assert not beyond.any(), (
            f"differs from the twin by {difference[beyond].max()} at {np.argwhere(beyond)[:3].tolist()}"
        )
        yield shader
        yield twin

    def _check(self, picture: Picture, name: str) -> None:
        """Finite; coverage 0 or 1; nothing where there is no coverage. No colour brighter or darker
        than all that went in."""
        colour = picture.colour[picture.decided]
        assert np.isfinite(colour).all(), f"the {picture.maker} makes NaN or Inf"
        assert set(np.unique(colour[..., 3])) <= {0.0, 1.0}
        assert (colour[colour[..., 3] == 0] == 0).all()
        if not is_warped_by_the_frame_alone(name):
            return
        went_in = [self.colour, *(layer.colour for layer in (*self.layers, *self.others))]
        known = np.concatenate([picture[picture[..., 3] > 0][:, :3] for picture in went_in] + [np.zeros((1, 3))])
        covered = colour[colour[..., 3] > 0][:, :3]
        # A mean of what went in, rounded to a half float: twice for a warp that accumulates.
        slack = 2 * HALF * np.abs(known).max(axis=0) + 1e-6
        low = known[:-1].min(axis=0) if len(known) > 1 else known[0]
        assert (covered >= low - slack).all()
        assert (covered <= known.max(axis=0) + slack).all()
