"""Photons of indirect light for a client that keeps them."""

from __future__ import annotations

import attrs

from ..photon_bundles import OPEN, PHOTONS_A_PATH, paths_of_bundle
from . import Delivered, layers


@attrs.frozen(order=True)
class PhotonMap:
    """Photons that are delivered bundle by bundle, and replaced as the light changes."""

    # Bytes of each frame, at most, before they are packed.
    budget: int = 60_000
    # Paths that a lamp sends, rounded up to a power of 2; a sun and the sky send more.
    paths: int = 1 << 13
    # Metres that a photon lights around it.
    radius: float = 0.8

    @property
    def paths_of_bundle(self) -> int:
        """How many paths each bundle has: any bundle fits the budget."""
        return paths_of_bundle(self.budget)

    def bundles(self, *, opened: bool) -> int:
        """Return how many bundles a lamp has. opened: a sun or the sky, not a point."""
        whole = 1 << max(self.paths - 1, 0).bit_length()
        return max(1, whole * (OPEN if opened else 1) // self.paths_of_bundle)

    @property
    def most_photons(self) -> int:
        """How many photons a bundle holds at most."""
        return PHOTONS_A_PATH * self.paths_of_bundle


@layers.register
class Photons(Delivered):
    """A PhotonUpdate for each PhotonMap. The amount is the frozenset of them."""

    name = "photons"
    summary = "indirect light as photons, packed in bundles: only those whose lamp has changed, the oldest first"
    drawn_by = "photons"
    something = frozenset({PhotonMap()})
