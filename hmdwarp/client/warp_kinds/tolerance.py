"""When neighbouring texels, or two depths of one place, count as one surface.

They do if their inverse depths differ by at most DEPTH_TOLERANCE * (inverse depth + DEPTH_FLOOR).
"""

# Inverse depth is linear across a plane, so between a sampled point and a texel of its footprint it
# changes by at most one pixel's worth of slope. 3 % covers planes seen at up to 80 degrees at 10
# pixels a degree (tan 80 x 0.1 deg = 1 %, on each axis, with the rounding of the client's own
# raster on top); nearer surfaces differ by more than that from those they occlude.
DEPTH_TOLERANCE = 0.03
DEPTH_FLOOR = 0.02  # 1/m: things beyond 50 m count as equally far
