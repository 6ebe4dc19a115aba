"""Rendered pixels that move by themselves. Against rays and moved squares in float64, and against
what the server draws later."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from reference.motion import MotionAsked, moved_picture
from worlds import pixels, read

from hmdwarp.base import InputError
from hmdwarp.client import PassInputs
from hmdwarp.client.effects import Tools
from hmdwarp.client.effects.motion import MOST_BODIES, RIGID, SOFT, STEEPEST_DEG, MotionPass
from hmdwarp.client.warp_kinds import steepest
from hmdwarp.frames import BodyIds, EyeImage, Needs
from hmdwarp.geometry import Fov, Pose, RigidState, View
from hmdwarp.gpu import COLOUR, NUMBER, SCALAR, allocate
from hmdwarp.scenes import REACH_M, Body, Mesh, Scene, Spinning, Texture, Thrown
from hmdwarp.scenes.motions import SWING_S
from hmdwarp.sources.server import Server

MS = 1_000_000


def textured(gpu, array: np.ndarray, kind: tuple[int, str]):
    texture = allocate(gpu.gl, array.shape[1::-1], kind)
    dtype = {"f2": np.float16, "f4": np.float32, "u2": np.uint16}[kind[1]]
    texture.write(np.ascontiguousarray(array, dtype).tobytes(), alignment=1)
    return texture


class MovingWorld:
    """A rendered picture of still planes with holes, and before and behind them patches of bodies
    and of what deforms."""

    def __init__(self, seed: int, size: tuple[int, int] = (26, 19), bodies: int = 3) -> None:
        self.rng = rng = np.random.default_rng(seed)
        wide, high = self.size = size
        fov = Fov(*np.deg2rad([-rng.uniform(25, 45), rng.uniform(25, 45), -rng.uniform(25, 40), rng.uniform(25, 40)]))
        self.view = View(Pose(rng.normal(size=3), rng.normal(size=4)), fov)
        y, x = np.mgrid[:high, :wide] / max(size)
        self.inverse_depth = np.full((high, wide), 0.2) + 0.1 * x
        self.inverse_depth[(x + y) % 0.4 < 0.06] = 0
        self.inverse_depth[rng.uniform(size=(high, wide)) < 0.03] = -1
        self.ids = np.zeros((high, wide), np.int64)
        self.velocity = np.zeros((high, wide, 4))
        for number in range(1, bodies + 2):
            self._patch(number if number <= bodies else 0, x, y)
        colour = rng.uniform(0.2, 1.5, (high, wide, 3))
        covered = self.inverse_depth >= 0
        self.colour = np.dstack([colour * covered[..., None], covered]).astype(np.float16).astype(np.float64)
        self.inverse_depth = self.inverse_depth.astype(np.float32).astype(np.float64)
        self.states = tuple(self._state() for _ in range(bodies))

    def _patch(self, number: int, x: np.ndarray, y: np.ndarray) -> None:
        """Of body `number`, or of what deforms for 0. A slanted plane, half of the time with a step
        in it."""
        rng = self.rng
        inside = (abs(x - rng.uniform(0.2, 0.8)) < rng.uniform(0.08, 0.2)) & (
            abs(y - rng.uniform(0.15, 0.6)) < rng.uniform(0.08, 0.2)
        )
        plane = rng.uniform(0.3, 1.2) + rng.normal(scale=0.15) * x + rng.normal(scale=0.15) * y
        plane = plane + np.where(x + 0.3 * y > rng.uniform(0.2, 1.2), rng.choice([0.0, 0.4]), 0.0)
        self.inverse_depth = np.where(inside, plane, self.inverse_depth)
        self.ids = np.where(inside, number, self.ids)
        even, sheared = rng.normal(scale=0.8, size=3), rng.normal(scale=0.8, size=3)
        speed = even + sheared * np.dstack([x, x - y, y])
        self.velocity[inside] = (
            np.concatenate([speed[inside], np.ones((inside.sum(), 1))], axis=1) if number == 0 else 0
        )
        self.velocity = self.velocity.astype(np.float16).astype(np.float64)

    def _state(self) -> RigidState:
        rng = self.rng
        pose = Pose(self.view.pose.transform((rng.normal(scale=0.3), rng.normal(scale=0.3), -2.0)), rng.normal(size=4))
        return RigidState(
            pose, rng.normal(scale=0.4, size=3), rng.normal(scale=0.8, size=3), rng.normal(scale=0.5, size=3)
        )

    def image(self, gpu, parts: set[str], drawn_ns: int = 0) -> EyeImage:
        image = EyeImage(
            self.view, textured(gpu, self.colour, COLOUR), textured(gpu, self.inverse_depth, SCALAR), drawn_ns=drawn_ns
        )
        if RIGID in parts:
            image = image.having(ids=BodyIds(textured(gpu, self.ids, NUMBER), self.states))
        if SOFT in parts:
            image = image.having(velocity=textured(gpu, self.velocity, COLOUR))
        return image

    def asked(self, parts: set[str], age_ns: int) -> MotionAsked:
        poses = [(state.pose, state.after(age_ns)) for state in self.states] if RIGID in parts else []
        way = None
        if SOFT in parts:
            age = age_ns * 1e-9
            way = self.velocity[..., :3] * (age - 2 * age**2 / SWING_S)
            far = np.linalg.norm(way, axis=-1, keepdims=True)
            way = np.where(self.velocity[..., 3:] > 0, way * np.minimum(1, REACH_M / np.maximum(far, 1e-12)), np.nan)
        edge = steepest(self.view, self.size, STEEPEST_DEG)
        return MotionAsked(self.colour, self.inverse_depth, self.ids, self.view, edge, poses, way)


def with_bodies(image: EyeImage, bodies: tuple[RigidState, ...]) -> EyeImage:
    return image.having(ids=attrs.evolve(image["ids"], bodies=bodies))


def pass_for(gpu, size: tuple[int, int], *parts: str, images: int = 1) -> MotionPass:
    return MotionPass(gpu, frozenset(parts), size, size, Tools(None, 1, images))


def given_at(image: EyeImage, shown_ns: int, *others: EyeImage) -> PassInputs:
    return PassInputs(image, image.view, others=others, shown_ns=shown_ns)


def run(gpu, image: EyeImage, shown_ns: int, *parts: str) -> tuple[np.ndarray, np.ndarray]:
    made = pass_for(gpu, image.size, *parts)
    moved = made.run(given_at(image, shown_ns)).rendered
    found = read(moved.colour), read(moved.inverse_depth)[..., 0]
    made.close()
    return found


@pytest.mark.parametrize("parts", [(RIGID,), (SOFT,), (RIGID, SOFT)], ids="+".join)
@pytest.mark.parametrize("seed", [0, 1, 2, 4, 5])
def test_the_shader_does_what_rays_and_moved_squares_do(gpu, seed, parts):
    world, age = MovingWorld(seed), (120 + 60 * seed) * MS
    colour, inverse_depth = run(gpu, world.image(gpu, set(parts)), age, *parts)
    twin = moved_picture(world.asked(set(parts), age))
    sure = ~twin.picture.undecided
    assert sure.mean() > 0.97  # 4 SNAP_PX of a square's rim, of which a tenth of the picture has some
    assert np.array_equal(colour[..., 3][sure], twin.picture.colour[..., 3][sure])
    off = np.abs(colour - twin.picture.colour)[..., :3].max(axis=-1)
    assert (off <= twin.picture.tolerance)[sure].all()
    assert (np.abs(inverse_depth - twin.inverse_depth) <= twin.depth_tolerance)[sure].all()
    keys = world.asked(set(parts), age).keys()
    came = (twin.inverse_depth != np.where(keys == 0, world.inverse_depth, -1)) & sure
    assert came.sum() > 10  # something moved, and was seen again
    assert ((inverse_depth == -1) == (colour[..., 3] == 0)).all()
    assert (colour[colour[..., 3] == 0] == 0).all()
    assert np.isfinite(colour).all()


@pytest.mark.parametrize("parts", [(RIGID,), (SOFT,), (RIGID, SOFT)], ids="+".join)
def test_a_frame_shown_when_drawn_has_no_motion(gpu, parts):
    image, made = MovingWorld(7).image(gpu, set(parts), 40 * MS), pass_for(gpu, (26, 19), *parts)
    assert made.run(given_at(image, 40 * MS)).rendered is image
    made.close()


def test_what_rests_or_is_beyond_the_table_stands_still(gpu):
    world, made = MovingWorld(11), pass_for(gpu, (26, 19), RIGID)
    image = world.image(gpu, {RIGID})
    resting = with_bodies(image, (world.states[0], RigidState(Pose((1, 2, 3)))))  # and the third has no state
    colour, inverse_depth = run(gpu, resting, 250 * MS, RIGID)
    still = (world.ids > 1) & (inverse_depth == world.inverse_depth)
    assert still.sum() > 20
    assert np.array_equal(colour[still], world.colour[still])
    for bodies in ((), (RigidState(Pose((1, 2, 3))),) * 3):
        nothing = with_bodies(image, bodies)
        assert made.run(given_at(nothing, 250 * MS)).rendered is nothing
    with pytest.raises(InputError, match=f"{MOST_BODIES + 1} bodies: 'motion' takes {MOST_BODIES} at most"):
        made.run(given_at(with_bodies(image, world.states[:1] * (MOST_BODIES + 1)), 250 * MS))
    made.close()


def test_older_pictures_move_by_their_own_age(gpu):
    world = MovingWorld(12)
    rendered, older = world.image(gpu, {RIGID}, 200 * MS), world.image(gpu, {RIGID}, 50 * MS)
    made = pass_for(gpu, (26, 19), RIGID, images=2)
    out = made.run(given_at(rendered, 300 * MS, older))
    found = [read(frame.colour) for frame in (out.rendered, *out.others)]
    made.close()
    for image, age in zip(found, (100 * MS, 250 * MS), strict=True):
        assert np.array_equal(image, run(gpu, world.image(gpu, {RIGID}), age, RIGID)[0])
    assert "ids" not in out.rendered
    assert "ids" not in out.others[0]


# --- what a user would notice -------------------------------------------------------------------

SIZE = (120, 100)
EYE = View(Pose(), Fov(-0.7, 0.7, -0.6, 0.6))


def one_body(gpu, state: RigidState, *, seen: tuple = (0.3, 0.0, 0.0), inverse_depth: float = 0.5) -> EyeImage:
    """A body of one colour, 40 pixels square in the middle, before something green."""
    wide, high = SIZE
    y, x = np.mgrid[:high, :wide]
    inside = (abs(x - wide / 2 + 0.5) < 20) & (abs(y - high / 2 + 0.5) < 20)
    colour = np.where(inside[..., None], (*seen, 1.0), (0.0, 0.8, 0.0, 1.0))
    depth = np.where(inside, inverse_depth, 0.1)
    return EyeImage(
        EYE,
        textured(gpu, colour, COLOUR),
        textured(gpu, depth, SCALAR),
        {"ids": BodyIds(textured(gpu, inside.astype(int), NUMBER), (state,))},
    )


def test_soft_motion_is_limited_in_reach(gpu):
    """20 m/s for an eighth of a swing is 5 m. The way is REACH_M. After half a swing nobody
    knows."""
    image = one_body(gpu, RigidState(Pose()))
    velocity = np.zeros((*SIZE[::-1], 4))
    velocity[pixels(image["ids"].numbers) == 1] = (20.0, 0, 0, 1)
    soft = image.having(ids=None, velocity=textured(gpu, velocity, COLOUR))
    colour, _ = run(gpu, soft, round(250 * SWING_S) * MS, SOFT)
    left = np.flatnonzero((colour[..., 0] > 0).any(axis=0))[0]
    per_metre = 0.5 * SIZE[0] / (2 * np.tan(0.7))
    assert left - 40 == pytest.approx(REACH_M * per_metre, abs=1)
    made = pass_for(gpu, SIZE, SOFT)
    for age_s in (SWING_S / 2, 10.0):
        assert made.run(given_at(soft, round(1000 * age_s) * MS)).rendered is soft
    made.close()


def checkered(body: int) -> Mesh:
    """A square of 0.6 m, facing +z, of 12 x 12 fields."""
    positions = np.array([(-0.3, -0.3, 0), (0.3, -0.3, 0), (0.3, 0.3, 0), (-0.3, 0.3, 0)])
    uv = (positions[:, :2] + 0.3) / 0.6
    return Mesh(
        "square", positions, np.tile((0, 0, 1.0), (4, 1)), uv, np.ones((4, 3)), [(0, 1, 2), (0, 2, 3)], 0, body=body
    )


@pytest.mark.parametrize(
    ("motion", "least_db"),
    [
        (Spinning(Pose((0, 0, -1.5)), (0, 0, 1), 2.0), 25),
        (Spinning(Pose((0, 0, -1.5)), (0, 1, 0.3), 1.2), 22),
        (Thrown(Pose((-0.4, -0.5, -1.5)), (0.8, 3.0, -0.5), 5.0, spin_rad_s=(0, 0, 1.0)), 25),
    ],
    ids=["fan", "door", "thrown"],
)
def test_a_moved_picture_is_what_the_server_draws_then(gpu, motion, least_db):
    """Where both show the body: a checked square, resampled once. Without the pass less than 15 dB
    is left of it."""
    y, x = np.mgrid[:96, :96] // 8 % 2
    image = np.where(((x + y) % 2)[..., None] == 1, (230, 200, 60), (40, 60, 160)).astype(np.uint8)
    scene = Scene("square", "", [checkered(1)], [Texture("checks", image)], bodies=[Body("square", motion)])
    server, drawn_ns, shown_ns = Server(gpu, scene), 100 * MS, 400 * MS
    frame = server.draw_frame([EYE], drawn_ns, (240, 200), needs=Needs(ids=True))
    made = pass_for(gpu, (240, 200), RIGID)
    moved = made.run(given_at(frame.eyes[0], shown_ns)).rendered
    truth = server.draw(EYE, (240, 200), time_ns=shown_ns)
    found, exact, before = (read(picture.colour)[..., :3] for picture in (moved, truth, frame.eyes[0]))
    body = read(truth.inverse_depth)[..., 0] > 0
    both = body & (read(moved.inverse_depth)[..., 0] > 0)
    made.close()
    server.close()
    assert both.sum() > 0.97 * body.sum()
    psnr, unmoved = (-10 * np.log10(np.mean((picture - exact)[both] ** 2)) for picture in (found, before))
    assert psnr > least_db
    assert unmoved < 15
