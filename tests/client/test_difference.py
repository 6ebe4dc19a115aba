"""Difference images: bit-exact where nothing moved, the twin's picture where the head did."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from client_scene import ClientScene
from commands import hmdwarp
from reference import difference as reference
from replays import run
from run.gl_objects import living

from hmdwarp import warp_image
from hmdwarp.client import PassInputs, ShownPicture, WholeScene, build_plan, parse_warp
from hmdwarp.client.capability import lacking
from hmdwarp.client.classes import load_client
from hmdwarp.client.warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE
from hmdwarp.client.warps import Output
from hmdwarp.colour import picture_from_linear, srgb_from_linear
from hmdwarp.errors import PlanError
from hmdwarp.frames import EyeImage, Needs
from hmdwarp.frames.layers.scene_parts import Simplified
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate, download
from hmdwarp.link.codec import Coding
from hmdwarp.scenes import load_scene, scenes
from hmdwarp.sources.server import Server

SIZE = (52, 41)
FOV = Fov(-0.7, 0.6, -0.55, 0.5)
HERE, THERE = View(Pose((0.05, 1.6, 0.1)), FOV), View(Pose((0.12, 1.55, 0.0), (0.01, 0.05, 0.0, 0.99)), FOV)
SPECS = ("difference", "difference:warped=off", "difference:share=0.05,light=off", "difference:share=1")


def frame(gpu, server: Server, spec: str, view: View = HERE, guard: float = 1.0) -> EyeImage:
    choice = parse_warp(spec)
    return server.draw_frame([view], 0, SIZE, guard, choice.entry.needs(choice.settings)).eyes[0]


def shown_of(gpu, geometry: ClientScene, spec: str, late: EyeImage, shown: View, shown_ns: int = 0):
    """Colour and inverse depth, top row first."""
    choice = parse_warp(spec)
    warp = choice.entry(gpu, late.size, SIZE, choice.settings, Output(depth=True), geometry)
    canvas, depth = Canvas(gpu.gl, SIZE), allocate(gpu.gl, SIZE, SCALAR)
    warp.run_with_depth(PassInputs(late, shown, shown_ns=shown_ns), canvas, depth)
    gpu.barrier()
    found = download(canvas.texture), download(depth)
    warp.close()
    return found


@pytest.mark.parametrize(
    ("scene", "spec"),
    [*((scene, "difference") for scene in scenes.names()), *(("gallery", spec) for spec in SPECS[1:])],
)
def test_a_still_head_sees_the_servers_picture_byte_for_byte(gpu, scene, spec):
    """With mirrors, glass and overlays: the difference has what the simplified scene lacks."""
    geometry = ClientScene(gpu, scene)
    late = frame(gpu, geometry.server, spec)
    colour, _ = shown_of(gpu, geometry, spec, late, HERE)
    assert np.array_equal(picture_from_linear(colour), picture_from_linear(download(late.colour)))
    assert (colour[..., 3] == 1).all()


def test_a_whole_scene_on_the_client_leaves_nothing_to_send(gpu):
    server = Server(gpu, load_scene("room"))
    late = frame(gpu, server, "difference:share=1")
    (texture,) = late["difference"].values()
    values = srgb_from_linear(download(texture)[..., :3].astype(np.float64))
    # 255 of 510, to the half of its light.
    assert values == pytest.approx(0.5, abs=2**-11)
    server.close()


@pytest.mark.parametrize("lit", [True, False])
def test_the_servers_pass_is_its_twin(gpu, lit):
    """A store cuts a half's light off after 11 bits; one byte of difference is 0.9 % of it."""
    scene, each = load_scene("gallery"), Simplified(0.05, lit=lit)
    geometry = ClientScene(gpu, "gallery")
    image = geometry.server.draw_frame([HERE], 0, SIZE, 1.0, Needs(difference=frozenset({each}))).eyes[0]
    model = ShownPicture(Canvas(gpu.gl, SIZE), allocate(gpu.gl, SIZE, SCALAR))
    geometry.store(WholeScene, each).draw(HERE, model, 0)
    wanted = reference.encoded(download(image.colour), download(model.colour.texture))
    found = download(image["difference"][each])
    assert found[..., :3].astype(np.float64) == pytest.approx(wanted, rel=2**-10 + 1e-5)
    assert (found[..., 3] == 1).all() and scene.meshes


def test_however_many_simplified_scenes_are_asked_for_few_are_kept(gpu):
    """As by a hostile client: after the first eight, as many objects go as come."""
    with closing(Server(gpu, load_scene("planes"))) as server:

        def asked(number: int) -> np.ndarray:
            each = Simplified(0.5, texture=1 / (2 + number))
            made = server.draw_frame([HERE], 0, SIZE, 1.0, Needs(difference=frozenset({each})))
            found = download(made.eyes[0]["difference"][each])
            server.recycle(made)
            return found

        first = asked(0)
        for number in range(1, 8):
            asked(number)
        kept = living()
        for number in range(8, 12):
            asked(number)
        gone = living()
        assert {kind: gone[kind] for kind in ("Texture", "Buffer", "VertexArray")} == {
            kind: kept[kind] for kind in ("Texture", "Buffer", "VertexArray")
        }
        np.testing.assert_array_equal(asked(0), first)  # made anew


@pytest.mark.parametrize(
    ("scene", "shown", "guard", "shown_ns"),
    [("room", HERE, 1.0, 0), ("room", HERE, 1.4, 0), ("room", THERE, 1.4, 0), ("workshop", THERE, 1.0, 400_000_000)],
)
def test_the_warp_is_its_twin(gpu, scene, shown, guard, shown_ns):
    """Where the tests and borders leave no doubt in float32; with bodies that move meanwhile.

    A difference is stored to 2**-10 of its light, at most 0.22 of a byte; the sum to 2**-10 of its
    own light, at most 0.11; and the place is right to 1e-4 of a pixel, between bytes of 255.
    """
    geometry = ClientScene(gpu, scene)
    late = frame(gpu, geometry.server, "difference:share=0.1", guard=guard)
    each = Simplified(0.1)
    found, depth = shown_of(gpu, geometry, "difference:share=0.1", late, shown, shown_ns)
    pictures = []
    for view, size, time_ns in ((shown, SIZE, shown_ns), (late.view, late.size, 0)):
        made = ShownPicture(Canvas(gpu.gl, size), allocate(gpu.gl, size, SCALAR))
        geometry.store(WholeScene, each).draw(view, made, time_ns)
        pictures.append((download(made.colour.texture)[::-1], download(made.depth)[::-1]))
    sent = srgb_from_linear(download(late["difference"][each])[::-1, :, :3].astype(np.float64)) * 510 - 255
    wanted, doubtful = reference.warped(
        shown, pictures[0], late.view, pictures[1], np.rint(sent), DEPTH_TOLERANCE, DEPTH_FLOOR
    )
    assert doubtful.mean() < 0.1 or shown is HERE
    clear = ~doubtful if shown is THERE else np.ones_like(doubtful)
    bytes_found = 255 * srgb_from_linear(found[::-1, :, :3].astype(np.float64))
    assert np.abs(bytes_found - wanted)[clear].max() <= 0.22 + 0.11 + 0.05
    assert np.array_equal(depth[::-1], pictures[0][1])


@pytest.mark.parametrize("spec", ["difference", "difference:warped=off"])
def test_a_codec_costs_the_last_of_nine_bits_and_its_own_error(tmp_path, spec):
    """8 bits hold half of the levels, so a byte is off by at most one; x264's best adds its own."""
    options = {"scene": "spheres", "warp": spec, "latency_ms": 0.0, "seconds": 0.2, "size": (96, 80)}
    exact = run(tmp_path / "exact", **options)
    coded = run(tmp_path / "coded", coding=Coding("h264", crf=0), **options)
    assert exact.summary["quality"]["psnr_db"]["mean"] == 100
    assert 30 < coded.summary["quality"]["psnr_db"]["mean"] < 60


@pytest.mark.parametrize("spec", [spec for spec in SPECS if "warped=off" not in spec])
def test_hard_views_give_no_nan_and_no_hole(gpu, spec):
    """From behind, from within a wall, from far away: the simplified scene is shown."""
    geometry = ClientScene(gpu, "room" if spec == "difference" else "gallery")
    late = frame(gpu, geometry.server, spec)
    for shown in (
        View(Pose((0.05, 1.6, 0.1), (0, 1, 0, 0)), FOV),
        View(Pose((2.5, 0.2, 2.5)), FOV),
        View(Pose((1e6, 1.6, 0.1)), FOV),
    ):
        colour, depth = shown_of(gpu, geometry, spec, late, shown)
        assert np.isfinite(colour).all() and np.isfinite(depth).all() and (colour[..., 3] == 1).all()


def test_frames_without_a_scene_or_the_layer_are_refused(gpu):
    picture = np.zeros((4, 6, 3), np.uint8)
    with pytest.raises(PlanError, match="warp difference needs"):
        warp_image(picture, np.ones((4, 6)), HERE, HERE, "difference")
    plain = EyeImage(HERE, allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR))
    with pytest.raises(PlanError, match="needs the layer 'difference'"):
        shown_of(gpu, ClientScene(gpu, "planes"), "difference", plain, HERE)


def test_clients_need_as_much_of_the_scene_as_is_drawn():
    reduced, whole = (
        build_plan((), f"difference:share={share}", "none", "none", client_geometry=True) for share in (0.2, 1)
    )
    classes = {name: load_client(name) for name in ("class-1", "class-2", "class-3")}
    assert "the scene's geometry" in lacking(reduced, classes["class-1"])
    assert not lacking(reduced, classes["class-2"]) and "whole scene" in lacking(whole, classes["class-2"])
    assert not lacking(whole, classes["class-3"])


def test_the_plan_reads_no_picture():
    done = hmdwarp("plan", "--strategy", "difference", "--json")
    assert '"rendered.colour"' not in done.stdout and '"rendered.inverse_depth"' not in done.stdout
    assert '"rendered.difference"' in done.stdout
