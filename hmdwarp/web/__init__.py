"""The browser as a client: its page, and the door through which it speaks the feed."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
