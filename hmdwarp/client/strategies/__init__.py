"""Strategies of remote rendering: what crosses the link, and what the client does with it.

Each is a file that names the options of a run which make it up. The work is done by the layers,
warps, fills and effects that these options name.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...errors import InputError
from ...registry import Registry
from ._base import Strategy

strategies: Registry[type[Strategy]] = Registry("strategy", __name__)


def options_of_strategy(text: str) -> dict[str, Any]:
    """Return the options that a strategy sets, by name. text: 'name' or 'name:key=value'.

    Errors: UnknownNameError for the name; InputError for settings that it does not take.
    """
    strategy, settings = _parsed(text)
    return strategy.options(settings)


def has_own_link(text: str) -> bool:
    """Return whether a strategy's late frames are its own. text, errors: as options_of_strategy."""
    strategy, settings = _parsed(text)
    return strategy.has_own_link(settings)


def with_strategy(said: Mapping[str, Any], defaults: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return what was said, with the options that the strategy in it sets.

    said, defaults: by option name; an option at its default counts as not said. Errors: as
    options_of_strategy; InputError for an option that the strategy sets otherwise.
    """
    text = said.get("strategy")
    if not text:
        return said
    strategy, settings = _parsed(text)
    sets = strategy.options(settings)
    for name, value in sets.items():
        given = said.get(name)
        if given not in (None, value, defaults.get(name)):
            raise InputError(
                f"--{name.replace('_', '-')} {given} beside --strategy {text}, which sets it to '{value}': leave one "
                "of the two out"
            )
    strategy.check({**said, **sets})
    return {**said, **sets}


def _parsed(text: str) -> tuple[type[Strategy], str]:
    name, colon, settings = (part.strip() for part in text.partition(":"))
    if colon and not settings:
        raise InputError(f"strategy '{text}': expected settings after the colon, as in {name}:key=value")
    return strategies.get(name), settings


__all__ = ["Strategy", "has_own_link", "options_of_strategy", "strategies", "with_strategy"]
