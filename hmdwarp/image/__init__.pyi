from .frame_files import FrameFile as FrameFile
from .frame_files import read_frame as read_frame
from .frame_files import read_view as read_view
from .warping import usable_fills as usable_fills
from .warping import usable_warps as usable_warps
