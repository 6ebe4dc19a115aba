"""The picture around where the eye looks: its PSNR, and how late the gaze that frames had was."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..geometry import View, gaze_tangent
from ..gpu.textures import flip_rows
from ..metrics import Compared, psnr_db

# Degrees from the gaze: the fovea and what is nearly as sharp (Strasburger, Rentschler and Jüttner
# 2011, Peripheral vision and pattern recognition: a review).
NEAR_DEG = 5.0


@attrs.define
class NearGaze:
    """Figures of measured pictures whose gaze is known, or asked for."""

    _psnr_db: list[float] = attrs.field(factory=list)
    _off_deg: list[float] = attrs.field(factory=list)

    def add(self, now: Compared, shown: View, rendered: View) -> None:
        """Take a picture in. shown: of the eye, with its gaze at that instant. rendered: drawn."""
        near = flip_rows(near_gaze(shown, now.shown.shape[1::-1]))
        if near.any():
            # As a picture one pixel high.
            self._psnr_db.append(psnr_db(now.shown[near][None], now.truth[near][None]))
        ahead, then = _in_world(shown), _in_world(rendered)
        self._off_deg.append(math.degrees(math.acos(min(1.0, float(ahead @ then)))))

    def entry(self) -> dict[str, Any]:
        """Return the `gaze` of summary.json.

        psnr_db: mean over pictures, within within_deg of the gaze. off_deg: between the gaze when
        the picture is seen and the one that its frame was drawn for, both in the world.
        """
        if not self._off_deg:
            return {}
        off = {f"p{share}": float(np.percentile(self._off_deg, share)) for share in (50, 95)}
        psnr = math.fsum(self._psnr_db) / len(self._psnr_db) if self._psnr_db else None
        return {"gaze": {"within_deg": NEAR_DEG, "psnr_db": psnr, "off_deg": off}}


def near_gaze(view: View, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Return (h, w), the bottom row first: which pixels lie near the gaze."""
    ray = np.array([*gaze_tangent(view), -1.0])
    rays = view.rays(size)
    cosine = rays @ (ray / np.linalg.norm(ray)) / np.linalg.norm(rays, axis=-1)
    return np.asarray(cosine >= math.cos(math.radians(NEAR_DEG)))


def _in_world(view: View) -> NDArray[np.float64]:
    x, y = gaze_tangent(view)
    ray = view.pose.rotation_matrix @ np.array([x, y, -1.0])
    return np.asarray(ray / np.linalg.norm(ray))
