"""Photons of indirect light: those bundles whose lamp has changed since they were sent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ....frames.layers.photons import (
    CUBE_BYTES,
    BundleSender,
    Cube,
    PhotonMap,
    PhotonUpdate,
    Sent,
    bundle_bytes,
    packed,
)
from ....geometry import View
from ....scenes import (
    Light,
    PhotonTracer,
    Scene,
    kernel_factors,
    lamps_at,
    light_keys,
    octahedral,
    of_atlas,
    receivers_of,
    transport_of,
)
from ....scenes import Photons as TracedPhotons
from . import Drawing, parts
from ._sending import Sending

# Paths traced for one frame, at most: many of a sun's and of the sky's bring nothing in.
MOST_TRACED = 1 << 16


@parts.register
class Photons(Sending[PhotonMap, "_Sender"]):
    """One sender for each PhotonMap that frames need. Without lamps there are no photons."""

    name = "photons"
    order = 131

    def make_sender(self, wanted: PhotonMap) -> _Sender:
        return _Sender(self.context.scene, wanted)

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        updates = {wanted: self.sender(wanted).update(drawing.time_ns) for wanted in self.needed(drawing)}
        return {"photons": updates} if updates else {}


class _Sender:
    """The bundles of one PhotonMap: those of each lamp, then those of the sky."""

    def __init__(self, scene: Scene, wanted: PhotonMap) -> None:
        self._scene, self._wanted = scene, wanted
        self._tracers: list[PhotonTracer] = []
        if scene.lamps:
            self._prepare()
        # The tracer of each bundle, and the bundle's number there.
        self._bundles = [(k, bundle) for k, tracer in enumerate(self._tracers) for bundle in range(tracer.bundles)]
        self.book = BundleSender(len(self._bundles))
        # Whether all photons of the light as it was at the last frame have been sent.
        self._complete = False

    def has_more(self, now_ns: int) -> bool:
        """Return whether photons wait to be sent."""
        return not self._complete

    def _prepare(self) -> None:
        scene = self._scene
        self._transport = transport_of(scene)
        self._factors = kernel_factors(self._transport, self._wanted.radius)
        for light, _ in light_keys(lamps_at(scene, 0), scene.background):
            bundles = self._wanted.bundles(opened=light is None or not light[0][3])
            paths = self._wanted.paths_of_bundle
            self._tracers.append(PhotonTracer(self._transport, scene.background, paths, bundles))

    def update(self, now_ns: int) -> PhotonUpdate:
        """Return what a frame drawn now brings."""
        self.book.settle(now_ns)
        out, sent = bytearray(), []
        left, traced = self._wanted.budget - CUBE_BYTES, 0
        lights = self._lights(now_ns) if self._tracers else []
        state_of = [lights[k][1] for k, _ in self._bundles]
        stale = self.book.stale(state_of)
        largest = bundle_bytes(self._wanted.paths_of_bundle)
        while stale and left >= largest and traced < MOST_TRACED:
            # Of one lamp, as many as surely fit.
            of = self._bundles[stale[0]][0]
            batch = [bundle for bundle in stale[: left // largest] if self._bundles[bundle][0] == of]
            traced += len(batch) * self._wanted.paths_of_bundle
            for bundle, found in zip(batch, self._traced(lights[of][0], batch), strict=True):
                entered = self.book.sent(bundle, state_of[bundle], empty=not len(found))
                if entered is not None:
                    out += self._packed(entered, found)
                    sent.append(entered)
            left = self._wanted.budget - CUBE_BYTES - len(out)
            stale = [bundle for bundle in stale if bundle not in batch]
        self._complete = not stale
        start = self._cube.packed(whole=self.book.whole)
        return PhotonUpdate(np.frombuffer(start + bytes(out), np.uint8).copy(), tuple(sent))

    def _lights(self, now_ns: int) -> list[tuple[Light | None, bytes]]:
        receivers = receivers_of(self._scene, now_ns)
        for tracer in self._tracers:
            tracer.receivers = receivers
        moved = receivers.blockers.corners.tobytes() if self._scene.lit_moves else b""
        return light_keys(lamps_at(self._scene, now_ns), self._scene.background, moved)

    def _traced(self, light: Light | None, bundles: Sequence[int]) -> list[TracedPhotons]:
        """Return the photons of some bundles of one lamp."""
        of, numbers = self._bundles[bundles[0]][0], [self._bundles[bundle][1] for bundle in bundles]
        return [photons.at_most(self._wanted.most_photons) for photons in self._tracers[of].trace(light, numbers)]

    def _packed(self, entered: Sent, found: TracedPhotons) -> bytes:
        powers = found.powers * of_atlas(self._factors, found.texels)
        return packed(entered, (found.places - self._cube.low) / self._cube.edge, octahedral(found.normals), powers)

    @cached_property
    def _cube(self) -> Cube:
        """The cube around all lit surfaces, rounded as it is sent."""
        if not self._tracers:
            return Cube(np.zeros(3), 1.0)
        corners = self._transport.blockers.corners.reshape(-1, 3)
        low = corners.min(axis=0).astype(np.float32).astype(np.float64)
        return Cube(low, float(np.float32(max((corners - low).max(), 1e-6))))
