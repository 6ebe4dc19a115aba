"""Strategies of remote rendering: what crosses the link, and what the client does with it.

Each is a file that names the options of a run which make it up: a table, or a class where it checks
or reads its own settings. The work is done by the layers, warps, fills and effects that these
options name.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ...base import InputError, Registry

# Options that may differ between strategies on the same late frames.
_OF_SHARED_FRAMES = {"warp", "fill", "effects", "indirect"}


class Strategy:
    """One way to divide the work between server and client.

    A subclass names what it is made of. `STRATEGY:key=value` gives the settings to its warp.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    # What is sent for each frame, what the client does with it, and what of the picture is late.
    crosses: ClassVar[str]
    client: ClassVar[str]
    late: ClassVar[str]
    # For whom it is meant: the thesis's classes 1 to 3 (its section 1.3 and its assessments).
    classes: ClassVar[tuple[int, ...]]
    source: ClassVar[str]
    # Figures of others for the nearest system that is published, with their source.
    published: ClassVar[str] = ""
    warp: ClassVar[str]  # The warp; "" where any will do that `check` accepts.
    # The chain of fills; None for the one that usually follows the warp, or the one that was set.
    fill: ClassVar[str | None] = None
    usual: ClassVar[str] = ""  # Settings of the warp where none are given.
    more: ClassVar[Mapping[str, Any]] = {}  # Further options of a run, by name.

    @classmethod
    def options(cls, settings: str) -> dict[str, Any]:
        """Return the options of a run that it sets, by name. settings: 'key=value,key=value' or "".

        Errors: InputError for settings of a strategy that leaves the warp open.
        """
        settings = settings or cls.usual
        if not cls.warp:
            if settings:
                raise InputError(f"strategy '{cls.name}:{settings}': it has no settings; name a warp by --warp")
            return dict(cls.more)
        fill = {} if cls.fill is None else {"fill": cls.fill}
        return {"warp": f"{cls.warp}:{settings}" if settings else cls.warp, **fill, **cls.more}

    @classmethod
    def has_own_link(cls, settings: str) -> bool:
        """Return whether it sets what is sent when, so that no other can share its late frames.

        settings, errors: as options.
        """
        return not cls.options(settings).keys() <= _OF_SHARED_FRAMES

    @classmethod
    def check(cls, said: Mapping[str, Any]) -> None:
        """Check the other options of the run, by name. Errors: InputError."""


def _of_table(name: str, table: dict[str, Any]) -> type[Strategy]:
    return type(name, (Strategy,), {**table, "name": name, "classes": tuple(table["classes"])})


_CHECKED = dict.fromkeys(("depth_image", "proxy"), "checked")
strategies: Registry[type[Strategy]] = Registry(
    "strategy", __name__, of_table=_of_table, modules=_CHECKED, columns="crosses client late"
)


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


def with_strategy(said: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the options that were set, with those that the strategy in it sets.

    said: by option name. Errors: as options_of_strategy; InputError for an option that the strategy
    sets otherwise, its default too.
    """
    text = said.get("strategy")
    if not text:
        return said
    strategy, settings = _parsed(text)
    sets = strategy.options(settings)
    for name, value in sets.items():
        given = said.get(name)
        if given not in (None, value):
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
