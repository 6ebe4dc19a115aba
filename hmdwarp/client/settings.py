"""What warps, fills, effects and lenses declare: settings with limits, and words in a table."""

from __future__ import annotations

import functools
import math
import tomllib
from pathlib import Path
from typing import Any, TypeVar

import attrs

from ..base import Registry

T = TypeVar("T")
E = TypeVar("E")


class DescribedRegistry(Registry[T]):
    """A registry whose table `_table.toml`, beside its entries, has what they say of themselves.

    An entry of another package says it in its class.
    """

    @functools.cached_property
    def table(self) -> dict[str, dict[str, Any]]:
        """What is said, by the name of the entry."""
        path = Path(__file__).with_name(self.package.rpartition(".")[2]) / "_table.toml"
        return tomllib.loads(path.read_text(encoding="utf-8"))

    def register(self, entry: E) -> E:
        """Add an entry, with its words. See Registry.register."""
        for key, said in self.table.get(entry.name, {}).items():  # type: ignore[attr-defined]
            setattr(entry, key, said)
        return super().register(entry)


def limited(default: float, least: float = 0.0, most: float = math.inf, of: str = "", *, above: bool = False) -> Any:
    """Return a setting from `least` on, or above it, to `most`; of: its unit, or what it counts."""
    if above:
        wanted = f"more than {least:.12g}" + (f" and at most {most:.12g}" if most < math.inf else "")
    else:
        wanted = f"{least:.12g} to {most:.12g}" if most < math.inf else f"{least:.12g} or more"
    wanted += f" {of}" if of else ""

    def check(_: object, field: attrs.Attribute[float], value: float) -> None:
        if not (math.isfinite(value) and (least < value if above else least <= value) and value <= most):
            raise ValueError(f"{field.name} is {value:.12g}: expected {wanted}")

    return attrs.field(default=default, validator=check)


def chosen(*known: str) -> Any:
    """Return a setting that is one of these, by default the first."""
    return attrs.field(default=known[0], validator=attrs.validators.in_(known))
