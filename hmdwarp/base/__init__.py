"""What every part may use: errors, registries, colour, and options.

An option is declared once, where it is used, as a field of an attrs class.

The command line, the keys of a study's file, the help and the table of `hmdwarp list options` are
made from the declarations. A message about an option names it as the command line does
(Option.flag); who reads a file turns that into the file's key (as_keys). Neither this package nor a
module that declares options imports anything heavy.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
