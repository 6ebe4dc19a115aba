"""Difference images: bit-exact where nothing moved, as before where the head did."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from client_scene import ClientScene
from golden_pictures import assert_golden, sheet
from run.gl_objects import living
from worlds import shown_by

from hmdwarp import warp_image
from hmdwarp.base import PlanError, linear_from_srgb, picture_from_linear, srgb8_from_linear
from hmdwarp.client import PassInputs, ShownPicture, WholeScene, build_plan, parse_warp
from hmdwarp.client.capability import lacking
from hmdwarp.client.classes import load_client
from hmdwarp.client.warps import Output
from hmdwarp.frames import EyeImage, Needs
from hmdwarp.frames.layers.scene_parts import Simplified
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate, download
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
    inputs = PassInputs(late, shown, shown_ns=shown_ns)
    colour, depth = shown_by(gpu, spec, inputs, SIZE, Output(depth=True), geometry)
    return colour[::-1].astype(np.float16), depth[::-1]


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


@pytest.mark.parametrize("lit", [True, False])
def test_the_server_sends_the_linear_light_of_half_the_difference(gpu, lit):
    """A store cuts a half's light off after 11 bits; one byte of difference is 0.9 % of it."""
    geometry, each = ClientScene(gpu, "gallery"), Simplified(0.05, lit=lit)
    image = geometry.server.draw_frame([HERE], 0, SIZE, 1.0, Needs(difference=frozenset({each}))).eyes[0]
    model = ShownPicture(Canvas(gpu.gl, SIZE), allocate(gpu.gl, SIZE, SCALAR))
    geometry.store(WholeScene, each).draw(HERE, model, 0)
    full, simplified = (
        srgb8_from_linear(download(picture)[..., :3].astype(float)).astype(float)
        for picture in (image.colour, model.colour.texture)
    )
    found = download(image["difference"][each])
    wanted = linear_from_srgb((full - simplified + 255) / 510)
    assert found[..., :3].astype(np.float64) == pytest.approx(wanted, rel=2**-10 + 1e-5)
    assert (found[..., 3] == 1).all()


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


def test_the_sum_is_as_before_and_its_depth_that_of_the_simplified_scene(gpu, tmp_path):
    """Also with bodies that have moved meanwhile."""
    spec, pictures = "difference:share=0.1", []
    for scene, guard, shown_ns in (("room", 1.4, 0), ("workshop", 1.0, 400_000_000)):
        geometry = ClientScene(gpu, scene)
        late = frame(gpu, geometry.server, spec, guard=guard)
        colour, depth = shown_of(gpu, geometry, spec, late, THERE, shown_ns)
        now = ShownPicture(Canvas(gpu.gl, SIZE), allocate(gpu.gl, SIZE, SCALAR))
        geometry.store(WholeScene, Simplified(0.1)).draw(THERE, now, shown_ns)
        assert np.array_equal(depth, download(now.depth))
        pictures.append((colour[::-1], depth[::-1]))
    assert_golden("effects/difference", sheet(*pictures), tmp_path)


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
