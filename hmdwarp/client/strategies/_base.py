"""The base class of strategies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ...errors import InputError

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
    # The warp; "" where any will do that `check` accepts.
    warp: ClassVar[str]
    # The chain of fills; None for the one that usually follows the warp, or the one that was said.
    fill: ClassVar[str | None] = None
    # Further options of a run, by name.
    more: ClassVar[Mapping[str, Any]] = {}

    @classmethod
    def options(cls, settings: str) -> dict[str, Any]:
        """Return the options of a run that it sets, by name. settings: 'key=value,key=value' or "".

        Errors: InputError for settings of a strategy that leaves the warp open.
        """
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
