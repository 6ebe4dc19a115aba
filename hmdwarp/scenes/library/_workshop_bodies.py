"""What moves in the workshop, each in the frame of its own body, and how."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ...geometry import Pose
from .._content import Body
from ..motions import Spinning, Thrown, Track
from ._pieces import Pieces
from ._surfaces import box, cushion, lathe, patch, sheet, tube
from ._yard import DARK, STEEL

FAN = (-1.15, 1.45, -2.05)
FAN_RAD_S = 2.6
BLADES = ((0.80, 0.16, 0.12), (0.86, 0.66, 0.16), (0.16, 0.42, 0.62), (0.86, 0.84, 0.78))
BASKETS = ((1.75, 0.55, -2.6), (-0.35, 0.55, -2.9))  # thrown from the first into the second
FLIGHT_S = 1.1
TRACK = (0.25, -4.0, 1.75, 0.62)  # middle x and z, half width, half depth
LAP_S = 9.0


def fan() -> Pieces:
    """Four blades, each of its own colour, twisted as a fan's are; the axis is z, the front +z."""
    pieces = Pieces()
    for index, tint in enumerate(BLADES):
        along, across = np.linspace(0.07, 0.46, 14), np.linspace(-1, 1, 9)
        aa, cc = np.meshgrid(along, across, indexing="ij")
        half = 0.05 + 0.26 * (aa - 0.07) * (1.15 - aa)
        points = np.stack([cc * half, aa, 0.35 * cc * half * (1.1 - aa) + 0.012 * np.sin(9 * aa)], axis=-1)
        turn = Rotation.from_euler("z", index * np.pi / 2).as_matrix()
        uv = np.stack([cc * 0.3, aa * 3], axis=-1)
        pieces.add(sheet(points @ turn.T, uv), "fabric", tint, double_sided=True)
    hub = lathe([(1e-3, -0.06), (0.075, -0.06), (0.08, 0.03), (0.05, 0.07), (1e-3, 0.08)], sides=24)
    upright = hub.moved((0, 0, 0))
    forward = Rotation.from_euler("x", np.pi / 2).as_matrix()
    pieces.add(
        type(hub)(upright.positions @ forward.T, upright.normals @ forward.T, hub.uv, hub.triangles), "speckle", STEEL
    )
    return pieces


def cart() -> Pieces:
    """A hand cart with crates and a globe on it; it drives towards its own +x, wheels on y = 0."""
    pieces = Pieces()
    pieces.add(box((0, 0.26, 0), (0.9, 0.06, 0.5), cell_m=0.12, uv=(0, 0, 1, 0.5)), "wood", (0.95, 0.8, 0.6))
    for x in (-0.3, 0.3):
        for z in (-0.22, 0.22):
            wheel = lathe([(0.02, -0.03), (0.12, -0.03), (0.12, 0.03), (0.02, 0.03)], sides=20)
            stand = Rotation.from_euler("x", np.pi / 2).as_matrix()
            turned = type(wheel)(
                wheel.positions @ stand.T + (x, 0.12, z), wheel.normals @ stand.T, wheel.uv, wheel.triangles
            )
            pieces.add(turned, "speckle", DARK)
            pieces.add(box((x, 0.2, z * 0.8), (0.06, 0.14, 0.05)), "speckle", STEEL)
    pieces.add(box((-0.2, 0.46, 0.02), (0.36, 0.34, 0.34), cell_m=0.1, uv=(0, 0, 1, 1)), "wood", (1.15, 1.05, 0.9))
    pieces.add(patch((-0.36, 0.32, 0.192), (0.32, 0, 0), (0, 0.28, 0), uv=(0.002, 0.3, 0.248, 0.7)), "posters")
    pieces.add(box((0.22, 0.37, -0.05), (0.3, 0.16, 0.3), cell_m=0.1), "bricks")
    pieces.add(cushion((0.22, 0.61, -0.05), (0.32, 0.32, 0.32), roundness=1, rings=16, sides=32, tile_m=0.4), "map")
    handle = [
        (-0.44, 0.28, 0.2),
        (-0.58, 0.85, 0.2),
        (-0.6, 0.92, 0.1),
        (-0.6, 0.92, -0.1),
        (-0.58, 0.85, -0.2),
        (-0.44, 0.28, -0.2),
    ]
    pieces.add(tube(handle, 0.016), "speckle", (0.75, 0.2, 0.14))
    return pieces


def ball() -> Pieces:
    """Striped, 22 cm across."""
    pieces = Pieces()
    pieces.add(
        cushion((0, 0, 0), (0.22, 0.22, 0.22), roundness=1, rings=24, sides=40, tile_m=0.15), "map", (1.5, 1.0, 0.7)
    )
    return pieces


def basket(centre: tuple[float, float, float]) -> list:
    """What the ball comes from and goes to: open above, on a post. It stands still."""
    x, y, z = centre
    wall = [(0.12, -0.2), (0.2, 0.02), (0.19, 0.02), (0.11, -0.19), (1e-3, -0.19)]
    return [
        (lathe(wall, (x, y, z), sides=28, repeats=6), "fabric", (0.75, 0.56, 0.3)),
        (lathe([(0.16, 0.0), (0.05, 0.03), (0.03, y - 0.18)], (x, 0, z), sides=16), "speckle", STEEL),
    ]


def bodies() -> tuple[Body, ...]:
    """In the order of their numbers: fan, cart, ball."""
    start, end = (np.array(b) - (0, 0.08, 0) for b in BASKETS)
    across = (end - start) / FLIGHT_S
    up = np.array([0, 0.5 * 9.81 * FLIGHT_S, 0])
    return (
        Body("fan", Spinning(Pose(FAN), (0, 0, 1), FAN_RAD_S)),
        Body("cart", cart_track()),
        Body("ball", Thrown(Pose(start), across + up, FLIGHT_S, spin_rad_s=(1.0, 2.0, -3.0))),
    )


def cart_track(keys: int = 48) -> Track:
    """Round an oval, facing the way it drives."""
    x, z, wide, deep = TRACK
    angle = np.linspace(0, 2 * np.pi, keys + 1)
    places = np.stack([x + wide * np.cos(angle), np.zeros(keys + 1), z + deep * np.sin(angle)], axis=1)
    along = np.stack([-wide * np.sin(angle), deep * np.cos(angle)], axis=1)
    heading = np.unwrap(np.arctan2(-along[:, 1], along[:, 0]))
    # Keys as far apart in time as on the way, so that the cart keeps its pace.
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    times = np.concatenate([[0], np.cumsum(steps)]) / steps.sum() * LAP_S
    return Track(times, places, Rotation.from_euler("y", heading[:, None]))
