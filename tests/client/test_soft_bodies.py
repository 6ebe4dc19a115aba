"""What deforms, drawn by the client. Against what the server draws at that instant, and in other
light."""

from __future__ import annotations

import attrs
import numpy as np
from golden_pictures import assert_golden, sheet
from worlds import read

from hmdwarp.client import ClientScene, PassInputs
from hmdwarp.client.effects import Tools, effects
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Canvas
from hmdwarp.pipeline import PipelineOptions, build_plan_for
from hmdwarp.scenes import Mesh, Scene, Waving, load_scene
from hmdwarp.sources.server import Server

from .modelled import picture_of

NAME, SIZE, MS = "soft_bodies", (64, 48), 1_000_000
FOV = Fov.from_tangents([-0.7, 0.7, -0.55, 0.55])
HERE = View(Pose((0.0, 1.5, 0.0)), FOV)
THERE = View(Pose((0.2, 1.6, -0.1), (0.0, 0.05, 0.0, 1.0)), FOV)  # 25 cm and 6 degrees from there

# Turned by 34 degrees; beyond the cloth and looking back.
ASIDE = View(Pose((0.0, 1.5, 0.0), (0.0, 0.3, 0.0, 1.0)), FOV)
BEHIND = View(Pose((0.0, 1.5, -3.8), (0.0, 1.0, 0.0, 0.0)), FOV)


def quad(name: str, centre, wide: float, high: float, light, **more) -> Mesh:
    corners = np.array([(-wide, -high, 0), (wide, -high, 0), (wide, high, 0), (-wide, high, 0)]) / 2 + centre
    return Mesh(name, corners, np.tile((0, 0, 1), (4, 1)), np.zeros((4, 2)), np.tile(light, (4, 1)),
                [(0, 1, 2), (0, 2, 3)], **more)  # fmt: skip


def cloth(cells: int = 6) -> Mesh:
    """A curtain that waves towards the eye and back, with a light and an albedo that vary."""
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, cells + 1)))
    rest = np.stack([1.2 * u - 0.6, 0.9 + 1.2 * v, np.full(u.size, -2.0)], axis=1)
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()[:, None]
    triangles = np.concatenate([first + (0, 1, cells + 2), first + (0, cells + 2, cells + 1)])
    albedo = np.stack([0.3 + 0.6 * u, 0.5 + 0 * u, 0.9 - 0.6 * v], axis=1)
    waves = Waving(rest, u, np.array((0.5, 0.3, 1.0)), height_m=0.35, length_m=1.0, period_s=1.7)
    return Mesh("cloth", rest, np.tile((0, 0, 1), (u.size, 1)), np.stack([u, v], 1), albedo * (0.4 + 0.5 * v[:, None]),
                triangles, double_sided=True, deformation=waves, albedo=albedo)  # fmt: skip


def world(*, deforming: bool = True) -> Scene:
    """A wall, a cloth before it, and a post before both."""
    still = [
        quad("wall", (0, 1.5, -4), 9, 7, (0.2, 0.5, 0.3)),
        quad("post", (0.25, 1.5, -1.2), 0.1, 3, (0.9, 0.9, 0.1)),
    ]
    return Scene("cloth", "", [*still, *([cloth()] if deforming else [])])


class Shown:
    """The pass over a picture that a perfect warp and fill would have made of everything else."""

    def __init__(self, gpu, now: View, age_ms: int, late: View = HERE, gain=(1.0, 1.0, 1.0), scene=None) -> None:
        self.scene = world() if scene is None else scene
        still = attrs.evolve(self.scene, meshes=[mesh for mesh in self.scene.meshes if mesh.deformation is None])
        server, without = Server(gpu, self.scene), Server(gpu, still)
        then_ns, now_ns = 300 * MS, (300 + age_ms) * MS
        frame = server.draw_frame([late], then_ns, SIZE)
        (rendered,) = frame.eyes
        self.late = read(rendered.colour) * (*gain, 1)
        rendered.colour.write(self.late.astype(np.float16).tobytes(), alignment=1)
        self.late, self.late_depth = read(rendered.colour), read(rendered.inverse_depth)[..., 0]
        truth = server.draw_frame([now], now_ns, SIZE, needs=Needs(velocity=True)).eyes[0]
        self.truth, self.truth_depth = read(truth.colour), read(truth.inverse_depth)[..., 0]
        self.covered = read(truth["velocity"])[..., 3] > 0
        before, picture, into = without.draw(now, SIZE), picture_of(gpu, SIZE), Canvas(gpu.gl, SIZE)
        self.before, self.before_depth = read(before.colour), read(before.inverse_depth)[..., 0]
        picture.colour.texture.write(before.colour.read(alignment=1), alignment=1)
        picture.depth.write(before.inverse_depth.read(alignment=1), alignment=1)
        entry = effects.get(NAME).made_by
        one = entry(gpu, frozenset([NAME]), SIZE, SIZE, Tools(None, 1, images=2, geometry=ClientScene(server)))
        given = PassInputs(rendered, now, others=(rendered,), shown_ns=now_ns)
        self.left = one.take_out(given)
        one.run(self.left, picture, into)
        gpu.gl.memory_barrier()
        self.out, self.out_depth = read(into.texture), read(picture.depth)[..., 0]
        self.left_colour = [read(image.colour) for image in (self.left.rendered, *self.left.others)]
        self.left_depth = read(self.left.rendered.inverse_depth)[..., 0]
        self.taken = read(
            server.draw_frame([late], then_ns, SIZE, needs=Needs(velocity=True)).eyes[0]["velocity"]
        )[..., 3] > 0  # fmt: skip
        one.close()
        self.then_ns, self.now_ns = then_ns, now_ns


CASES = [(HERE, 0, HERE), (THERE, 200, HERE), (THERE, 800, HERE), (THERE, 400, ASIDE), (THERE, 400, BEHIND)]
"""The last two: half of it out of the late view, and late from behind."""


def test_the_body_stands_where_it_is_now_in_the_light_of_the_late_picture(gpu, tmp_path):
    """Against the server's depth; that light is another than the scene's, so golden pictures."""
    pictures = []
    for now, age_ms, late in CASES:
        shown = Shown(gpu, now, age_ms, late, gain=(0.5, 1.2, 0.8))
        assert shown.covered.sum() > 400 and np.isfinite(shown.out).all()
        body = shown.out_depth != shown.before_depth
        # Rasterised twice, by two products of matrices: pixels of edges may differ.
        assert (body == shown.covered).mean() > 0.99
        assert (np.abs(shown.out_depth - shown.truth_depth) <= 1e-5 * (1 + shown.truth_depth)).mean() > 0.99
        assert np.array_equal(shown.out[~body], shown.before[~body])
        pictures.append((shown.out, shown.out_depth))
    assert_golden("effects/soft_bodies", sheet(*pictures), tmp_path)


def test_in_the_scenes_own_light_it_is_what_the_server_draws(gpu):
    """Each vertex was lit the same then, and what was out of the late view takes light nearby."""
    for now, age_ms, late in CASES[:3]:
        shown = Shown(gpu, now, age_ms, late)
        apart = np.abs(shown.out - shown.truth)[shown.covered].max(axis=-1)
        # A late pixel stands for one beside it, and this cloth changes by a tenth a vertex.
        assert np.median(apart) < 0.02


def test_all_of_it_is_taken_out_and_nothing_else(gpu):
    shown = Shown(gpu, THERE, 400)
    for left in shown.left_colour:
        assert (left[shown.taken] == 0).all()
        assert np.array_equal(left[~shown.taken], shown.late[~shown.taken])
    assert np.array_equal(shown.left_depth == -1, shown.taken)


def test_only_scenes_where_something_deforms_plan_it():
    options = PipelineOptions.of({"strategy": NAME})
    soft, plain = (build_plan_for(options, None, load_scene(name)) for name in ("parade", "planes"))
    assert soft.effects == (NAME,) and plain.effects == ()
    assert dict(plain.left_out)[NAME] == "nothing in the scene calls for it"
    assert dict(soft.left_out)["soft_motion"] == f"{NAME} stands in for it"
    assert [step.name for step in soft.steps if step.stage == "effects"] == ["soft bodies out", "soft bodies"]
    assert soft.needs == plain.needs, "no layer is sent for it"
    assert NAME not in effects.of(load_scene("parade"))
