from .frame_files import FrameFile as FrameFile
from .frame_files import read_frame as read_frame
from .frame_files import read_view as read_view
from .usable import usable_fills as usable_fills
from .usable import usable_warps as usable_warps
from .warper import WarpedImage as WarpedImage
from .warper import WarpedTextures as WarpedTextures
from .warper import Warper as Warper
