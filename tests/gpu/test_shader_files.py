"""The shaders that are shipped: each compiles as used, and what is used of them."""

from __future__ import annotations

import re
from contextlib import suppress
from itertools import combinations, product

import attrs
import numpy as np
import pytest
from client_scene import ClientScene
from contexts import as_shipped
from panels import headset_for
from together import together
from worlds import every_choice

from hmdwarp.base import MachineError, folder
from hmdwarp.client import Carry, ShownDepth, every_fill, parse_fills, parse_warp
from hmdwarp.client.effects import EXPANDED, ExpandPass, Tools, effects
from hmdwarp.client.lens import LensPass, lenses
from hmdwarp.client.warps import Output, warps
from hmdwarp.display import Presenter
from hmdwarp.frames import Needs
from hmdwarp.frames.layers import layers
from hmdwarp.frames.layers.scene_parts import Simplified
from hmdwarp.geometry import Fov, Fovea, Hidden, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, Gpu, ShaderLibrary, allocate, flatten
from hmdwarp.headsets import load_headset
from hmdwarp.image.picture_arrays import ENCODINGS, SRGB8, raw_picture
from hmdwarp.metrics import PairPass
from hmdwarp.run import HoleCounter
from hmdwarp.scenes import Emission, Scene, Texture, load_scene, scenes
from hmdwarp.sources.array_passes import LINEAR, Arrays, GiveCodes, GiveOut, PixelBuffers, Scaling, TakeIn, Upload
from hmdwarp.sources.server import MIRRORS, Server

ROOT = folder("shaders")
FILES = sorted(p.relative_to(ROOT).as_posix() for p in ROOT.rglob("*.*"))
STAGES = [name for name in FILES if not name.endswith(".glsl")]


class Recorder(ShaderLibrary):
    """Remembers what is asked for; what it compiles, the session keeps."""

    def __init__(self, gpu: Gpu) -> None:
        super().__init__(gpu.gl)
        self._cache, self.hidden = gpu.shaders._cache, gpu.shaders.hidden
        self.hidden._shaders = self
        self.used: set[tuple[str, tuple]] = set()

    def _get(self, paths, defines, *made):
        self.used |= {(path, tuple(sorted(defines.items()))) for path in paths}
        return super()._get(paths, defines, *made)


@pytest.fixture(scope="module")
def variants() -> set[tuple[str, tuple]]:
    """(file, defines) of everything the program compiles. Every registered pass, the server with
    and without colour, the copy.

    In a context that is destroyed after it: all of it takes 600 MB."""
    with as_shipped(), Gpu() as gpu:
        before, gpu.shaders = gpu.shaders, Recorder(gpu)
        libraries = [made for lens in lenses if (made := lens(gpu, headset_for(lens.name), (8, 6))).library]
        one_colour = lenses.get("radial")(gpu, load_headset("cardboard-v2"), (8, 6))
        warps.get("rotation")(gpu, (9, 7), (8, 6), None, Output(one_colour)).close()
        for spec in every_choice():
            with suppress(MachineError):  # test_shaders_that_this_machine_cannot_compile_are_reported says so
                _compile_all(gpu, spec, libraries)
        for spec in every_fill():
            for choice in parse_fills(spec):
                for read in (True, False):
                    choice.entry(gpu, (9, 7), (8, 6), choice.settings, ClientScene(gpu), depth_read=read).close()
        carry = Carry(warps.get("forward")(gpu, (9, 7), (8, 6)))
        ShownDepth(gpu, carry, 1, (9, 7), (8, 6)).close()
        tools = Tools(carry, 1, geometry=ClientScene(gpu))
        _compile_effects(gpu, tools)
        for effect, lens in product((one for one in effects if one.fuses), (*libraries, one_colour)):
            effect.made_by(gpu, frozenset({effect.name}), (9, 7), (8, 6), attrs.evolve(tools, lens=lens)).close()
        server = Server(gpu, _shining(load_scene("planes")))
        server.draw(View(Pose(), Fov(-0.7, 0.7, -0.7, 0.7)), (8, 6))
        server = Server(gpu, load_scene("planes"))
        depth = allocate(gpu.gl, (8, 6), SCALAR)
        view = View(Pose(), Fov(-0.7, 0.7, -0.7, 0.7))
        server.draw(view, (8, 6))
        server.draw_depth(view, (8, 6), depth)
        server.draw_frame([view], 0, (8, 6), needs=Needs(peeled=1))
        server = Server(gpu, load_scene("planes"), samples=4)
        server.draw_frame([view], 0, (8, 6), needs=Needs(ids=True, velocity=True))
        _draw_every_content(gpu)
        gpu.shaders.compute("gpu/copy.comp")  # as the timers, which are probed before there is a library
        HoleCounter(gpu).close()
        _take_arrays_over(gpu)
        _give_arrays_out(gpu)
        PairPass(gpu, (9, 7), 20.0).close()
        for spec, depth in product(("difference", "difference:warped=off", "points"), (False, True)):
            choice = parse_warp(spec)
            choice.entry(gpu, (9, 7), (8, 6), choice.settings, Output(depth=depth), ClientScene(gpu)).close()
        warps.get("photons")(gpu, (9, 7), (8, 6), None, Output(), ClientScene(gpu, "lantern")).close()
        _present(gpu)
        used = gpu.shaders.used
        gpu.shaders = before.hidden._shaders = before
    return used


def _shining(scene: Scene) -> Scene:
    white = np.full((1, 1, 3), 255, np.uint8)
    textures = [Texture(each.name, each.image, emission=Emission(white, (1, 1, 1))) for each in scene.textures]
    return attrs.evolve(scene, textures=textures)


def _take_arrays_over(gpu: Gpu) -> None:
    """Colour of each type, depth of each form."""
    into, buffers = (allocate(gpu.gl, (9, 7), COLOUR), allocate(gpu.gl, (9, 7), SCALAR)), PixelBuffers(gpu, 1)
    ones, whole = np.ones((7, 9)), np.ones((7, 9), np.uint16)
    taking = TakeIn(gpu, (9, 7))
    for kind, channels, encoding in product((np.uint8, np.float16, np.float32), (3, 4), (None, "srgb")):
        for depth, scale in ((ones, None), (whole, 0.001), (whole.astype(np.int32), 1)):
            raw = raw_picture(np.ones((7, 9, channels), kind), depth, scale, encoding)
            taking.run(raw, taking.send(raw, buffers), into, buffers.found, 0)
    scaling = Scaling((9, 7), (0, 0, 9, 7))
    scaled = Arrays(np.ones((7, 9, 3), np.uint8), SRGB8, ones, is_apart=True, scaling=scaling)
    taking.run(scaled, taking.send(scaled, buffers), into, buffers.found, 0)
    for kind, depth in product((np.uint8, np.float32), (ones.astype(np.float32), whole)):
        upload = Upload(gpu, (9, 7))
        for is_inverse in (False, True):
            upload.run(Arrays(np.ones((7, 9, 3), kind), LINEAR, depth, is_inverse=is_inverse, is_apart=True), into)
        upload.close()
    giving = GiveCodes(gpu, (9, 7))
    giving.run(into)
    giving.close()
    taking.close()


def _give_arrays_out(gpu: Gpu) -> None:
    canvas, depth = Canvas(gpu.gl, (9, 7)), allocate(gpu.gl, (9, 7), SCALAR)
    giving, buffers = GiveOut(gpu, (9, 7)), PixelBuffers(gpu, 1)
    for result in (SRGB8, *ENCODINGS):
        giving.run(canvas, canvas, depth if result == SRGB8 else None, canvas, result, buffers)
    giving.run(canvas, canvas, None, None, SRGB8, buffers)
    giving.close()


def _compile_all(gpu: Gpu, spec: str, libraries: list[LensPass]) -> None:
    """As the plan may ask for it. For the shown view with and without its depth, through each lens,
    with and without scan-out."""
    choice = parse_warp(spec)
    for lens in [None, *libraries] if choice.entry.fuses else [None]:
        for scanout in [False, True] if choice.entry.scans_out else [False]:
            for depth in [False, True] if lens is None and choice.entry.depth_reads is not None else [False]:
                for hides in [False, True] if lens is None else [False]:
                    with gpu.shaders.hidden.skipping(hides):
                        choice.entry(gpu, (9, 7), (8, 6), choice.settings, Output(lens, scanout, depth)).close()


def _compile_effects(gpu: Gpu, tools: Tools) -> None:
    """Every pass with each set of the effects it may do."""
    warps.get("rotation")(gpu, (9, 7), (8, 6), None, Output(foveated=Fovea())).close()
    ExpandPass(gpu, frozenset(EXPANDED), (9, 7), (8, 6), tools).close()
    for made_by in {effect.made_by for effect in effects}:
        names = [effect.name for effect in effects if effect.made_by is made_by]
        for count in range(1, len(names) + 1):
            for parts in combinations(names, count):
                made_by(gpu, frozenset(parts), (9, 7), (8, 6), tools).close()


def _present(gpu: Gpu) -> None:
    presenter, into = Presenter(gpu), gpu.gl.framebuffer([gpu.gl.texture((4, 4), 4)])
    for hardware_srgb in (False, True):
        presenter.show(None, into, (0, 0, 4, 4), hardware_srgb=hardware_srgb)
    presenter.close()


def _draw_every_content(gpu: Gpu) -> None:
    """Every scene that has more than plain surfaces, whole and in layers; mirrors in both ways.
    Without what takes long and compiles nothing: fewer triangles, and a scene that is sent. What
    all scenes compile alike is drawn in one."""
    drawn = {layer.name: layer.something for layer in layers if layer.drawn_by and layer.name != "scene_update"}
    drawn["difference"] = frozenset({Simplified(share=1.0)})
    alike = {name: drawn.pop(name) for name in ("points", "photons")}
    for source in scenes:
        if source.effects:
            scene = source.build()
            for mirrors in MIRRORS if "planar_reflections" in source.effects else MIRRORS[:1]:
                server, view = Server(gpu, scene, mirrors), View(scene.viewpoint, Fov(-0.7, 0.7, -0.7, 0.7))
                everything = drawn | alike if source.name == "lantern" else drawn
                for needs in (Needs(), Needs(**everything)):
                    server.recycle(server.draw_frame([view], 0, (8, 6), needs=needs))
                server.close()
    hidden = View(view.pose, view.fov, hidden=Hidden((((-1, -1), (0, -1), (-1, 0)),), view.fov))
    server, depth = Server(gpu, scene), allocate(gpu.gl, (8, 6), SCALAR)
    server.recycle(server.draw_frame([hidden], 0, (8, 6)))
    server.draw_depth(hidden, (8, 6), depth)
    for into in (None, depth):
        gpu.shaders.hidden.hide(hidden, Canvas(gpu.gl, (8, 6)), into)
    server.close()


def test_every_stage_is_compiled_as_the_program_uses_it(variants):
    """A shader nobody asks for has no test and no user."""
    compiled, there = {path for path, _ in variants}, set(STAGES)
    assert compiled == there, f"no program compiles {sorted(there - compiled)}: take them out, or use them"


def test_every_include_is_used(variants):
    reached = {origin[0] for path, defines in variants for origin in flatten(path, dict(defines)).origins}
    assert {name for name in FILES if name.endswith(".glsl")} <= reached


def test_every_define_the_program_sets_is_read(variants):
    """By the file itself, or by another stage of drawing, which is given the same with it."""
    words = {name: set(re.findall(r"\w+", (ROOT / name).read_text(encoding="utf-8"))) for name in FILES}
    shared = set().union(*(words[name] for name in FILES if name.endswith(".glsl")))
    for path, defines in variants:
        drawn = {other for other, given in variants if given == defines and not other.endswith(".comp")}
        pair = (words[other] for other in (drawn if path in drawn else {path}))
        unread = {name for name, _ in defines} - shared.union(*pair)
        assert not unread, f"{path} is given {unread} and does not know it"


@together("name", [n for n in STAGES if n.endswith(".comp")])
def test_every_compute_shader_checks_its_bounds_first(name):
    outputs = {"OUTPUT": "lib/to_shown.glsl", "LENS": "lens/radial.glsl"}
    main = flatten(name, outputs).text.partition("void main() {")[2]
    if "barrier();" in main:
        return  # a work group that waits for all its members reads within bounds by construction
    assert re.search(r"if \(.*>=.*\) return;", "\n".join(main.splitlines()[:4]))


@together("name", FILES)
def test_writeonly_images_are_never_read(name):
    """Mesa compiles it, NVIDIA refuses it."""
    assert not read_though_writeonly((ROOT / name).read_text(encoding="utf-8"))


def read_though_writeonly(text: str) -> list[str]:
    """Members of writeonly blocks that stand anywhere but at the start of an assignment."""
    code = re.sub(r"//.*|^\s*#.*", "", text, flags=re.MULTILINE)
    blocks = re.findall(r"writeonly buffer \w+ \{(.*?)\}", code, re.DOTALL)
    members = [
        re.search(r"(\w+)\s*(\[\w*\])?$", each.strip())[1] for b in blocks for each in b.split(";") if each.strip()
    ]
    body = re.sub(r"writeonly buffer \w+ \{.*?\}", "", code, flags=re.DOTALL)
    start, rest = r"(?:[;{}):]|\belse)\s*$", r"\s*(\[[^;=]*\])?(\.\w+)*\s*=(?!=)"
    return [
        member
        for member in members
        for found in re.finditer(rf"(?<!\.)\b{member}\b", body)
        if not (re.search(start, body[: found.start()]) and re.match(rest, body[found.end() :]))
    ]


@together("name", FILES)
def test_there_is_no_array_of_bool(name):
    """Zink over lavapipe makes no pipeline of one (Mesa 22.3), and crashes where it should run."""
    text = re.sub(r"//.*", "", (ROOT / name).read_text(encoding="utf-8"))
    assert not re.search(r"\bbool\s+\w+\s*\[|\bbool\s*\[", text)
