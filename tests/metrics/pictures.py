"""Small pictures and views for the tests of this folder."""

import math

import numpy as np
from flip_evaluator import evaluate
from scipy.ndimage import map_coordinates
from skimage.metrics import structural_similarity

from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.metrics import Alike, Compared, QualityJob, error_image

FOV = Fov(-0.7, 0.6, -0.5, 0.55)


def noise(seed: int, size=(40, 30)) -> np.ndarray:
    """A random uint8 picture of (w, h)."""
    return np.random.default_rng(seed).integers(0, 256, (size[1], size[0], 3), dtype=np.uint8)


def smooth(size=(96, 64), phase=0.0) -> np.ndarray:
    """A soft uint8 picture of (w, h), different in each channel."""
    y, x = np.mgrid[: size[1], : size[0]] / max(size)
    waves = [np.sin(9 * x + phase), np.cos(7 * y + 2 * phase), np.sin(5 * (x + y) - phase)]
    return np.rint(np.stack([127 + 100 * w for w in waves], axis=-1)).astype(np.uint8)


def turned(yaw_rad: float, pitch_rad: float = 0.0, roll_rad: float = 0.0, position_m=(0, 0, 0)) -> View:
    """A view turned about up, right and forward."""
    from scipy.spatial.transform import Rotation

    return View(Pose(position_m, Rotation.from_euler("YXZ", [yaw_rad, pitch_rad, roll_rad]).as_quat()), FOV)


def job(seed: int, size=(40, 30)) -> QualityJob:
    """A job in which every figure has something to measure."""
    rng = np.random.default_rng(seed)
    now = Compared(noise(seed, size), noise(seed + 1000, size), turned(0.01 * seed))
    previous = Compared(noise(seed + 2000, size), noise(seed + 3000, size), turned(0.01 * seed + math.radians(1)))
    covered = rng.random((size[1], size[0])) > 0.2
    inverse_depth = rng.random((size[1], size[0])).astype(np.float32)
    return QualityJob(
        now, previous, covered, inverse_depth, turned(0.2, position_m=(0.05, 0, 0)), size,
        rendered_picture=noise(seed + 4000, size),
        alike=Alike(rng.random((size[1], size[0])).astype(np.float32), rng.uniform(-1, 1), rng.random()),
    )  # fmt: skip


def flip(shown: np.ndarray, truth: np.ndarray, pixels_per_degree: float) -> tuple[float, np.ndarray]:
    """Mean FLIP error of two byte pictures and its (h, w) map, by its authors' library."""
    reference, test = (np.ascontiguousarray(picture, np.float32) / np.float32(255) for picture in (truth, shown))
    parameters = {"ppd": float(pixels_per_degree)}
    how = {"inputsRGB": True, "applyMagma": False, "computeMeanError": False}
    error = evaluate(reference, test, "LDR", **how, parameters=parameters)[0][..., 0]
    return float(error.mean(dtype=np.float64)), error


def ssim(shown: np.ndarray, truth: np.ndarray) -> float:
    """Mean SSIM of two byte pictures by scikit-image, the mirrored border included."""
    # It refuses pictures smaller than its window.
    wide = [np.pad(picture, ((11, 11), (11, 11), (0, 0)), mode="symmetric") for picture in (shown, truth)]
    how = {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False, "full": True}
    _, every = structural_similarity(*wide, channel_axis=2, data_range=255, **how)
    return float(every[11:-11, 11:-11].mean())


def flicker(now: Compared, before: Compared) -> float | None:
    """The figure in float64, all pixels at once by map_coordinates."""
    high, wide = now.shown.shape[:2]
    x, y = np.meshgrid(np.arange(wide) + 0.5, np.arange(high) + 0.5)
    mapping = WarpMap.between(now.view, (wide, high), before.view, (wide, high))
    at, _, _ = mapping.apply(np.stack([x, y], axis=-1), np.zeros(x.shape))
    column, row = np.moveaxis(at - 0.5, -1, 0).round(9)  # an unmoved head keeps its outermost pixels
    both = (column >= 0) & (column <= wide - 1) & (row >= 0) & (row <= high - 1) & now.view.seen((wide, high))[::-1]
    place = row[both], column[both]
    seen = before.view.seen((wide, high))[::-1][tuple(np.rint(place).astype(int))]
    was, error = (error_image(one.shown, one.truth) for one in (before, now))
    earlier = [map_coordinates(channel[::-1].astype(float), place, order=1) for channel in np.moveaxis(was, 2, 0)]
    change = np.abs(error[::-1][both] - np.stack(earlier, axis=-1))[seen]
    return float(change.mean()) if change.size else None
