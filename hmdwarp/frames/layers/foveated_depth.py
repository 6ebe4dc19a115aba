"""Inverse depth of the picture that is sharp where the eye looks and coarser beyond."""

from . import layers
from .foveated import FoveatedLayer


@layers.register
class FoveatedDepth(FoveatedLayer):
    """In 1/m: of the pixels that one of the rim holds, the mean over their nearest surface."""

    name = "foveated_depth"
    summary = "inverse depth of the rendered picture, coarser away from where the eye looks"
    formats = ("r32f",)
