from .listener import Views as Views
from .listener import serve as serve
from .listener import serving as serving
from .options import FeedOptions as FeedOptions
