"""Options, each declared once, where it is used, as a field of an attrs class.

The command line, the keys of a study's file, the help and the table of `hmdwarp list options` are
made from the declarations. A message about an option names it as the command line does
(Option.flag); who reads a file turns that into the file's key (as_keys). Neither this package nor a
module that declares options imports anything heavy.
"""

from .choice import Choice as Choice
from .choice import NoSettings as NoSettings
from .choice import parse_choice as parse_choice
from .choice import parse_settings as parse_settings
from .declared import CONDITION as CONDITION
from .declared import DISPLAY as DISPLAY
from .declared import PICTURE as PICTURE
from .declared import Declared as Declared
from .declared import Number as Number
from .declared import Option as Option
from .declared import as_keys as as_keys
from .declared import as_path as as_path
from .declared import group as group
from .declared import names_in as names_in
from .declared import one_of as one_of
from .declared import option as option
from .declared import option_of as option_of
from .declared import options_of as options_of
from .declared import same_as as same_as
from .named_files import PICTURE_FILE as PICTURE_FILE
from .named_files import RATINGS as RATINGS
from .named_files import keep_inside as keep_inside
from .named_files import opened as opened
from .named_files import text_in as text_in
from .shared_fields import AUTO as AUTO
from .shared_fields import DEFAULT_GUARD as DEFAULT_GUARD
from .shared_fields import FORCE as FORCE
from .shared_fields import PAPER as PAPER
from .shared_fields import PAPER_TABLES as PAPER_TABLES
from .shared_fields import Guard as Guard
from .shared_fields import PaperOptions as PaperOptions
from .shared_fields import check_one_guard as check_one_guard
from .shared_fields import force_field as force_field
from .shared_fields import guard_band as guard_band
from .shared_fields import guard_field as guard_field
from .shared_fields import out_field as out_field
from .shared_fields import parse_guard as parse_guard
from .shared_fields import parse_size as parse_size
from .shared_fields import path_of as path_of
from .shared_fields import rendered_size_field as rendered_size_field
from .shared_fields import several as several
from .shared_fields import split_names as split_names
from .tables import KeyFault as KeyFault
from .tables import Table as Table
from .tables import fields_in as fields_in
from .tables import parsed as parsed
from .tables import quoted as quoted
from .tables import read_by as read_by
from .tables import text_of as text_of
