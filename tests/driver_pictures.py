"""What pairs of warp and fill make of one random picture, for one driver beside another.

    python tests/driver_pictures.py OUT.npz

Says each pair before it runs, so that a driver that crashes leaves the name of what it crashed on.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import attrs
import moderngl
import numpy as np
from client_scene import ClientScene
from holed import Holed
from numpy.typing import NDArray
from worlds import World, every_choice, read

from hmdwarp.base import MachineError
from hmdwarp.client import Compensator, build_plan, every_fill, parse_warp
from hmdwarp.geometry import View
from hmdwarp.gpu import Gpu

SIZE = (37, 29)  # odd, and more than one work group each way


class Geometry(ClientScene):
    """The scene `planes` to fill from, and the depth that the random picture was made for."""

    def __init__(self, gpu: Gpu, world: World) -> None:
        super().__init__(gpu)
        self._world = world

    def draw_depth(self, view: View, size: tuple[int, int], into: moderngl.Texture, *_: object) -> None:
        into.write(self._world.client.astype(np.float32).tobytes(), alignment=1)


def pictures(gpu: Gpu) -> Iterator[tuple[str, NDArray[np.float64] | None]]:
    """Yield each pair's name, then it again with colour, coverage and inverse depth (h, w, 5).

    Of the third of three refreshes, so that a fill that remembers has something to remember.
    Inverse depth is 0 where the pair makes none. Left out is what this driver says it lacks.
    """
    for number, warp in enumerate(every_choice()):
        entry = parse_warp(warp).entry
        holed = Holed(gpu, 1, SIZE)
        world, wide = holed.world, holed.inputs.rendered["wide"]
        world.bring(gpu, entry)  # nothing but what this warp reads
        geometry, rendered = Geometry(gpu, world), world.rendered.having(wide=wide)
        for fill in every_fill()[number % 3 :: 3]:  # a fill knows nothing of the warp but its picture
            name = f"{warp} + {fill}"
            plan = build_plan((), warp, fill, "none", client_geometry=True)
            yield name, None
            try:
                compensator = Compensator(gpu, plan, None, SIZE, SIZE, geometry)
            except MachineError:
                continue
            inputs = attrs.evolve(world.inputs(entry), rendered=rendered)
            for _ in range(3):
                result = compensator.run(inputs)
                gpu.timer.collect()
            gpu.barrier()
            depth = result.inverse_depth
            yield name, np.dstack([read(result.shown.texture), np.zeros(SIZE[::-1]) if depth is None else read(depth)])
            compensator.close()


def all_of(gpu: Gpu) -> dict[str, NDArray[np.float64]]:
    """Return the pictures by the names of their pairs."""
    return {name: picture for name, picture in pictures(gpu) if picture is not None}


def main(out: Path) -> None:
    found = {}
    with Gpu() as gpu:
        print(gpu.renderer, gpu.version, gpu.timer.clock, sep="\n")
        for name, picture in pictures(gpu):
            if picture is None:
                print(name, flush=True)
            else:
                found[name] = picture
    np.savez(out, **found)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
