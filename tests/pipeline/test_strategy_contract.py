"""Every strategy in a room where all moves, turns or appears, over a link that loses and reorders.
What crosses and when is compared with an account kept here; what is drawn, with a scene that stands
still as it was at that instant, so that no clock of the renderer's is trusted."""

from __future__ import annotations

from collections import Counter

import attrs
import numpy as np
import pytest
from lit_rooms import moving_room, placed
from replays import CHEAPER, of_strategy, set_up

from hmdwarp.base import srgb_from_linear
from hmdwarp.client import ShownPicture, WholeScene
from hmdwarp.client.strategies import strategies
from hmdwarp.frames import Needs
from hmdwarp.geometry import Pose, RigidState
from hmdwarp.gpu import SCALAR, Canvas, allocate, download
from hmdwarp.pipeline import source_of
from hmdwarp.scenes import Body, Panel, Still, indirect_atlas
from hmdwarp.sources.server import Server

APPEARS_NS = 950_000_000  # between the frame that is looked at and the instant that shows it
SIZE, RATE_HZ, MS = (48, 41), 30.0, 1_000_000
LATENCY_MS, JITTER_MS, LOSS, MBIT, QUEUE_MS, SEED = 100.0, 90.0, 0.2, 12.0, 20.0, 4
NETWORK = {
    "jitter": f"uniform:{JITTER_MS:g}", "loss": str(LOSS), "bandwidth": str(MBIT), "queue": QUEUE_MS, "link_seed": SEED,
}  # fmt: skip
MOVES = {"colour", "inverse_depth", "ids", "velocity", "panels"}
# What each reads of a frame where bodies move: all that crosses, and nothing else does.
READS = dict.fromkeys(strategies.names(), MOVES) | {
    "difference": {"difference"}, "environment": {"cube", "panels"}, "imposter": {"colour"},
    "irradiance": {"irradiance"}, "layered": MOVES | {"peeled"}, "model": set(), "photons": {"photons"},
    "points": {"points"}, "proxy": {"colour"}, "rotation": {"colour"}, "soft_bodies": MOVES - {"velocity"},
    "views": MOVES | {"views"},
}  # fmt: skip
# By float16, float32 and uint16: of a pixel.
PIXEL = {"colour": 8, "inverse_depth": 4, "ids": 2, "velocity": 8, "difference": 8, "peeled": 12, "views": 12}
NAMES = strategies.names()
# Fewer triangles would be others where the same scene stands still; light is solved twice in a run.
CHEAP = {**CHEAPER, "difference": "difference:share=1,texture=0.25", "irradiance": "irradiance:updates=5"}


class Appears:
    """Out of sight below the floor, and before the eyes from an instant on."""

    def state(self, time_ns: int) -> RigidState:
        return RigidState(Pose((-0.5, 1.3 if time_ns >= APPEARS_NS else -9.0, -1.2)))


def crowded_room():
    """Return the moving room, a box that appears, and two panels: the page of the farther turns."""
    room = moving_room()
    boxes = [attrs.evolve(mesh, body=2) for mesh in room.meshes if mesh.body == 1]
    boxes = [attrs.evolve(mesh, light_uv=None) for mesh in boxes]
    near, *pages = (np.full((4, 4, 3), light, np.uint8) for light in (40, 120, 250))
    panels = [
        Panel(near, Pose((0.05, 1.95, -1.5)), (0.3, 0.2)),
        Panel(tuple(pages), Pose((-0.1, 2.0, -1.8)), (0.7, 0.4), seconds=0.19),
    ]
    bodies = [*room.bodies, Body("late", Appears())]
    return attrs.evolve(room, meshes=[*room.meshes, *boxes], bodies=bodies, panels=panels)


def flying(gpu, name: str, scene, network=NETWORK):
    """Set a strategy's run up in that scene, without a guard band."""
    options = of_strategy(CHEAP.get(name, name), network, rate_hz=RATE_HZ, latency_ms=LATENCY_MS, guard=1.0)
    return set_up(gpu, options, source=type(source_of(options))(options, scene))


def bytes_of(name: str, frame, reads: set[str]) -> Counter[str]:
    """Count the bytes of what is read of a frame, from sizes in pixels and lengths of updates."""
    (width, height), found = frame.eyes[0].size, Counter[str]()
    for layer in reads:
        if layer in PIXEL:
            found[layer] = 2 * width * height * PIXEL[layer] * (2 if layer == "views" else 1)
        elif layer == "cube":
            found[layer] = 2 * 8 * np.prod(frame.eyes[0]["cube"].size, dtype=int)
        elif layer == "irradiance":
            found[layer] = 64 * 64 * 8
        else:
            (update,) = frame.eyes[0][layer].values()
            found[layer] = len(update.content)
    return +found


def same(one: Pose, other: Pose) -> bool:
    return one.matrix().tobytes() == other.matrix().tobytes()


@attrs.define
class Sent:
    """A frame, and what the account says of it, in ns."""

    drawn_ns: int
    size: int
    queue_ns: int = 0
    transfer_ns: int = 0
    delay_ns: int = 0
    fate: str = ""
    ready_ns: int = 0


def accounted(frames: list[Sent]) -> None:
    """Enter each frame's way: a queue before the bandwidth, then delay and loss, by their seeds."""
    delays, losses = (np.random.default_rng([SEED, which]) for which in (0, 1))
    free_ns = 0.0
    for frame in frames:
        frame.delay_ns = round((LATENCY_MS + JITTER_MS * delays.uniform(-1, 1)) * MS)
        lost = losses.uniform() < LOSS
        losses.uniform()  # for the state of a network in bursts
        waits_ns = max(0.0, free_ns - frame.drawn_ns)
        frame.queue_ns, taken = round(waits_ns), waits_ns <= QUEUE_MS * MS
        if taken:
            frame.transfer_ns = round(frame.size * 8 / (MBIT * 1e6) * 1e9)
            free_ns = frame.drawn_ns + waits_ns + frame.transfer_ns
        frame.fate = "dropped" if not taken else "lost" if lost else "arrives"
        frame.ready_ns = frame.drawn_ns + frame.queue_ns + frame.transfer_ns + frame.delay_ns


def frozen(scene, time_ns: int):
    """The scene standing still as it was at an instant, flag and lamps too."""
    still = placed(scene, time_ns)
    there = [
        mesh
        if mesh.deformation is None
        else attrs.evolve(mesh, positions=mesh.deformation.positions(time_ns), deformation=None)
        for mesh in still.meshes
    ]
    lamps = [attrs.evolve(lamp, motion=Still(lamp.motion.state(time_ns).pose)) for lamp in scene.lamps]
    panels = [attrs.evolve(panel, pictures=panel.pictures[panel.showing(time_ns)]) for panel in scene.panels]
    return attrs.evolve(still, meshes=there, lamps=lamps, light_ns=None, panels=panels)


def drawn(gpu, scene, time_ns: int, views, needs: Needs):
    """Download what is drawn of the scene, frozen: by layer, of both eyes."""
    server = Server(gpu, frozen(scene, time_ns))
    frame = server.draw_frame(views, 0, SIZE, needs=needs, shown_size=SIZE)
    found = pictures_in(frame)
    server.close()
    return found


def pictures_in(frame) -> dict[str, list[np.ndarray]]:
    found: dict[str, list[np.ndarray]] = {}
    for layer, data in [one for _, eye in frame.pictures() for one in eye.contents()]:
        if layer.name not in ("photons", "points", "ids", "velocity", "panels"):
            found.setdefault(layer.name, []).extend(download(one).astype(np.float64) for one in layer.sent(data))
    return found


def off(one: np.ndarray, other: np.ndarray, where: np.ndarray | None = None) -> float:
    """Return the share of pixels that differ by more than 0.02, or the mean error over a mask."""
    error = np.abs(one - other).reshape(*one.shape[:2], -1).max(axis=2)
    return float((error > 0.02).mean() if where is None else error[where].mean())


@pytest.mark.parametrize("name", NAMES)
def test_every_byte_and_instant_is_that_of_the_account(gpu, name):
    """And each refresh shows the newest frame that has arrived by then, for the head of then."""
    scene, sent, shown = crowded_room(), [], []
    with flying(gpu, name, scene) as setup:
        channel, track = setup.channel, setup.track
        passed_on = channel.send

        def send(frame, now_ns):
            sent.append(Sent(now_ns, bytes_of(name, frame, READS[name]).total()))
            assert frame.drawn_ns == now_ns and same(frame.head.pose, track.at(now_ns).pose)
            layers.update(bytes_of(name, frame, READS[name]))
            passed_on(frame, now_ns)

        layers, channel.send = Counter[str](), send
        instants = []
        for _, instant_ns in setup.schedule.numbered():
            instants.append(instant_ns)
            setup.loop.draw(instant_ns)
            refresh = setup.loop.show(instant_ns)
            if refresh is None:
                shown.append((instant_ns, None, None))
                continue
            assert same(refresh.head.pose, track.at(instant_ns).pose)
            assert [one.shown_ns for one in refresh.inputs] == [instant_ns] * 2
            assert [eye.drawn_ns for eye in refresh.frame.eyes] == [refresh.frame.drawn_ns] * 2
            shown.append((instant_ns, refresh.transit, refresh.frame.drawn_ns))
        tally, told = channel.fates(), channel.summary(RATE_HZ)
    accounted(sent)
    if name != "proxy":  # its first pictures wait for the server's
        assert [frame.drawn_ns for frame in sent] == instants
    fates, before = Counter(frame.fate for frame in sent), -1
    for instant_ns, transit, drawn_ns in shown:
        there = [k for k, frame in enumerate(sent) if frame.fate == "arrives" and frame.ready_ns <= instant_ns]
        assert (transit is None) == (not there), instant_ns
        if not there:
            continue
        newest = max(there)
        assert newest >= before, "never back to an older one"
        before, frame = newest, sent[newest]
        assert (transit.number, drawn_ns) == (newest, frame.drawn_ns)
        found = (transit.sent_ns, transit.size_bytes, transit.queue_ns, transit.transfer_ns, transit.delay_ns)
        expected = (frame.drawn_ns, frame.size, frame.queue_ns, frame.transfer_ns, frame.delay_ns)
        assert found == pytest.approx(expected, abs=2)
    assert (tally["drawn"], tally["lost"], tally["dropped"]) == (len(sent), fates["lost"], fates["dropped"])
    late = [frame.ready_ns > instants[-1] for frame in sent if frame.fate == "arrives"]
    assert tally["under_way"] == sum(late) and tally["undecodable"] == 0
    assert tally["shown"] + tally["late"] + tally["superseded"] == len(late) - sum(late)
    assert tally["shown"] == len({drawn_ns for *_, drawn_ns in shown} - {None})
    assert fates["lost"] and (fates["dropped"] or tally["late"] + tally["superseded"])
    seconds = len(instants) / RATE_HZ
    weights = {layer: count * 8e-6 / seconds for layer, count in (+layers).items()}
    assert {layer: rate for layer, rate in told["layers_mbit_s"].items() if rate} == pytest.approx(weights)
    assert told["mbit_s"] == pytest.approx(sum(weights.values()))


# Who draws something at the newest instant.
DRAWS = {"model", "irradiance", "photons", "difference", "light", "soft_bodies"}


@pytest.mark.parametrize("name", NAMES)
def test_every_picture_is_of_its_instant(gpu, name):
    """What the server draws is as late as the frame, what the client draws is of now."""
    scene, drawn_ns = crowded_room(), []
    if name == "soft_bodies":  # the flag alone is of now
        bodies, lamps = ([stopped(thing) for thing in things] for things in (scene.bodies, scene.lamps))
        scene = attrs.evolve(scene, bodies=bodies, lamps=lamps)
    with flying(gpu, name, scene, {}) as setup:
        for number, instant_ns in setup.schedule.numbered():
            drawn_ns.append(instant_ns)
            setup.loop.draw(instant_ns)
            if number >= 0 and (refresh := setup.loop.show(instant_ns)) is not None:
                break
        eyes, track, late = setup.target.eyes, setup.track, pictures_in(refresh.frame)
        if name != "proxy":  # it warps to each head: its own pictures are of another instant
            views = eyes.views(track.at(refresh.frame.drawn_ns).pose)
            check_frame(gpu, name, scene, setup, refresh.frame, late, views)
        if "irradiance" in late:
            of_update = [ns for ns in drawn_ns if update_of(ns) == update_of(refresh.frame.drawn_ns)]
            expected = indirect_atlas(frozen(scene, of_update[0]), 0)
            assert np.allclose(late["irradiance"][0][::-1], expected, atol=2e-3)
        shown = download(refresh.eyes[0].shown.texture).astype(np.float64)
        assert same(refresh.eyes[0].view.pose, eyes.views(track.at(instant_ns).pose)[0].pose)
    if name in DRAWS:
        check_shown(gpu, scene, shown, refresh.eyes[0].view, instant_ns, refresh.frame.drawn_ns)


def stopped(thing):
    """Return a body or lamp that stays where it is at the start."""
    return attrs.evolve(thing, motion=Still(thing.motion.state(0).pose))


def update_of(time_ns: int) -> int:
    """Return the number of the update of indirect light, of five a second."""
    return (time_ns + MS // 5) // (200 * MS)


def check_frame(gpu, name, scene, setup, frame, late, views) -> None:
    """Compare what the server drew with the scene as it stood then."""
    wanted, then_ns = setup.requested.needs, frame.drawn_ns
    needs = Needs(**{layer: wanted[layer] for layer in ("cube", "light", "peeled", "panels") if layer in wanted})
    still = drawn(gpu, scene, then_ns, views, needs)
    # The light of voxels is of the last update.
    for layer in (READS[name] & still.keys()) - ({"colour"} if name == "voxels" else set()):
        for k, (one, other) in enumerate(zip(late[layer], still[layer], strict=True)):
            if layer != "peeled":
                assert off(one, other) < 0.02, layer
                continue
            # It leaves out what moves: alike where the still one shows none of it.
            alike = np.abs(late[layer][k | 1] - still[layer][k | 1]) < 1e-3
            assert alike.mean() > 0.5 and off(one, other, alike) < 1e-3
    for eye, view in zip(frame.eyes, views, strict=True):
        assert same(eye.view.pose, view.pose)
        for image in eye.get("views", ()):
            alone = Needs(**{layer: wanted[layer] for layer in ("panels",) if layer in wanted})
            (other, _), _ = drawn(gpu, scene, then_ns, [image.view, image.view], alone).values()
            assert off(download(image.colour).astype(float), other) < 0.02
        if "ids" in eye:
            (body, _), motion, step = eye["ids"].bodies, scene.bodies[0].motion, 100_000
            ends = [motion.state(then_ns + way * step).pose.position_m for way in (-1, 1)]
            assert np.allclose(body.pose.position_m, motion.state(then_ns).pose.position_m)
            assert np.allclose(body.velocity_m_s, (ends[1] - ends[0]) / (2e-9 * step), atol=1e-6)
    if "difference" in late:
        (simplified,) = wanted["difference"]
        own, more = (
            srgb_from_linear(one[..., :3]) for one in (simple(gpu, setup, frame, simplified), *late["difference"][:1])
        )
        whole = drawn(gpu, scene, then_ns, views, Needs())["colour"][0]
        assert off(own + 2 * more - 1, srgb_from_linear(whole[..., :3])) < 0.03


def simple(gpu, setup, frame, simplified) -> np.ndarray:
    """Return what the client draws of the simplified scene for the late view, (h, w, 4)."""
    target = ShownPicture(Canvas(gpu.gl, SIZE), allocate(gpu.gl, SIZE, SCALAR))
    setup.geometry.store(WholeScene, simplified).draw(frame.eyes[0].view, target, frame.drawn_ns)
    found = download(target.colour.texture).astype(np.float64)
    target.colour.release()
    target.depth.release()
    return found


def check_shown(gpu, scene, shown, view, instant_ns: int, late_ns: int) -> None:
    """Where something has moved within a refresh, or since the frame, it shows this instant."""
    step = round(1e9 / RATE_HZ)
    here, *others = (
        drawn(gpu, scene, ns, [view] * 2, Needs()) for ns in (instant_ns, instant_ns - step, instant_ns + step, late_ns)
    )
    for beside in others:
        moved = np.abs(here["inverse_depth"][0] - beside["inverse_depth"][0]) > 0.005
        assert moved.sum() > 10
        now, then = (off(shown, one["colour"][0], moved) for one in (here, beside))
        assert now < then
