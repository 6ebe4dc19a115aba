"""TOML files that people write: typed access to keys, errors with key and line."""

from ._files import parsed, text_of
from ._lines import LineFinder
from ._table import KeyFault, Table, quoted

__all__ = ["KeyFault", "LineFinder", "Table", "parsed", "quoted", "text_of"]
