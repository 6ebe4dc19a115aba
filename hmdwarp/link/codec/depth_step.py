"""The unit in which depth is coded: what it moves in the picture that is shown."""

from __future__ import annotations

# m/s. Heads that walk: of 1000 instants of the recording `walk`, one is faster than 0.94.
HEAD_M_S = 1.0
# Pixels by which parallax may be wrong, either way.
PARALLAX_PIXELS = 1 / 16
# 1/m. Coarser steps than the first would part planes that the warps join (0.03 of inverse depth and
# 0.02 per metre together); finer ones than the second would not reach 0.25 m in 16 bits.
COARSEST, FINEST = 2.0**-7, 2.0**-14


def depth_step(pixels_per_tangent: float, age_s: float) -> float:
    """Return the step of inverse depth, 1/m, at which rounding moves no pixel by more than 1/16.

    A wrong inverse depth moves a warped pixel by pixels per tangent * that error * the eye's way
    across the line of sight, the same for every pixel of the picture. The way is what a walking
    head covers while a frame ages; rounding is wrong by half a step. Within COARSEST and FINEST.
    """
    way_px = pixels_per_tangent * HEAD_M_S * age_s
    return min(COARSEST, max(FINEST, 2 * PARALLAX_PIXELS / way_px if way_px > 0 else COARSEST))
