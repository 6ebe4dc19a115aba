"""A scene as a client knows it: what moves is where the last state that arrived puts it."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..geometry import RigidState
from ._mesh import Body
from ._scene import Scene
from .motions import swing_m

Array = NDArray[np.float64]


@attrs.define(eq=False)
class ArrivedState:
    """The instant of the newest state that has arrived; at first of the scene as it was sent."""

    extrapolates: bool
    newest_ns: int = 0

    def take(self, drawn_ns: int) -> None:
        """Take the state of an instant; an older one than the newest changes nothing."""
        self.newest_ns = max(self.newest_ns, drawn_ns)

    def known(self, time_ns: int) -> tuple[int, int]:
        """Return the instant whose state stands for `time_ns`, and for how long it goes on."""
        known_ns = min(time_ns, self.newest_ns)
        return known_ns, time_ns - known_ns if self.extrapolates else 0


@attrs.frozen(eq=False)
class _Arrived:
    """A motion, a brightness or a deformation by what has arrived of it."""

    whole: Any
    arrived: ArrivedState

    def state(self, time_ns: int) -> RigidState:
        known_ns, age_ns = self.arrived.known(time_ns)
        state: RigidState = self.whole.state(known_ns)
        if not self.arrived.extrapolates and known_ns < time_ns:
            return RigidState(state.pose)
        velocity = state.velocity_m_s + age_ns * 1e-9 * state.acceleration_m_s2
        return attrs.evolve(state, pose=state.after(age_ns), velocity_m_s=velocity)

    def share(self, time_ns: int) -> float:
        return float(self.whole.share(self.arrived.known(time_ns)[0]))

    def positions(self, time_ns: int) -> Array:
        known_ns, age_ns = self.arrived.known(time_ns)
        positions: Array = self.whole.positions(known_ns)
        return positions + swing_m(self.whole.velocities(known_ns), age_ns) if age_ns else positions

    def velocities(self, time_ns: int) -> Array:
        known_ns, age_ns = self.arrived.known(time_ns)
        velocities: Array = self.whole.velocities(known_ns)
        return velocities if known_ns == time_ns or age_ns else np.zeros_like(velocities)


def moves(scene: Scene) -> bool:
    """Return whether bodies, lamps or vertices of the scene move."""
    return bool(scene.bodies or scene.lamps or any(mesh.deformation is not None for mesh in scene.meshes))


def as_arrived(scene: Scene, arrived: ArrivedState) -> Scene:
    """Return the scene in which all that moves is known by the states that have arrived.

    States are exact, with speed, of bodies also with acceleration; later than the newest, bodies
    and lamps go on as RigidState.after says, vertices as motions.swing_m, lamps stay as bright.
    """

    def arrives(whole: Any) -> Any:
        return None if whole is None else _Arrived(whole, arrived)

    return attrs.evolve(
        scene,
        bodies=[Body(body.name, arrives(body.motion)) for body in scene.bodies],
        lamps=[
            attrs.evolve(lamp, motion=arrives(lamp.motion), brightness=arrives(lamp.brightness)) for lamp in scene.lamps
        ],
        meshes=[
            mesh if mesh.deformation is None else attrs.evolve(mesh, deformation=arrives(mesh.deformation))
            for mesh in scene.meshes
        ],
    )
