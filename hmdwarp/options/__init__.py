"""Options: each is declared once, where it is used, as a field of an attrs class.

The command line, the keys of a study's file, the help and the table of `hmdwarp list options` are
made from the declarations. This package imports nothing heavy, nor does a module that declares.
"""

from .declared import CONDITION, DISPLAY, PICTURE, Declared, Option, group, option, option_of, options_of, same_as
from .limits import Number, names_in, one_of
from .several import several, split_names

__all__ = [
    "CONDITION",
    "DISPLAY",
    "PICTURE",
    "Declared",
    "Number",
    "Option",
    "group",
    "names_in",
    "one_of",
    "option",
    "option_of",
    "options_of",
    "same_as",
    "several",
    "split_names",
]
