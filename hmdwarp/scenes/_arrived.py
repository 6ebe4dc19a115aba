"""A scene as a client knows it: what moves is where the last state that arrived puts it."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ..geometry import RigidState
from ._mesh import Body, Brightness, Deformation, Motion
from ._scene import Scene
from .motions import swing_m


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
class _ArrivedMotion:
    """A body's or a lamp's motion by what has arrived of it."""

    motion: Motion
    arrived: ArrivedState

    def state(self, time_ns: int) -> RigidState:
        known_ns, age_ns = self.arrived.known(time_ns)
        state = self.motion.state(known_ns)
        if not self.arrived.extrapolates and known_ns < time_ns:
            return RigidState(state.pose)
        velocity = state.velocity_m_s + age_ns * 1e-9 * state.acceleration_m_s2
        return attrs.evolve(state, pose=state.after(age_ns), velocity_m_s=velocity)


@attrs.frozen(eq=False)
class _ArrivedBrightness:
    """A lamp's brightness by what has arrived of it."""

    brightness: Brightness
    arrived: ArrivedState

    def share(self, time_ns: int) -> float:
        return self.brightness.share(self.arrived.known(time_ns)[0])


@attrs.frozen(eq=False)
class _ArrivedDeformation:
    """A mesh's vertices by what has arrived of them."""

    deformation: Deformation
    arrived: ArrivedState

    def positions(self, time_ns: int) -> NDArray[np.float64]:
        known_ns, age_ns = self.arrived.known(time_ns)
        positions = self.deformation.positions(known_ns)
        return positions + swing_m(self.deformation.velocities(known_ns), age_ns) if age_ns else positions

    def velocities(self, time_ns: int) -> NDArray[np.float64]:
        known_ns, age_ns = self.arrived.known(time_ns)
        velocities = self.deformation.velocities(known_ns)
        return velocities if known_ns == time_ns or age_ns else np.zeros_like(velocities)


def moves(scene: Scene) -> bool:
    """Return whether bodies, lamps or vertices of the scene move."""
    return bool(scene.bodies or scene.lamps or any(mesh.deformation is not None for mesh in scene.meshes))


def as_arrived(scene: Scene, arrived: ArrivedState) -> Scene:
    """Return the scene in which all that moves is known by the states that have arrived.

    States are exact, with speed, of bodies also with acceleration; later than the newest, bodies
    and lamps go on as RigidState.after says, vertices as motions.swing_m, lamps stay as bright.
    """
    bright = [one.brightness and _ArrivedBrightness(one.brightness, arrived) for one in scene.lamps]
    moving = [_ArrivedMotion(one.motion, arrived) for one in scene.lamps]
    lamps = zip(scene.lamps, moving, bright, strict=True)
    return attrs.evolve(
        scene,
        bodies=[Body(body.name, _ArrivedMotion(body.motion, arrived)) for body in scene.bodies],
        lamps=[attrs.evolve(lamp, motion=motion, brightness=own) for lamp, motion, own in lamps],
        meshes=[
            mesh
            if mesh.deformation is None
            else attrs.evolve(mesh, deformation=_ArrivedDeformation(mesh.deformation, arrived))
            for mesh in scene.meshes
        ],
    )
