from .frame_files import read_frame as read_frame
from .frame_files import read_view as read_view
