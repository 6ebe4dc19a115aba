"""How far the shown picture is from the truth: error, holes, flicker; measured in other processes, then summed up.

Pictures are sRGB-encoded, (h, w, 3), top row first; holes are black pixels and count.
"""

QUALITY = ("psnr_db", "ssim", "flip", "hole_share", "border_share", "flicker")
STAGES = ("warp", "fill", "effects", "lens", "total")
