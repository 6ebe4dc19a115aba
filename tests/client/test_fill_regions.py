"""What fills put beyond the border of the rendered view and into disocclusions, with known truth.
Scenes are planes, each with a colour of its own, drawn here by intersecting rays."""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Callable, Iterable

import attrs
import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from reference._rays import project, world_directions
from scipy.ndimage import distance_transform_edt
from scipy.spatial.transform import Rotation

import hmdwarp
from hmdwarp.base import srgb_from_linear
from hmdwarp.client import CLIENT_MODEL
from hmdwarp.client.fills import fills
from hmdwarp.geometry import Fov, Pose, View

WARP = "iterative:frames=1,resample=bilinear"
SIZE, FOV = (160, 120), Fov.symmetric(math.radians(80), math.radians(64))
FILLS = [
    fill.name if fill.complete else f"{fill.name}+pyramid"
    for fill in fills
    if fill.is_pass and CLIENT_MODEL not in fill.reads and not fill.needs(fill.Settings())
    if fill.name != "constant"
]
"""Those that use pictures alone, completed. `constant` is as simple as what they are held to."""
SIMPLE = ("constant", "stretch")
"""What they are held to, beside the mean of the picture, `interpolate` repeated, OpenCV's, and the
nearest pixel inside.
"""
MARGIN_DB = 0.5
ACROSS = ("the hall beside a dark wall leaves the view", "a step beside a post", "a step back from a post, and a turn")
"""Where a strip beyond the border meets an edge of two surfaces, Telea continues the edge;
`pyramid` averages across it, 2 to 5 dB below. Inside these pictures Telea is 7 dB below `pyramid`.
"""
DARK, BRIGHT, RED = (0.02, 0.02, 0.03), (0.9, 0.85, 0.7), (0.5, 0.1, 0.08)
"""Linear light."""

Colours = Callable[[np.ndarray], np.ndarray]


def plain(colour: tuple[float, float, float]) -> Colours:
    """One colour with a soft pattern of a tenth of it."""
    return lambda at: (
        np.array(colour) * (1 + 0.1 * np.sin(9 * at[..., :1]) * np.cos(7 * at[..., 1:2] + 5 * at[..., 2:]))
    )


def striped(at: np.ndarray) -> np.ndarray:
    """Stripes 40 cm wide along z."""
    return np.where(np.sin(at[..., :1] * math.pi / 0.4) > 0, 0.6, 0.1) * np.ones(3)


@attrs.frozen
class Plane:
    """The points where `axis` has the value `at`, and for which `within` holds."""

    axis: int
    at: float
    colour: Colours
    within: Callable[[np.ndarray], np.ndarray] = lambda at: np.ones(at.shape[:-1], bool)


WALL_BEFORE_HALL = (
    Plane(2, -8.0, plain(BRIGHT)),
    Plane(1, -1.6, plain((0.6, 0.55, 0.5))),
    Plane(2, -1.2, plain(DARK), lambda at: at[..., 0] < -0.35),
)
POST_BEFORE_HALL = (*WALL_BEFORE_HALL[:2], Plane(2, -1.0, plain(RED), lambda at: np.abs(at[..., 0]) < 0.25))
FLOOR_UNDER_SKY = (Plane(1, -1.6, striped),)


def turned(left_deg: float, up_deg: float, position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Pose:
    """A head turned to the left, then up."""
    return Pose(position_m, Rotation.from_euler("YX", (left_deg, up_deg), degrees=True).as_quat())


SCENES = {
    "a dark wall before a bright hall leaves the view": (WALL_BEFORE_HALL, turned(20, 0)),
    "the hall beside a dark wall leaves the view": (WALL_BEFORE_HALL, turned(-20, 0)),
    "a striped floor leaves the view": (FLOOR_UNDER_SKY, turned(0, -15)),
    "the sky leaves the view": (FLOOR_UNDER_SKY, turned(0, 15)),
    "a step beside a wall": (WALL_BEFORE_HALL, turned(0, 0, (-0.3, 0.0, 0.0))),
    "a step beside a post": (POST_BEFORE_HALL, turned(0, 0, (0.25, 0.0, 0.1))),
    "a step back from a post, and a turn": (POST_BEFORE_HALL, turned(12, 6, (0.2, 0.0, 0.3))),
}


def drawn(scene: tuple[Plane, ...], view: View) -> tuple[np.ndarray, np.ndarray]:
    """sRGB (h, w, 3) and metres along the view axis (h, w), infinite for the sky; top row first."""
    rays, eye = world_directions(view, SIZE), view.pose.position_m
    colour, depth = np.full((*rays.shape[:2], 3), (0.3, 0.5, 0.9)), np.full(rays.shape[:2], np.inf)
    for plane in scene:
        with np.errstate(divide="ignore", invalid="ignore"):
            away = (plane.at - eye[plane.axis]) / rays[..., plane.axis]
        at = eye + rays * np.where(np.isfinite(away), away, 0)[..., None]
        seen = (away > 0.05) & (away < depth) & plane.within(at)
        colour, depth = np.where(seen[..., None], plane.colour(at), colour), np.where(seen, away, depth)
    return np.round(255 * srgb_from_linear(colour)).astype(np.uint8)[::-1], depth[::-1]


def regions(holes: np.ndarray, depth: np.ndarray, shown: View, rendered: View) -> dict[str, np.ndarray]:
    """The holes whose surface the rendered view contained, and the others; of 50 pixels or more."""
    away = shown.pose.position_m - rendered.pose.position_m
    place, _, w = project(world_directions(shown, SIZE), away, 1 / depth[::-1], rendered, SIZE)
    contained = ((w > 0) & (place >= 0).all(axis=-1) & (place <= SIZE).all(axis=-1))[::-1]
    return {
        name: part for name, part in (("inside", holes & contained), ("border", holes & ~contained)) if part.sum() >= 50
    }


def grown_medians(colour: np.ndarray, holes: np.ndarray) -> np.ndarray:
    """3x3 medians of three neighbours or more, again and again, as `interpolate` takes one."""
    known = np.where(holes[..., None], np.nan, colour.astype(float))
    for _ in range(16):
        padded = np.pad(known, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
        around = sliding_window_view(padded, (3, 3), axis=(0, 1))
        enough = np.isnan(known[..., 0]) & ((~np.isnan(around[:, :, 0])).sum(axis=(-1, -2)) >= 3)
        known[enough] = np.nanmedian(around[enough], axis=(-1, -2))
    return np.nan_to_num(known)


def simple_fills(colour: np.ndarray, holes: np.ndarray, region: str) -> list[np.ndarray]:
    """The mean of what is no hole, 3x3 medians again and again; inside the nearest pixel too.

    Beyond the border that one is hard to beat where surfaces are smooth, and worse than `pyramid`
    on textured ones.
    """
    found = [np.broadcast_to(colour[~holes].mean(axis=0), colour.shape), grown_medians(colour, holes)]
    if region == "inside":
        found.append(colour[tuple(distance_transform_edt(holes, return_distances=False, return_indices=True))])
    return found


def opencv_fill(colour: np.ndarray, holes: np.ndarray) -> list[np.ndarray]:
    """What OpenCV makes of it, after Telea 2004; nothing where it is missing."""
    cv2 = sys.modules.get("cv2") or (importlib.util.find_spec("cv2") and importlib.import_module("cv2"))
    return [cv2.inpaint(np.ascontiguousarray(colour), holes.astype(np.uint8), 3, cv2.INPAINT_TELEA)] if cv2 else []


def psnr_db(colour: np.ndarray, truth: np.ndarray, where: np.ndarray) -> float:
    """Of some pixels of sRGB pictures; 60 for equal ones."""
    return float(-10 * np.log10(np.mean((colour[where] / 255.0 - truth[where] / 255.0) ** 2) + 1e-6))


def of_regions(name: str, tried: Iterable[str]) -> dict[str, tuple[float, dict[str, float]]]:
    """PSNR of each tried fill in each region of a scene, with the best of what they are held to."""
    scene, head = SCENES[name]
    rendered, shown = View(Pose(), FOV), View(head, FOV)
    (colour, depth), (truth, truth_depth) = drawn(scene, rendered), drawn(scene, shown)
    bare = hmdwarp.warp_image(colour, depth, rendered=rendered, shown=shown, warp=WARP, fill="none")
    holes, found = np.asarray(bare.coverage) == 0, {}
    filled = {
        fill: hmdwarp.warp_image(colour, depth, rendered=rendered, shown=shown, warp=WARP, fill=fill).colour
        for fill in {*SIMPLE, *tried}
    }
    for region, part in regions(holes, truth_depth, shown, rendered).items():
        simple = [*simple_fills(bare.colour, holes, region), *map(filled.get, SIMPLE)]
        opencv = [] if region == "border" and name in ACROSS else opencv_fill(bare.colour, holes)
        best = max(psnr_db(picture, truth, part) for picture in (*simple, *opencv))
        found[region] = best, {fill: psnr_db(filled[fill], truth, part) for fill in tried}
    return found


@pytest.mark.parametrize("name", SCENES)
def test_no_fill_is_worse_than_the_simple_ones_in_any_region(name):
    found = of_regions(name, FILLS)
    assert found
    for region, (best, by_fill) in found.items():
        for fill, db in by_fill.items():
            assert db >= best - MARGIN_DB, f"{fill} has {db:.1f} dB in '{region}', a simple fill {best:.1f}"


@pytest.mark.parametrize("fill", FILLS)
def test_a_near_surface_is_as_near_at_the_border_however_little_the_head_has_moved(fill):
    """4 mm are a third of a pixel there, so `sheet` joins the wall with any depth beside it."""
    rendered, shown = View(Pose(), FOV), View(Pose((0.004, 0.004, 0.0)), FOV)
    (colour, depth), (_, truth) = (drawn(WALL_BEFORE_HALL, view) for view in (rendered, shown))
    found = hmdwarp.warp_image(colour, depth, rendered, shown, warp="iterative", fill=fill, depth=True).depth_m
    rim = np.ones(truth.shape, bool)
    rim[2:-2, 2:-2] = False
    # Inverse depth is linear across a plane, and float32 holds it to 1e-7.
    assert np.abs(found / truth - 1)[rim & (truth < 1.3) & ~np.isnan(found)].max() < 1e-3
