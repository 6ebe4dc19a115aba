"""One picture to measure, with all inputs of its metrics."""

from __future__ import annotations

import functools
from typing import Any, TypeVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import HmdwarpError, InputError
from ..geometry import View
from .flip_map import flip
from .metric_inputs import Input
from .picture_pairs import check_pair, error_image

T = TypeVar("T")


@attrs.frozen(eq=False)
class Compared:
    """What the eye was shown and what it should have seen."""

    # sRGB pictures, (h, w, 3), top row first.
    shown: NDArray
    truth: NDArray
    view: View

    def __attrs_post_init__(self) -> None:
        check_pair(self.shown, self.truth)

    @property
    def error(self) -> NDArray[np.float32]:
        """The signed error image."""
        return error_image(self.shown, self.truth)


def _covered(coverage: NDArray[Any] | None) -> NDArray[np.bool_] | None:
    return None if coverage is None else np.asarray(coverage) != 0


@attrs.frozen(eq=False)
class QualityJob:
    """One eye of one frame to measure. Inputs that are None leave out the metrics that need them.

    Errors: InputError for sizes that do not belong together.
    """

    # After the fill, before the lens.
    now: Compared
    # The neighbouring frame of the same eye.
    previous: Compared | None = None
    # (h, w), coverage after the warp and before the fill; anything but 0 is covered.
    covered: NDArray[np.bool_] | None = attrs.field(default=None, converter=_covered)
    # (h, w), 1/m in the shown view, top row first.
    truth_inverse_depth: NDArray[Any] | None = None
    # View and (w, h) of the late frame.
    rendered: View | None = None
    rendered_size: tuple[int, int] | None = None
    # The late frame's picture, for reports only.
    rendered_picture: NDArray[Any] | None = None
    # Whether the result has the FLIP map.
    error_map: bool = False
    # Whether the result says where the error is; this needs coverage and depth.
    regions: bool = False

    def __attrs_post_init__(self) -> None:
        size = self.now.shown.shape[:2]
        for name, array in (("coverage", self.covered), ("truth inverse depth", self.truth_inverse_depth)):
            if array is not None and array.shape != size:
                raise InputError(f"{name} is {array.shape}, the picture {size}: expected the same (h, w)")
        if self.regions and (Input.COVERAGE | Input.DEPTH) not in self.inputs:
            raise InputError("regions of the error need the coverage and the truth's inverse depth: pass both")

    @property
    def inputs(self) -> Input:
        """The inputs of metrics that the job has."""
        there = Input.TRUTH
        for flag, value in (
            (Input.COVERAGE, self.covered),
            (Input.DEPTH, self.truth_inverse_depth),
            (Input.RENDERED, None if self.rendered is None else self.rendered_size),
            (Input.PREVIOUS, self.previous),
        ):
            if value is not None:
                there |= flag
        return there


@attrs.frozen(eq=False)
class QualityResult:
    """The figures of one job."""

    # By metric; None where nothing could be measured.
    values: dict[str, float | None]
    # (h, w) bytes, FLIP 0..1 as 0..255, if the job requests it.
    error_map: NDArray[np.uint8] | None = None
    # As metrics.regions.region_sums, if the job requests it.
    regions: dict[str, dict[str, float]] | None = None


class Measurement:
    """A job under measurement: the inputs of metrics, and intermediate results that several share.

    Errors: HmdwarpError for an input that the job lacks, because the metric does not declare it.
    """

    def __init__(self, job: QualityJob, pixels_per_degree: float) -> None:
        self._job, self._pixels_per_degree = job, pixels_per_degree
        self.now: Compared = job.now

    @functools.cached_property
    def flip(self) -> tuple[float, NDArray[np.float32]]:
        """Mean FLIP error and its (h, w) map."""
        return flip(self.now.shown, self.now.truth, self._pixels_per_degree)

    @property
    def previous(self) -> Compared:
        """The neighbouring frame."""
        return _declared(self._job.previous, Input.PREVIOUS)

    @property
    def covered(self) -> NDArray[np.bool_]:
        """(h, w): where the warp left no hole."""
        return _declared(self._job.covered, Input.COVERAGE)

    @property
    def truth_inverse_depth(self) -> NDArray[Any]:
        """(h, w), 1/m."""
        return _declared(self._job.truth_inverse_depth, Input.DEPTH)

    @property
    def rendered(self) -> View:
        """View of the late frame."""
        return _declared(self._job.rendered, Input.RENDERED)

    @property
    def rendered_size(self) -> tuple[int, int]:
        """Size (w, h) of the late frame."""
        return _declared(self._job.rendered_size, Input.RENDERED)


def _declared(value: T | None, flag: Input) -> T:
    if value is None:
        raise HmdwarpError(f"a metric reads {flag.name} without declaring it in `needs`")
    return value
