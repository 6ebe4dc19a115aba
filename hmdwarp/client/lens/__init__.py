"""Lens models on the GPU: one file each, registered by name.

Their coefficients belong to the headsets.
"""

from ...registry import Registry
from ._base import LensPass, bind_texels

lenses: Registry[type[LensPass]] = Registry("lens", __name__)

__all__ = ["LensPass", "bind_texels", "lenses"]
