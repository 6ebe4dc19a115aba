"""The client draws the scene itself: what it shows is what the server would draw now."""

from __future__ import annotations

import numpy as np
import pytest
from client_scene import ClientScene
from replays import run
from worlds import read, shown_by

from hmdwarp.client import ArrivingScene, PassInputs, parse_warp
from hmdwarp.client.warps import Output
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, allocate
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Coding
from hmdwarp.scenes import load_scene, scenes
from hmdwarp.sources.server import Server

SIZE = (96, 80)
FOV = Fov(-0.7, 0.6, -0.55, 0.5)
HERE, THERE = View(Pose((0.05, 1.6, 0.1)), FOV), View(Pose((0.3, 1.5, -0.2), (0.05, 0.3, 0.02, 0.95)), FOV)


def drawn(gpu, geometry: ClientScene, spec: str, shown: View, time_ns: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Colour and inverse depth that the warp shows, from a black frame drawn elsewhere."""
    black = EyeImage(HERE, allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR))
    asked = gpu, spec, PassInputs(black, shown, shown_ns=time_ns), SIZE
    beside, alone = (shown_by(*asked, Output(depth=depth), geometry) for depth in (True, False))
    assert np.array_equal(beside[0], alone[0]), "with and without depth"
    return beside


def truth(geometry: ClientScene, shown: View, time_ns: int = 0) -> tuple[np.ndarray, np.ndarray]:
    image = geometry.server.draw(shown, SIZE, time_ns=time_ns)
    return read(image.colour), read(image.inverse_depth)[..., 0]


@pytest.mark.parametrize("scene", scenes.names())
@pytest.mark.parametrize("shown", [HERE, THERE], ids=["here", "there"])
def test_the_whole_model_is_the_truth_bit_for_bit(gpu, scene, shown):
    """With mirrors, glass, overlays and all that moves, whatever the frame shows."""
    geometry = ClientScene(gpu, scene)
    # Lamps that move are baked where they are at the start.
    for time_ns in (0,) if geometry.server.scene.lamps else (0, 1_700_000_000):
        for got, wanted in zip(
            drawn(gpu, geometry, "model", shown, time_ns), truth(geometry, shown, time_ns), strict=True
        ):
            assert np.array_equal(got, wanted)


PROGRESSIVE = "model:arrives=progressive,budget=300000"


def last_pictures(tmp_path, **options):
    """The run's summary, and the PSNR of its pictures in order."""
    result = run(tmp_path, fill="none", metrics_every=5, **{"warp": PROGRESSIVE, "latency_ms": 50.0, **options})
    return result.summary, [row["psnr_db"] for row in result.rows if row["eye"] == 0 and row["psnr_db"] is not None]


@pytest.mark.parametrize(("scene", "codec"), [("parade", "h264"), ("gallery", "none")])
def test_progressive_arrival_ends_at_the_truth_bit_for_bit(tmp_path, scene, codec):
    """parade: what deforms and stands; gallery: mirrors. The pieces are not changed by a codec."""
    warp = PROGRESSIVE.replace("300000", "1000000")
    summary, psnr_db = last_pictures(tmp_path, scene=scene, warp=warp, seconds=0.4, coding=Coding(codec))
    assert psnr_db[0] < 60 and psnr_db[-1] == 100.0
    (model,) = summary["client_models"]
    assert model["arrived"] == model["things"]
    assert 0 < model["start_up_bytes"] < model["first_picture_bytes"] < model["arrived_bytes"]
    assert set(summary["link"]["layers_mbit_s"]) == {"scene_update"}
    assert model["unpack_ms"] > model["unpack_worst_ms"] > 0


@pytest.mark.parametrize("scene", ["lantern", "doorway"])
def test_under_lamps_what_arrives_is_lit_as_the_whole_model(gpu, scene):
    """To the last bit once all is there; and before, when every texture is coarse and triangles are
    stand-ins, nearer to it than the bare albedo is by far."""
    geometry, server = ClientScene(gpu, scene), Server(gpu, load_scene(scene))
    warp = "model:arrives=progressive,budget=25000"
    choice = parse_warp(warp)
    needs = choice.entry.needs(choice.settings)
    arriving = geometry.store(ArrivingScene, next(iter(needs["scene_update"])))
    view = View(server.scene.viewpoint, HERE.fov)
    whole, bare = (drawn(gpu, geometry, text, view)[0][..., :3] for text in ("model", "model:light=off"))
    far = np.abs(bare - whole).mean()
    assert far > 0.02
    shown = []
    for step in range(40):
        frame = server.draw_frame([view], 10_000_000 * step, SIZE, needs=needs)
        geometry.receive(frame)
        server.heard(frame, True, 10_000_000 * (step + 1))
        server.recycle(frame)
        if arriving.first_picture_bytes is not None:
            shown.append(drawn(gpu, geometry, warp, view)[0][..., :3])
        (weight,) = arriving.weights()
        if weight["arrived"] == weight["things"]:
            break
    errors = [np.abs(picture - whole).mean() for picture in shown]
    assert len(errors) > 3 and errors[-1] == 0 and 0 < errors[0] < far / 4
    server.close()
    geometry.close()


@pytest.mark.parametrize("network", [{"loss": "0.3"}, {"loss": "0.3", "loss_burst": 2.5, "jitter": "uniform:40"}])
def test_lost_and_late_updates_are_made_up_for(tmp_path, network):
    """Whatever is lost is sent again; what came too late to be shown has arrived all the same."""
    summary, psnr_db = last_pictures(
        tmp_path, scene="spheres", seconds=0.8, network=LinkOptions.of({**network, "link_seed": 4})
    )
    assert summary["link"]["frames"]["lost"] + summary["link"]["frames"]["late"] > 3
    assert psnr_db[-1] == 100.0


def test_a_small_budget_is_kept_and_the_picture_is_never_torn(tmp_path):
    """First a hole, then a whole if coarse picture, which gets better."""
    warp = "model:arrives=progressive,budget=5000"
    result = run(tmp_path, scene="spheres", warp=warp, fill="none", latency_ms=30.0, seconds=0.6, metrics_every=1)
    holes = [row["hole_share"] for row in result.rows if row["eye"] == 0]
    assert holes[0] == 1.0 and holes[-1] == 0.0 and sorted(holes, reverse=True) == holes
    link = result.summary["link"]
    assert 0.8 * 5000 < link["frame_bytes"] <= 5000


def test_a_head_at_rest_does_not_stop_what_is_still_to_come(tmp_path):
    """Frames in which nothing has moved are left out only once all has arrived."""
    network = LinkOptions.of({"send": "changes"})
    options = {"scene": "spheres", "trace": "still", "seconds": 0.5, "latency_ms": 20.0, "network": network}
    result = run(tmp_path, warp=PROGRESSIVE, fill="none", metrics_every=5, **options)
    (model,) = result.summary["client_models"]
    assert model["arrived"] == model["things"]
    assert result.summary["link"]["frames"]["unchanged"] > 0
