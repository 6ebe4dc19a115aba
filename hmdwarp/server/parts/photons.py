"""Photons of indirect light: those bundles whose lamp has changed since they were sent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...frames.layers.photons import PhotonMap
from ...frames.photon_bundles import (
    BundleSender,
    PhotonUpdate,
    bundle_bytes,
    packed,
    packed_cube,
)
from ...scenes import PhotonTracer, factor_atlas, lamps_at, light_keys, octahedral, of_atlas, transport_of
from . import parts
from ._base import DrawContext, Drawing, Part

if TYPE_CHECKING:
    from ...frames import EyeImage, Frame
    from ...geometry import View
    from ...scenes import Light, Scene
    from ...scenes import Photons as TracedPhotons

# Paths traced for one frame, at most: many of a sun's and of the sky's bring nothing in.
MOST_TRACED = 1 << 15


@parts.register
class Photons(Part):
    """One sender for each PhotonMap that frames need. Without lamps there are no photons."""

    name = "photons"
    order = 131

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._senders = dict[PhotonMap, _Sender]()

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        updates = {}
        for wanted in sorted(drawing.needs.get("photons", frozenset())):
            if wanted not in self._senders:
                self._senders[wanted] = _Sender(self.context.scene, wanted)
            updates[wanted] = self._senders[wanted].update(drawing.time_ns)
        return {"photons": updates} if updates else {}

    def heard(self, frame: Frame, arrived: bool, heard_ns: int) -> None:
        updates: Mapping[PhotonMap, PhotonUpdate] = frame.eyes[0].get("photons", {})
        for wanted, update in updates.items():
            self._senders[wanted].book.heard(update, arrived, heard_ns)

    def has_more(self, now_ns: int) -> bool:
        return any(not sender.complete for sender in self._senders.values())


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
        self.complete = False

    def _prepare(self) -> None:
        scene = self._scene
        self._transport = transport_of(scene)
        self._factors = factor_atlas(self._transport, self._wanted.radius)[..., 0].astype(np.float64)
        for light, _ in light_keys(lamps_at(scene, 0), scene.background):
            bundles = self._wanted.bundles(opened=light is None or not light[0][3])
            paths = self._wanted.paths_of_bundle
            self._tracers.append(PhotonTracer(self._transport, scene.background, paths, bundles))

    def update(self, now_ns: int) -> PhotonUpdate:
        """Return what a frame drawn now brings."""
        self.book.settle(now_ns)
        out = bytearray(packed_cube(*self._cube))
        sent = []
        left, traced = self._wanted.budget, 0
        lights = light_keys(lamps_at(self._scene, now_ns), self._scene.background) if self._tracers else []
        told_by = [lights[k][1] for k, _ in self._bundles]
        stale = self.book.stale(told_by)
        for done, bundle in enumerate(stale):
            tracer = self._tracers[self._bundles[bundle][0]]
            if left - len(out) < bundle_bytes(tracer.paths) or traced >= MOST_TRACED:
                stale = stale[done:]
                break
            traced += tracer.paths
            found = self._traced(tracer, lights[self._bundles[bundle][0]][0], self._bundles[bundle][1])
            entered = self.book.sent(bundle, told_by[bundle], empty=not len(found))
            if entered is not None:
                low, edge = self._cube
                powers = found.powers * of_atlas(self._factors, found.texels)[:, None]
                out += packed(entered, (found.places - low) / edge, octahedral(found.normals), powers)
                sent.append(entered)
        else:
            stale = []
        self.complete = not stale
        return PhotonUpdate(np.frombuffer(bytes(out), np.uint8).copy(), tuple(sent))

    def _traced(self, tracer: PhotonTracer, light: Light | None, bundle: int) -> TracedPhotons:
        return tracer.trace(light, bundle).at_most(self._wanted.most_photons)

    @cached_property
    def _cube(self) -> tuple[NDArray[np.float64], float]:
        """Lowest corner and edge of the cube around all lit surfaces, as they are sent."""
        if not self._tracers:
            return np.zeros(3), 1.0
        corners = self._transport.blockers.corners.reshape(-1, 3)
        low = corners.min(axis=0).astype(np.float32).astype(np.float64)
        return low, float(np.float32(max((corners - low).max(), 1e-6)))
