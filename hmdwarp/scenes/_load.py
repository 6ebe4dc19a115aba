"""One way in for every scene: a name or a file; what is slow; a scene as a client knows it."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError, option_of, unknown_name
from ..geometry import RigidState
from ._mesh import Body
from ._scene import Scene
from .input_events import InputLog
from .library import SceneSource, scenes
from .motions import swing_m
from .options import FILE_ENDINGS, SceneOptions


def load_scene(name_or_path: str | Path, options: SceneOptions | None = None) -> Scene:
    """Load the scene registered under a name, else the glTF, OBJ, PLY or Mitsuba file at a path.

    A registered scene is built once and kept, read-only; one that reacts gets inputs of its own.
    options: of files alone. Errors: UnknownNameError (with the nearest known name) for what is
    neither; SceneError for a file that cannot be used; InputError for options that do not fit.
    """
    text, options = str(name_or_path), SceneOptions.checked(options, optional=True)
    if text in scenes.names():
        for field in attrs.fields(SceneOptions):
            if getattr(options, field.name) != field.default:
                flag = option_of(field).flag
                raise InputError(f"{flag} with scene '{text}': it is for scene files; leave it out")
        source = scenes.get(text)
        if source.reacts is None:
            return _built(source)
        log = InputLog()
        return attrs.evolve(_built(source), inputs=log, **source.reacts(log))
    check_scene_name(text)
    from ._files import scene_from_file  # reading glTF brings SciPy, and shipped scenes do without

    return scene_from_file(Path(name_or_path), options)


def check_scene_name(text: str) -> None:
    """Raise UnknownNameError for what is neither a registered scene nor looks like a file."""
    path = Path(text)
    if text not in scenes.names() and path.suffix.lower() not in FILE_ENDINGS and not path.is_file():
        raise unknown_name("scene", text, [*scenes.names(), *(f"FILE{ending}" for ending in FILE_ENDINGS)])


@cache
def _built(source: SceneSource) -> Scene:
    return source.build()


def slow_in(scene: Scene) -> tuple[str, ...]:
    """Return for each thing that makes drawing slow its count and what to do, one line each."""
    soft = [mesh for mesh in scene.meshes if mesh.deformation is not None]
    counts = {
        "triangles": scene.triangle_count,
        "transparent triangles": sum(len(mesh.triangles) for mesh in scene.meshes if mesh.material.see_through),
        "moving vertices": sum(len(mesh.positions) for mesh in soft),
        "moving bodies": len(scene.bodies),
        "textures": len(scene.textures),
    }
    told = tomllib.loads(Path(__file__).with_name("slow.toml").read_text("utf-8"))
    return tuple(f"{n:,} {what}: {told[what]['remedy']}" for what, n in counts.items() if n >= told[what]["many"])


Array = NDArray[np.float64]


@attrs.define(eq=False)
class ArrivedState:
    """The instant of the newest state that has arrived; at first of the scene as it was sent."""

    extrapolates: bool
    newest_ns: int = 0

    def take(self, drawn_ns: int) -> None:
        self.newest_ns = max(self.newest_ns, drawn_ns)

    def known(self, time_ns: int) -> tuple[int, int]:
        """Return the instant whose state stands for `time_ns`, and for how long it goes on."""
        known_ns = min(time_ns, self.newest_ns)
        return known_ns, time_ns - known_ns if self.extrapolates else 0


@attrs.frozen(eq=False)
class _Arrived:
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
    return bool(scene.bodies or scene.lamps or any(mesh.deformation is not None for mesh in scene.meshes))


def as_arrived(scene: Scene, arrived: ArrivedState) -> Scene:
    """Return the scene in which all that moves is known by the states that have arrived.

    Later than the newest, bodies and lamps go on as RigidState.after says, vertices as
    motions.swing_m, lamps stay as bright.
    """

    def arrives(whole: Any) -> Any:
        return None if whole is None else _Arrived(whole, arrived)

    meshes = (attrs.evolve(mesh, deformation=arrives(mesh.deformation)) for mesh in scene.meshes)
    lamps = (
        attrs.evolve(lamp, motion=arrives(lamp.motion), brightness=arrives(lamp.brightness)) for lamp in scene.lamps
    )
    bodies = (Body(body.name, arrives(body.motion)) for body in scene.bodies)
    return attrs.evolve(scene, bodies=bodies, lamps=lamps, meshes=meshes)
