"""Options, each declared once, where it is used, as a field of an attrs class.

The command line, the keys of a study's file, the help and the table of `hmdwarp list options` are
made from the declarations. Neither this package nor a module that declares options imports anything
heavy.
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
