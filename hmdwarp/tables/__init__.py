"""TOML files that people write: each key is asked for by its type, and what is wrong is told with its full name and its line."""

from ._files import parsed, text_of
from ._lines import LineFinder
from ._table import KeyFault, Table, told

__all__ = ["KeyFault", "LineFinder", "Table", "parsed", "text_of", "told"]
