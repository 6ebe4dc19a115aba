from .options import FeedOptions as FeedOptions
from .serving import Views as Views
from .serving import serve as serve
from .serving import serving as serving
