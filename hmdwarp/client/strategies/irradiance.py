"""Irradiance map: direct light is the client's, indirect light comes as an atlas."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Irradiance(Strategy):
    """For scenes whose light moves; one map serves any number of clients."""

    name = "irradiance"
    summary = "the server sends indirect light as an atlas; the client draws the scene with direct light and adds it"
    crosses = "the scene once; an atlas of indirect light"
    client = "draws the scene with direct light at the newest pose, adds indirect light"
    late = "indirect light"
    classes = (3,)
    source = "Crassin et al. 2013, CloudLight"
    warp = "irradiance"
    fill = "none"
