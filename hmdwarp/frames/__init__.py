"""Frames: what the server drew, with the exact views it was drawn for.

The kinds of layers are registered in frames.layers.
"""

from .frame import EyeImage as EyeImage
from .frame import Frame as Frame
from .frame import Needs as Needs
from .frame import Others as Others
from .frame import frame_bytes as frame_bytes
from .frame import video_pixels as video_pixels
from .layers import EyeSizes as EyeSizes
from .layers import Surface as Surface
from .layers.pictures import BodyIds as BodyIds
from .layers.pictures import Mirrored as Mirrored
from .layers.pictures import Reflection as Reflection
from .layers.pictures import Transparent as Transparent
