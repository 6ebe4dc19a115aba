"""The table of a server's time for several users, whose pictures share the light of an instant."""

from __future__ import annotations

import math
import statistics
import time

import attrs
import numpy as np

from hmdwarp.client import parse_indirect
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, RigidState, View
from hmdwarp.gpu import Gpu, download
from hmdwarp.scenes import Lamp, Scene, load_scene
from hmdwarp.scenes.library._lit_room import in_atlas, wall
from hmdwarp.sources.server import Server
from hmdwarp.sources.server.parts.voxels import VoxelLighting

SCENE, SIZE, FOV = "lantern", (160, 200), Fov(-0.8, 0.8, -0.9, 0.9)
USERS, INSTANTS = (1, 4, 16), 3
VOXELS = ("voxels:size=32", "voxels", "voxels:cones=16", "voxels:size=128")
HEAD = (
    "| light | grid, MB | ms for 1 user | ms each for 4 | ms each for 16 | leak, wall of 1 cm |\n"
    "| --- | ---: | ---: | ---: | ---: | ---: |"
)


def table() -> str:
    """Measure all and return the table."""
    ways = {
        "converged (`depth_image`)": Needs(),
        "atlas (`irradiance`)": Needs(irradiance=10.0),
        **{f"`{text}`": Needs(voxels=parse_indirect(text)) for text in VOXELS},
    }
    scene, lines = load_scene(SCENE), [HEAD]
    with Gpu() as gpu:
        for way, needs in ways.items():
            each = [_milliseconds(gpu, scene, needs, count) for count in USERS]
            grid = VoxelLighting(gpu, scene, needs["voxels"]) if "voxels" in needs else None
            held = f"{grid.bytes * 1e-6:.0f}" if grid is not None else "–"
            through = f"{_leak(gpu, needs):.1%}".replace("%", " %") if grid is not None else "–"
            if grid is not None:
                grid.close()
            lines.append(f"| {way} | {held} | {' | '.join(f'{ms:.0f}' for ms in each)} | {through} |")
    return "\n".join(lines)


def _milliseconds(gpu: Gpu, scene: Scene, needs: Needs, users: int) -> float:
    """Return the time for each user of a frame for all, drawn when the light has just moved."""
    server, found = Server(gpu, scene), []
    for instant in range(INSTANTS + 1):
        started = time.perf_counter()
        for user in range(users):
            if "irradiance" in needs and user:
                break  # one atlas is for all
            _draw(server, needs, _view(user), instant * 100_000_000)
        gpu.gl.finish()
        found.append((time.perf_counter() - started) * 1e3 / users)
    server.close()
    return statistics.median(found[1:])


def _draw(server: Server, needs: Needs, view: View, time_ns: int) -> None:
    """Draw a frame of two eyes; of an atlas, whose client draws the picture, two pixels alone."""
    size = (1, 1) if "irradiance" in needs else SIZE
    beside = View(Pose(view.pose.position_m + (0.06, 0, 0), view.pose.orientation_xyzw), view.fov)
    server.recycle(server.draw_frame([view, beside], time_ns, size, needs=needs))


def _view(user: int) -> View:
    turn = 2 * math.pi * user / USERS[-1]
    return View(Pose((0.4 * math.sin(turn), 1.5, 0.4), (0, math.sin(turn / 2), 0, math.cos(turn / 2))), FOV)


@attrs.frozen(eq=False)
class _Fixed:
    place: tuple[float, float, float]

    def state(self, time_ns: int) -> RigidState:
        return RigidState(Pose(self.place))


def _leak(gpu: Gpu, needs: Needs) -> float:
    """Return how bright a dark room is beside a lit one, as a share of that one."""
    quads = []
    for centre in ((0.0, 1.0, 0.0), (2.01, 1.0, 0.0)):
        for out, up in (((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, 0, 1)), ((0, 0, 1), (0, 1, 0))):
            for sign in (1, -1):
                across = -sign * np.cross(up, out)
                quads.append(wall(tuple(np.array(centre) + sign * np.array(out)), tuple(across), up, (0.8, 0.8, 0.8)))
    meshes = [attrs.evolve(mesh, texture=-1) for mesh in in_atlas(quads, 0.5)]
    lit = Scene("rooms", "", meshes, lamps=[Lamp(_Fixed((2.0, 1.5, 0.0)), (1, 1, 1))])
    server, shown = Server(gpu, lit), []
    for x in (-0.5, 2.4):
        frame = server.draw_frame([View(Pose((x, 1.0, 0.5)), FOV)], 0, (80, 100), needs=needs)
        shown.append(float(download(frame.eyes[0].colour)[..., :3].astype(np.float64).mean()))
        server.recycle(frame)
    server.close()
    return shown[0] / shown[1]
