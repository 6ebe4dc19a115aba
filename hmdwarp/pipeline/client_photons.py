"""The photons that a client has got, on the GPU."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..frames.photon_bundles import PHOTON_BYTES, BundleRoom, Cube, unpacked
from ..scenes import lamps_at, light_keys

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frames.layers.photons import PhotonMap
    from ..gpu.context import Gpu
    from ..scenes import Scene
    from .scene_under_light import SceneUnderPhotons


class ClientPhotons:
    """The client.ReceivedPhotons of one PhotonMap. The buffer for all is allocated at once."""

    def __init__(self, gpu: Gpu, scene: SceneUnderPhotons, wanted: PhotonMap) -> None:
        self._wanted, self._room, self.scene = wanted, BundleRoom(), scene
        self.origin_m, self.cube, self.count = scene.scene.origin_m, Cube(np.zeros(3), 1.0), 0
        self.photons = gpu.gl.buffer(reserve=PHOTON_BYTES * max(1, most_photons(scene.scene, wanted)))
        self.bytes = 0
        self.first_picture_bytes: int | None = None

    def receive(self, content: NDArray[np.uint8]) -> None:
        """Take what a frame brought; frames may come in any order, and more than once."""
        if not len(content):
            return
        whole, self.cube, bundles = unpacked(content)
        self.bytes += len(content)
        if whole and self.first_picture_bytes is None:
            self.first_picture_bytes = self.bytes
        if sum(self._room.take(sent, words) for sent, words in bundles):
            words = self._room.words()
            self.count = len(words)
            self.photons.write(words.tobytes())

    def weight(self) -> dict[str, Any]:
        """Return what has crossed before packing, in bytes, and what the client holds."""
        return {
            "budget": self._wanted.budget,
            "geometry_bytes": self.photons.size,
            "texture_bytes": 0,
            "start_up_bytes": 0,
            "first_picture_bytes": self.first_picture_bytes,
            "arrived_bytes": self.bytes,
            "photons": self.count,
        }

    def close(self) -> None:
        """Free the buffer."""
        self.photons.release()


def most_photons(scene: Scene, wanted: PhotonMap) -> int:
    """Return how many photons there can be at most."""
    lights = [light for light, _ in light_keys(lamps_at(scene, 0), scene.background)]
    bundles = sum(wanted.bundles(opened=light is None or not light[0][3]) for light in lights)
    return bundles * wanted.most_photons
