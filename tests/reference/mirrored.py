"""Twins of the steps of MirroredPass: through points in the world instead of maps of pixels."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from hmdwarp.geometry import View
from reference._rays import Array, pixel_centres, project, rays_through, world_directions
from reference.picture import HALF_SMALLEST, HALF_UNIT, ReferencePicture, sample_covered

BLOCK = 8  # as in shaders/effects/mirrored.glsl, as the next two
CLOSEST = 0.94
TOLERANCE, FLOOR = 0.03, 0.02
ROUNDS = 3  # of the search for the depth of an image, in the same shader
PLACE_ERROR_PX = 3e-3  # a place is some 30 float32 operations on pixels up to a few hundred, three times in a row


@attrs.frozen(eq=False)
class Seen:
    """Bottom row first: colour (h, w, 4), premultiplied; inverse depth (h, w); of `view`."""

    colour: Array
    inverse_depth: Array
    view: View

    @property
    def size(self) -> tuple[int, int]:
        return self.inverse_depth.shape[1::-1]


def aligned(rendered: Seen, other: Seen, sampler_pixels: float) -> ReferencePicture:
    """What the other eye sees of each surface of the rendered picture, where it sees it."""
    own = rendered.inverse_depth
    known = own >= 0
    moved = rendered.view.pose.position_m - other.view.pose.position_m
    rays = world_directions(rendered.view, rendered.size)
    places, expected, _ = project(rays, moved, np.maximum(own, 0), other.view, other.size)
    texels = np.clip(np.nan_to_num(places, nan=-1.0).astype(int), 0, np.array(other.size) - 1)
    held = other.inverse_depth[texels[..., 1], texels[..., 0]]
    apart = np.abs(expected - held) - TOLERANCE * (np.minimum(expected, held) + FLOOR)
    agrees = known & (held >= 0) & (apart <= 0)
    found = sample_covered(other.colour, places, np.full(own.shape, PLACE_ERROR_PX), sampler_pixels)
    with np.errstate(invalid="ignore"):
        near_texel = (np.abs(places - np.round(places)) < PLACE_ERROR_PX).any(axis=-1)
    undecided = found.undecided | near_texel | (np.abs(apart) < 1e-4)
    return attrs.evolve(found, colour=np.where(agrees[..., None], found.colour, 0), undecided=undecided)


@attrs.frozen(eq=False)
class Images:
    """What the pass has found: per block (inverse depth of the mirror image, 1) and trust; per
    pixel the light in mirrors with its coverage.
    """

    depth: Array
    trust: Array
    light: Array


def joined(rendered: Seen, found: Images, shown: View, sampler_pixels: float) -> ReferencePicture:
    """The rendered picture with the light that the shown eye sees in each mirror.

    The shown ray goes on behind the surface until it meets the mirror image, which is seen in the
    rendered picture at another place.
    """
    own, size = rendered.inverse_depth, rendered.size
    centres = pixel_centres(size)
    rays, eye = world_directions(rendered.view, size), rendered.view.pose.position_m
    with np.errstate(divide="ignore"):
        surface = eye + rays / own[..., None]
    way = surface - shown.pose.position_m
    axis = rendered.view.pose.rotation.as_matrix() @ np.array([0.0, 0.0, -1.0])
    places = centres.copy()
    for _ in range(ROUNDS):
        image, _ = _image_at(found, own, places)
        # The plane across the rendered axis that the image there lies in.
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (1 / image - (shown.pose.position_m - eye) @ axis) / (way @ axis)
            point = shown.pose.position_m + way * share[..., None] - eye
            in_eye = point @ rendered.view.pose.rotation.as_matrix()
            tangents = in_eye[..., :2] / -in_eye[..., 2:]
        places = _pixels(rendered.view, size, tangents)
    light = sample_covered(found.light, places, np.full(own.shape, PLACE_ERROR_PX), sampler_pixels)
    here, mirrors = _image_at(found, own, centres)
    _, there = _image_at(found, own, places)
    part = _looked(found.trust[..., None], centres)[..., 0]
    moves = mirrors & there & (part > 0) & (light.colour[..., 3] > 0) & (found.light[..., 3] >= 0.5)
    change = part[..., None] * (light.colour[..., :3] - found.light[..., :3])
    out = rendered.colour.copy()
    out[..., :3] = np.where(moves[..., None], np.maximum(out[..., :3] + change, 0), out[..., :3])
    brightest = np.abs(rendered.colour[..., :3]).max(axis=-1) + np.abs(light.colour[..., :3]).max(axis=-1)
    # Weights of a sampler between blocks: trust may be off by that of one step of their 8 bits.
    weights = 2 / 256 * np.abs(light.colour[..., :3] - found.light[..., :3]).max(axis=-1)
    tolerance = light.tolerance + weights + 2 * HALF_UNIT * brightest + HALF_SMALLEST
    border = np.abs(here - CLOSEST * own) < 0.01 * own
    undecided = light.undecided | border | _beside_border(found, own, places)
    return ReferencePicture(out, tolerance, undecided)


def _image_at(found: Images, own: Array, places: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The inverse depth of the image at places, else of the surface; and whether it is an image."""
    texels = np.clip(np.nan_to_num(places, nan=0.0).astype(int), 0, np.array(own.shape[1::-1]) - 1)
    surface = own[texels[..., 1], texels[..., 0]]
    looked = _looked(found.depth, places)
    with np.errstate(divide="ignore", invalid="ignore"):
        image = looked[..., 0] / np.maximum(looked[..., 1], 1e-6)
    mirrors = (looked[..., 1] >= 0.5) & (image < CLOSEST * surface)
    return np.where(mirrors, image, surface), mirrors


def _beside_border(found: Images, own: Array, places: Array) -> NDArray[np.bool_]:
    """Whether a place is so near to the end of the images that rounding decides."""
    around = [_image_at(found, own, places + step)[1] for step in (-0.05, 0.05)]
    return around[0] != around[1]


def _looked(blocks: Array, places: Array) -> Array:
    """Blocks (h, w, c), each at its middle, looked at between them and clamped beyond."""
    at = np.nan_to_num(places, nan=0.0) / BLOCK - 0.5
    coords = [at[..., 1], at[..., 0]]
    planes = [ndimage.map_coordinates(plane, coords, order=1, mode="nearest") for plane in np.moveaxis(blocks, -1, 0)]
    return np.stack(planes, axis=-1)


def _pixels(view: View, size: tuple[int, int], tangents: Array) -> Array:
    low, high = (rays_through(view, size, np.array(at))[:2] for at in ((0.0, 0.0), size))
    return (tangents - low) / (high - low) * np.array(size)
