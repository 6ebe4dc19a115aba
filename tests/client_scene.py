"""The client's own geometry for tests: the scene `planes`, drawn by a server of its own."""

from __future__ import annotations

from hmdwarp.scenes import load_scene
from hmdwarp.server import Server


class ClientScene(Server):
    """What a run's rig hands to fills that draw for themselves."""

    def __init__(self, gpu, scene: str = "planes") -> None:
        super().__init__(gpu, load_scene(scene))
