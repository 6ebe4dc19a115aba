"""Several depth images: the server chooses from where, and sends only what has changed."""

from __future__ import annotations

from typing import Any

from . import Strategy, strategies


@strategies.register
class Views(Strategy):
    """The pictures together are to show what the eye may come to see."""

    name = "views"
    summary = (
        "the server draws further pictures from places that the eye may come to, and sends frames only when something "
        "has moved; the client composites them with those that it has"
    )
    crosses = "colour and depth of several views, when something has moved; layers of effects"
    client = "warps several pictures and keeps the nearest"
    late = "what was hidden from all views"
    classes = (3,)
    source = "the 2014 thesis, section 3.5"
    warp = "multi"
    more = {"send": "changes"}

    @classmethod
    def options(cls, settings: str) -> dict[str, Any]:
        """Return the options that it sets. settings: of warp `multi`, in place of its own."""
        return super().options(settings or "views=2,frames=1,eye=own")
