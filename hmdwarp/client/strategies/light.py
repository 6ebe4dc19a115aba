"""Light only: the picture is light, and the client draws the textures."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Light(Strategy):
    """Textures are never resampled, so they stay sharp; the light is late."""

    name = "light"
    summary = "the server sends light alone with depth; the client warps it and draws the textures at the newest pose"
    crosses = "light and depth"
    client = "warps the light, draws the scene's albedo, multiplies"
    late = "light, and what hides it"
    classes = (3,)
    source = "the 2014 thesis, section 7"
    warp = "iterative"
    more = {"effects": "light_only"}
