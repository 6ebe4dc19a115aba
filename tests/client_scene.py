"""The client's own geometry for tests: the scene `planes`, drawn by a server of its own."""

from __future__ import annotations

import hmdwarp.client
from hmdwarp.scenes import Scene, load_scene
from hmdwarp.sources.server import Server


class ClientScene(hmdwarp.client.ClientScene):
    """What a replay hands to fills that draw for themselves; conftest closes it after its test."""

    open_ones: list[ClientScene] = []  # in the order in which they were made

    def __init__(self, gpu, scene: str | Scene = "planes") -> None:
        super().__init__(Server(gpu, load_scene(scene) if isinstance(scene, str) else scene))
        self.open_ones.append(self)

    def close(self) -> None:
        """Close it and its server."""
        if self in self.open_ones:
            self.open_ones.remove(self)
            super().close()
            self.server.close()
