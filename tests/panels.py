"""What a headset's panel shows of a random world.

By a warp that looks through the lens itself, and by warp and lens in two passes.
"""

from __future__ import annotations

import attrs
import numpy as np
from worlds import World, read

from hmdwarp.client import parse_warp
from hmdwarp.client.lens import lenses
from hmdwarp.client.warps import Output
from hmdwarp.geometry import View
from hmdwarp.gpu import Canvas
from hmdwarp.headsets import COLOURS, Headset, TableLens, ViveLens, load_headset


def headset_for(lens: str) -> Headset:
    """The DK1, with a lens of that model where it has another one."""
    headset = load_headset("rift-dk1")
    others = {
        "table": TableLens((0.0, 0.0), 0.04, (0, 30, 55), dict.fromkeys(COLOURS, (0, 0.6, 1))),
        "vive": ViveLens((0.0, 0.0), 1.0, 1.2, dict.fromkeys(COLOURS, (-0.2, 0, 0, 0)), 1.2),
    }
    eyes = tuple(attrs.evolve(eye, lens=others.get(lens, eye.lens)) for eye in headset.eyes)
    return attrs.evolve(headset, eyes=eyes)


def world_before(gpu, headset: Headset, eye: int, seed: int, size: tuple[int, int], *, moved: bool = True) -> World:
    """A world whose shown view has the headset's field of view."""
    world = World(gpu, seed, size, moved=moved)
    world.shown_view = View(world.shown_view.pose, headset.eyes[eye].fov)
    if not moved:
        world.rendered_view = world.shown_view
        world.upload(gpu)
    return world


def panel_of(
    gpu,
    world: World,
    spec: str,
    headset: Headset,
    eye: int,
    size: tuple[int, int],
    last: View | None = None,
    lens: str = "radial",
) -> np.ndarray:
    """(h, w, 4) the panel that the fused warp makes, bottom row first."""
    choice = parse_warp(spec)
    world.bring(gpu, choice.entry)
    output = Output(lenses.get(lens)(gpu, headset, size), last is not None)
    warp = choice.entry(gpu, world.size, world.shown_size, choice.settings, output)
    canvas = Canvas(gpu.gl, size)
    canvas.texture.write(
        np.full((size[1], size[0], 4), 7, np.float16).tobytes(), alignment=1
    )  # every pixel must be written
    warp.run(attrs.evolve(world.inputs(choice.entry), eye=eye, shown_last=last), canvas)
    gpu.gl.memory_barrier()
    out = read(canvas.texture)
    warp.close()
    canvas.release()
    return out


def in_two_passes(
    gpu, world: World, spec: str, headset: Headset, eye: int, size: tuple[int, int], lens: str = "radial"
) -> np.ndarray:
    """(h, w, 4) the same by the warp and then the lens."""
    choice = parse_warp(spec)
    world.bring(gpu, choice.entry)
    warp = choice.entry(gpu, world.size, world.shown_size, choice.settings)
    shown, panel = Canvas(gpu.gl, world.shown_size), Canvas(gpu.gl, size)
    warp.run(world.inputs(choice.entry), shown)
    gpu.gl.memory_barrier()
    lenses.get(lens)(gpu, headset, size).run(shown, world.shown_view.fov, eye, panel)
    gpu.gl.memory_barrier()
    out = read(panel.texture)
    warp.close()
    shown.release()
    panel.release()
    return out
