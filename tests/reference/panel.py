"""Twin of the panels: rays that meet rectangles in the world, and means by overlap."""

from __future__ import annotations

import attrs
import numpy as np
from scipy import ndimage

from hmdwarp.geometry import View
from hmdwarp.scenes import Panel
from reference._rays import Array

MOST_TAPS = 16
STEP = 1e-3  # pixels between the rays that tell a footprint: their rounding is 1e-13 of it


@attrs.frozen(eq=False)
class Met:
    """Where the rays of all pixels meet a panel, (h, w) and bottom row first."""

    place: Array  # (h, w, 2) from 0 to 1
    inverse_depth: Array  # along -z of the eye; 0 or less behind it
    is_whole: Array  # whether the horizon of the plane is more than a pixel away
    by_x: Array  # (h, w, 2) change of place from pixel to pixel
    by_y: Array


def met(panel: Panel, view: View, size: tuple[int, int]) -> Met:
    """Return where rays through the pixels meet the panel's plane."""
    world_from_panel = panel.pose
    if panel.head_locked:
        world_from_panel = view.pose @ view.head_from_eye.inverse() @ panel.pose
    left, right, down, up = view.fov.tangents

    def at(dx: float, dy: float) -> tuple[Array, Array]:
        x = left + (np.arange(size[0]) + 0.5 + dx) * (right - left) / size[0]
        y = down + (np.arange(size[1]) + 0.5 + dy) * (up - down) / size[1]
        xx, yy = np.meshgrid(x, y)
        rays = np.stack([xx, yy, -np.ones_like(xx)], axis=-1)
        along = world_from_panel.rotation.inv().apply(view.pose.rotation.apply(rays.reshape(-1, 3)))
        eye = world_from_panel.rotation.inv().apply(view.pose.position_m - world_from_panel.position_m)
        depth = -eye[2] / along[:, 2]
        place = (eye + depth[:, None] * along)[:, :2] / panel.size_m + 0.5
        return place.reshape(*xx.shape, 2), (1 / depth).reshape(xx.shape)

    (place, inverse), (east, *of_east), (west, *of_west), (north, *of_north), (south, *of_south) = (
        at(*step) for step in ((0, 0), (STEP, 0), (-STEP, 0), (0, STEP), (0, -STEP))
    )
    slope = sum(np.abs(a[0] - b[0]) / (2 * STEP) for a, b in ((of_east, of_west), (of_north, of_south)))
    return Met(place, inverse, inverse > slope, (east - west) / (2 * STEP), (north - south) / (2 * STEP))


def levels(image: Array) -> list[Array]:
    """Return (h, w, 4) premultiplied light, bottom row first, then means of halves."""
    share = image[..., :3] / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    alpha = image[..., 3:] / 255 if image.shape[2] == 4 else np.ones((*image.shape[:2], 1))
    whole = np.concatenate([light * alpha, alpha], axis=2)[::-1]
    found, mean = [], whole
    for level in range(max(whole.shape[:2]).bit_length()):
        if level:
            rows, columns = (shares(count, max(1, count // 2)) for count in mean.shape[:2])
            mean = np.einsum("yr,xc,rcs->yxs", rows, columns, mean, optimize=True)
        found.append(mean.astype(np.float16).astype(np.float64))
    return found


def shares(count: int, fewer: int) -> Array:
    """Return (fewer, count): how much of each texel lies in each of the equal parts of all."""
    ends, texels = np.linspace(0, count, fewer + 1), np.arange(count)
    overlap = np.minimum(ends[1:, None], texels + 1) - np.maximum(ends[:-1, None], texels)
    return np.maximum(overlap, 0) * (fewer / count)


def looked_up(pyramid: list[Array], place: Array, level: Array) -> Array:
    """Return light at places, between two levels."""
    found = np.zeros((*level.shape, 4))
    low = np.floor(level).astype(int)
    for number, picture in enumerate(pyramid):
        share = np.where(low == number, 1 - (level - low), np.where(low + 1 == number, level - low, 0))
        high, wide = picture.shape[:2]
        at = [place[..., 1] * high - 0.5, place[..., 0] * wide - 0.5]
        for channel in range(4):
            looked = ndimage.map_coordinates(picture[..., channel], at, order=1, mode="nearest")
            found[..., channel] += share * looked
    return found


def footprint(found: Met, texels: tuple[int, int]) -> tuple[Array, Array, Array]:
    """Return the long axis, (h, w, 2) in texels, its length, and that of the short one."""
    columns = np.stack([found.by_x * texels, found.by_y * texels], axis=-1)
    axes, lengths, _ = np.linalg.svd(columns)
    return axes[..., :, 0] * lengths[..., :1], lengths[..., 0], lengths[..., 1]


def panel(
    asked: Panel, image: Array, view: View, behind: Array, inverse_depth: Array | None = None, nearer: float = 1.0
) -> tuple[Array, Array]:
    """Return the picture with the panel over it, and where a rounding may choose otherwise."""
    size, texels = behind.shape[1::-1], image.shape[1::-1]
    found = met(asked, view, size)
    pyramid = levels(image)
    long, major, minor = footprint(found, texels)
    ratio = major / np.maximum(minor, 1)
    taps = np.clip(np.floor(ratio + 0.5), 1, MOST_TAPS)
    level = np.log2(np.maximum(np.maximum(minor, major / taps), 1))
    level = np.minimum(level, len(pyramid) - 1)
    light = np.zeros_like(behind)
    for tap in range(MOST_TAPS):
        place = found.place + long / texels * ((tap + 0.5) / taps - 0.5)[..., None]
        light += np.where((tap < taps)[..., None], looked_up(pyramid, place, level) / taps[..., None], 0)
    wide = np.hypot(found.by_x, found.by_y)
    inside = (np.minimum(found.place + wide / 2, 1) - np.maximum(found.place - wide / 2, 0)) / wide
    over = light * np.prod(np.maximum(inside, 0), axis=-1)[..., None]
    over[~found.is_whole] = 0
    doubtful = (np.abs(ratio + 0.5 - np.round(ratio + 0.5)) < 1e-3) | (np.abs(inside).min(axis=-1) < 1e-4)
    if inverse_depth is not None:
        over[found.inverse_depth * nearer < inverse_depth] = 0
        doubtful |= np.abs(found.inverse_depth * nearer - inverse_depth) < 1e-5 * np.abs(found.inverse_depth)
    covered = np.maximum(behind[..., 3], over[..., 3]) >= 1 - 1 / 512
    laid = np.concatenate([over[..., :3] + (1 - over[..., 3:]) * behind[..., :3], np.ones_like(over[..., 3:])], axis=2)
    return np.where(covered[..., None], laid, behind), doubtful
