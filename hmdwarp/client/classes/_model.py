"""What a client can do."""

from __future__ import annotations

import math

import attrs

# What the client has of the scene, from nothing to all. reduced: every triangle for depth, and a
# reduced model for colour. whole: the whole scene for colour too.
SCENES = ("none", "reduced", "whole")


@attrs.frozen
class Client:
    """One class of clients."""

    name: str
    summary: str
    source: str
    # One of SCENES.
    scene: str
    # Whether it has compute shaders; without them each pixel can only look things up.
    compute_shaders: bool
    # Whether frames may carry more than colour and inverse depth: peeled layers, a cube, ..
    more_layers: bool
    # For one eye; infinite where the class sets no limit.
    budget_ms: float = math.inf
    # Million pixels of video a second, of both eyes and all layers.
    decoder_mpx_s: float = math.inf
    # From the server, Mbit/s.
    download_mbit_s: float = math.inf

    def has(self, scene: str) -> bool:
        """Return whether it has as much of the scene, one of SCENES."""
        return SCENES.index(self.scene) >= SCENES.index(scene)
