"""Lens models on the GPU: one file each, registered by name.

Their coefficients belong to the headsets.
"""

from ...registry import Registry
from ._base import GPU_DEFINES, SOFTWARE_DEFINES, LensPass, bind_texels

lenses: Registry[type[LensPass]] = Registry("lens", __name__)

__all__ = ["GPU_DEFINES", "SOFTWARE_DEFINES", "LensPass", "bind_texels", "lenses"]
