"""Errors of the shown picture against the truth: quality, holes, flicker.

    hmdwarp.metrics.psnr(shown, truth), .ssim(shown, truth), .flip(shown, truth, pixels_per_degree)

Pictures are sRGB-encoded, (h, w, 3), top row first; holes are black and count.
"""

import lazy_loader

__getattr__, _, _ = lazy_loader.attach_stub(__name__, __file__)
__all__ = ["flip", "psnr", "ssim"]


def __dir__() -> list[str]:
    return __all__
