"""One picture to measure, with everything its figures need, and the measuring itself."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import View
from .flicker import error_image, flicker
from .holes import border_share, hole_share
from .image import check_pair, flip, psnr_db, ssim
from .regions import region_sums


@attrs.frozen(eq=False)
class Compared:
    """What the eye was shown and what it should have seen: two sRGB pictures (h, w, 3), top row first, and their view."""

    shown: NDArray
    truth: NDArray
    view: View

    def __attrs_post_init__(self) -> None:
        check_pair(self.shown, self.truth)

    @property
    def error(self) -> NDArray[np.float32]:
        """The signed error image."""
        return error_image(self.shown, self.truth)


def _covered(coverage: NDArray | None) -> NDArray[np.bool_] | None:
    return None if coverage is None else np.asarray(coverage) != 0


@attrs.frozen(eq=False)
class QualityJob:
    """One eye of one frame, to be measured.

    now: what is measured (after the fill, before the lens). previous: the neighbouring frame of the same eye, for
    flicker; None if there is none. covered: (h, w), coverage after the warp and before the fill, anything but 0 is covered;
    truth_inverse_depth: (h, w) in 1/m in the shown view; rendered, rendered_size: the view and (w, h) of the late frame.
    Without coverage there are no hole figures, without the truth's depth or the rendered view no border figure.
    late: the late frame's picture, only carried along for reports. error_map: whether the FLIP map is wanted too; regions: whether
    it is wanted where the error is (that needs coverage and the truth's depth).
    Errors: InputError for sizes that do not belong together.
    """

    now: Compared
    previous: Compared | None = None
    covered: NDArray[np.bool_] | None = attrs.field(default=None, converter=_covered)
    truth_inverse_depth: NDArray | None = None
    rendered: View | None = None
    rendered_size: tuple[int, int] | None = None
    rendered_picture: NDArray | None = None
    error_map: bool = False
    regions: bool = False

    def __attrs_post_init__(self) -> None:
        size = self.now.shown.shape[:2]
        for name, array in (("coverage", self.covered), ("truth inverse depth", self.truth_inverse_depth)):
            if array is not None and array.shape != size:
                raise InputError(f"{name} is {array.shape}, the picture {size}: wanted the same (h, w)")
        if self.regions and (self.covered is None or self.truth_inverse_depth is None):
            raise InputError(
                "where the error is can be told only with the coverage and the truth's inverse depth: give both"
            )


@attrs.frozen(eq=False)
class QualityResult:
    """`values`: QUALITY names to figures, None where there was nothing to measure; `error_map`: (h, w) bytes, FLIP 0..1 as 0..255;
    `regions`: as metrics.regions.region_sums. The last two only where they were asked for."""

    values: dict[str, float | None]
    error_map: NDArray[np.uint8] | None = None
    regions: dict[str, dict[str, float]] | None = None


def measure(job: QualityJob, pixels_per_degree: float) -> QualityResult:
    """All figures of one job; the same job gives the same bits wherever it runs."""
    now = job.now
    flip_mean, flip_map = flip(now.shown, now.truth, pixels_per_degree)
    values: dict[str, float | None] = {
        "psnr_db": psnr_db(now.shown, now.truth),
        "ssim": ssim(now.shown, now.truth),
        "flip": flip_mean,
        "hole_share": None if job.covered is None else hole_share(job.covered),
        "border_share": _border(job),
        "flicker": None
        if job.previous is None
        else flicker(now.error, now.view, job.previous.error, job.previous.view),
    }
    error_map = np.rint(flip_map * 255).astype(np.uint8) if job.error_map else None
    regions = region_sums(now.shown, now.truth, job.covered, job.truth_inverse_depth, flip_map) if job.regions else None
    return QualityResult(values, error_map, regions)


def _border(job: QualityJob) -> float | None:
    if job.covered is None or job.truth_inverse_depth is None or job.rendered is None or job.rendered_size is None:
        return None
    return border_share(job.covered, job.truth_inverse_depth, job.now.view, job.rendered, job.rendered_size)
