"""Light that is late on the client, beside direct light of now: an atlas of irradiance, whole at
each update, and photons, splatted and kept whatever the link does.
"""

from __future__ import annotations

import numpy as np
import pytest
from client_scene import ClientScene
from golden_pictures import assert_golden, sheet
from lit_rooms import cube, plain, scene_of
from worlds import read, shown_by

from hmdwarp.client import PassInputs
from hmdwarp.client.warps import Output
from hmdwarp.cloudlight.photons import CUBE_BYTES, KeptPhotons, PhotonMap
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, allocate
from hmdwarp.scenes import ATLAS, Lamp, Still, load_scene, scenes, with_lamps_stopped
from hmdwarp.sources.server import Server

SIZE = (96, 80)
FOV = Fov(-0.8, 0.75, -0.7, 0.65)
HERE, THERE = View(Pose((0.05, 1.6, 0.1)), FOV), View(Pose((0.3, 1.5, -0.2), (0.05, 0.3, 0.02, 0.95)), FOV)
FEW = PhotonMap(budget=20_000, paths=1024, radius=0.5)
SPEC = "photons:budget=20000,paths=1024,radius=0.5"


def frames_of(geometry, time_ns: int, wanted=FEW, arrive=lambda number: True) -> list[np.ndarray]:
    """Send until nothing is left; return what came, and let the server hear of each at once."""
    server, contents = geometry.server, []
    for number in range(400):
        frame = server.draw_frame([HERE], time_ns, (8, 8), needs=Needs(photons=frozenset({wanted})))
        arrived = arrive(number)
        server.heard(frame, arrived, time_ns)
        if arrived:
            contents.append(frame.eyes[0]["photons"][wanted].content)
        server.recycle(frame)
        if not server.has_more(time_ns) and arrived:
            return contents
    raise AssertionError("it never ends")


def shown(gpu, geometry, time_ns: int, spec: str = SPEC, view: View = THERE, frame=None):
    """Colour and inverse depth of what the client shows with what it has received."""
    frame = frame or geometry.server.draw_frame([HERE], time_ns, (8, 8))
    inputs = PassInputs(frame.eyes[0], view, shown_ns=time_ns)
    return shown_by(gpu, spec, inputs, SIZE, Output(depth=True), geometry)


def receive(geometry, contents, wanted=FEW) -> None:
    for content in contents:
        geometry.store(KeptPhotons, wanted).receive(content)


def test_pictures_lit_by_photons_look_as_before(gpu, tmp_path):
    """What they must bring is known: test_photon_bundles.py. Then lit by a spot, a point, a sun."""
    pictures, time_ns = [], 700_000_000
    for name in ("lantern", "sunroom", "doorway"):
        geometry = ClientScene(gpu, plain(load_scene(name)))
        receive(geometry, frames_of(geometry, time_ns))
        pictures.append(shown(gpu, geometry, time_ns, f"{SPEC},scale=1"))
    down, aslant = ((np.sin(turn), 0, 0, np.cos(turn)) for turn in (-np.pi / 4, -np.pi / 5))
    lamps = [
        Lamp(Still(Pose((0.2, 0.8, 0.1), down)), (0.9, 0.5, 0.3), cone=(0.15, 0.7)),
        Lamp(Still(Pose((-0.5, 0.3, 0.2))), (0.1, 0.2, 0.1)),
        Lamp(Still(Pose((0, 0, 0), aslant)), (0.1, 0.1, 0.3), is_sun=True),
    ]
    open_box = [side for side in cube((1.0, 1.0, 1.0)) if side.centre[1] < 0.9]
    view = View(Pose((0.0, 0.7, 0.6), (np.sin(-0.35), 0, 0, np.cos(-0.35))), FOV)
    for each in lamps:
        geometry = ClientScene(gpu, scene_of(open_box, 0.2, [each]))
        pictures.append(shown(gpu, geometry, 0, view=view))
    assert_golden("effects/photons", sheet(*pictures), tmp_path, share=1 / 1000 if gpu.is_software else 1 / 20)


def test_before_any_photon_there_is_direct_light_alone(gpu):
    """As with a black atlas, but for the rounding of two programs."""
    geometry, time_ns = ClientScene(gpu, "lantern"), 700_000_000
    got = shown(gpu, geometry, time_ns)
    black = allocate(gpu.gl, ATLAS, COLOUR)
    eye = geometry.server.draw_frame([HERE], time_ns, (8, 8)).eyes[0].having(irradiance=black)
    inputs = PassInputs(eye, THERE, shown_ns=time_ns)
    colour, depth = shown_by(gpu, "irradiance", inputs, SIZE, Output(depth=True), geometry)
    assert np.allclose(got[0], colour, rtol=1e-3, atol=1e-4) and np.array_equal(got[1], depth)
    assert got[0].max() > 0.1
    receive(geometry, frames_of(geometry, time_ns))
    more = shown(gpu, geometry, time_ns)[0][..., :3].sum()
    assert more > 1.4 * got[0][..., :3].sum(), "and then there is more"


# When the light has changed, and the share of the error of light that stands still. In sunroom the
# sun turns by 10 degrees, and what photons scatter is most of the error; in doorway those of the
# bright room also light the floor of the dim one, since they know no wall. Measured 0.41, 0.71 and
# 0.24; paths have fixed random numbers, so only rounding moves them.
MOVED = {"lantern": (900_000_000, 0.5), "sunroom": (900_000_000, 0.9), "doorway": (2_500_000_000, 0.5)}


@pytest.mark.parametrize("name", MOVED)
def test_only_indirect_light_is_late_and_nearer_than_light_that_stands_still(gpu, name):
    geometry = ClientScene(gpu, name)
    then, now, least = 100_000_000, *MOVED[name]
    wanted = PhotonMap()
    receive(geometry, frames_of(geometry, then, wanted), wanted)
    truth = read(geometry.server.draw(THERE, SIZE, time_ns=now).colour)
    late = shown(gpu, geometry, now, "photons")[0]
    stopped = Server(gpu, with_lamps_stopped(geometry.server.scene, then))
    baked = read(stopped.draw(THERE, SIZE, time_ns=now).colour)
    stopped.close()
    late_error, baked_error = (np.abs(each - truth).mean() for each in (late, baked))
    assert late_error < baked_error * least


def test_a_door_that_moves_makes_all_photons_stale(gpu):
    """Lamps stand still, but what they light does not: from any past to the same photons."""
    wanted, door = PhotonMap(budget=20_000, paths=1024), load_scene("doorway")
    moved, fresh = ClientScene(gpu, door), ClientScene(gpu, door)
    receive(moved, frames_of(moved, 0, wanted), wanted)
    assert [len(frame) for frame in frames_of(moved, 400_000_000, wanted)] == [CUBE_BYTES], "it is still shut"
    receive(moved, frames_of(moved, 2_500_000_000, wanted), wanted)
    receive(fresh, frames_of(fresh, 2_500_000_000, wanted), wanted)
    one, other = (each.store(KeptPhotons, wanted).photons.read() for each in (moved, fresh))
    assert one == other


# --- irradiance ---

LIT = [name for name in scenes.names() if scenes.get(name).build().lamps]


def frame_of(geometry, time_ns, updates=10.0):
    return geometry.server.draw_frame([HERE, HERE], time_ns, SIZE, needs=Needs(irradiance=updates))


def test_lost_photons_are_sent_again_and_still_light_once(gpu):
    """Every third frame is lost. Afterwards nothing is left to send, as long as no light moves."""
    scene = with_lamps_stopped(load_scene("lantern"))
    whole, torn = ClientScene(gpu, scene), ClientScene(gpu, scene)
    wanted = PhotonMap(budget=4000, paths=1024)
    receive(whole, frames_of(whole, 0, wanted), wanted)
    receive(torn, frames_of(torn, 0, wanted, lambda number: number % 3 != 1), wanted)
    spec = "photons:budget=4000,paths=1024"
    assert np.array_equal(shown(gpu, whole, 0, spec)[0], shown(gpu, torn, 0, spec)[0])
    for geometry in (whole, torn):
        (last,) = frames_of(geometry, 1_000_000_000, wanted)
        assert len(last) == CUBE_BYTES, "no bundle"


@pytest.mark.parametrize("scene", LIT)
def test_with_the_light_of_now_it_is_the_truth_bit_for_bit(gpu, scene):
    """Whatever the frame was drawn for, from the same atlas and by the same passes."""
    geometry = ClientScene(gpu, scene)
    time_ns = 700_000_000
    got = shown(gpu, geometry, time_ns, "irradiance", frame=frame_of(geometry, time_ns))
    truth = geometry.server.draw(THERE, SIZE, time_ns=time_ns)
    assert np.array_equal(got[0], read(truth.colour))
    assert np.array_equal(got[1], read(truth.inverse_depth)[..., 0])


def test_each_update_is_whole_so_that_a_lost_one_is_no_matter(gpu):
    """Frames between updates carry the last one again; older frames show the older light."""
    geometry = ClientScene(gpu, "lantern")
    times = (100_000_000, 150_000_000, 199_000_000, 200_000_000, 650_000_000)
    frames = [frame_of(geometry, time_ns) for time_ns in times]
    atlases = [read(frame.eyes[0]["irradiance"]) for frame in frames]
    assert np.array_equal(atlases[0], atlases[1]) and np.array_equal(atlases[0], atlases[2])
    assert not np.array_equal(atlases[0], atlases[3])
    assert frames[0].eyes[0]["irradiance"] is frames[0].eyes[1]["irradiance"]
    in_order, turned_round = (
        [shown(gpu, geometry, 700_000_000, "irradiance", HERE, frame)[0] for frame in each]
        for each in (frames, frames[::-1])
    )
    assert all(np.array_equal(a, b) for a, b in zip(in_order, turned_round[::-1], strict=True))
