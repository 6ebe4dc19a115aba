from .usable import usable_fills as usable_fills
from .usable import usable_warps as usable_warps
from .warper import WarpedImage as WarpedImage
from .warper import WarpedTextures as WarpedTextures
from .warper import Warper as Warper
