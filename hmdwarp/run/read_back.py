"""Pictures of an eye read back from the GPU. The passes must not be fused with the lens."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..client.compensator import EyeResult
from ..colour import picture_from_linear
from ..gpu.textures import download


def shown_picture(result: EyeResult) -> NDArray[np.uint8]:
    """Return the picture before the lens: (h, w, 3) sRGB, top row first."""
    assert result.shown is not None
    return picture_from_linear(download(result.shown.texture))


def coverage(result: EyeResult) -> NDArray[np.floating]:
    """Return the coverage (h, w) after the warp, before the fill."""
    assert result.warped is not None
    return download(result.warped.texture)[..., 3]
