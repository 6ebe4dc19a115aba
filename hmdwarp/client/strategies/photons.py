"""Photons: direct light is the client's, indirect light comes as photons that it splats."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Photons(Strategy):
    """For scenes whose light moves, and clients that are fast: surfaces need no atlas for it."""

    name = "photons"
    summary = "the server sends indirect light as photons; the client draws the scene with direct light, splats them"
    crosses = "the scene once; photons, of what has changed"
    client = "draws the scene with direct light at the newest pose, splats photons as indirect light"
    late = "indirect light"
    classes = (3,)
    source = "Crassin et al. 2013, CloudLight"
    warp = "photons"
    fill = "none"
