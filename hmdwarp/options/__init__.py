"""Options, each declared once, where it is used, as a field of an attrs class.

The command line, the keys of a study's file, the help and the table of `hmdwarp list options` are
made from the declarations. A message about an option names it as the command line does
(Option.flag); who reads a file turns that into the file's key (as_keys). Neither this package nor a
module that declares options imports anything heavy.
"""

from .choice import Choice, NoSettings, parse_choice, parse_settings
from .declared import (
    CONDITION,
    DISPLAY,
    PICTURE,
    Declared,
    Number,
    Option,
    as_keys,
    group,
    names_in,
    one_of,
    option,
    option_of,
    options_of,
    same_as,
)
from .named_files import PICTURE_FILE, RATINGS, keep_inside, opened, text_in
from .paper_fields import PAPER, PAPER_TABLES, PaperOptions
from .shared_fields import (
    AUTO,
    DEFAULT_GUARD,
    FORCE,
    Guard,
    check_one_guard,
    force_field,
    guard_band,
    guard_field,
    out_field,
    parse_guard,
    parse_size,
    path_of,
    rendered_size_field,
    several,
    split_names,
)
from .tables import KeyFault, Table, parsed, quoted, text_of

__all__ = [
    "PAPER",
    "PAPER_TABLES",
    "PaperOptions",
    "KeyFault",
    "Table",
    "parsed",
    "quoted",
    "text_of",
    "AUTO",
    "PICTURE_FILE",
    "RATINGS",
    "keep_inside",
    "opened",
    "text_in",
    "CONDITION",
    "DISPLAY",
    "FORCE",
    "PICTURE",
    "Choice",
    "DEFAULT_GUARD",
    "Declared",
    "Guard",
    "NoSettings",
    "Number",
    "Option",
    "as_keys",
    "check_one_guard",
    "force_field",
    "group",
    "guard_band",
    "guard_field",
    "names_in",
    "one_of",
    "option",
    "option_of",
    "options_of",
    "out_field",
    "parse_choice",
    "parse_settings",
    "parse_guard",
    "parse_size",
    "path_of",
    "rendered_size_field",
    "same_as",
    "several",
    "split_names",
]
