"""What averaging late frames costs: processor time of all threads over that of one bilinear frame.

The chains take turns, so that other programs and the caches cost each as much: each figure is the
median over the rounds of the ratio to the first chain of the same round. The frames are made: boxes
before a wall, with noise, from a head that goes sideways and turns.
"""

from __future__ import annotations

import contextlib

import numpy as np
from apparatus import in_turns, options, print_table, sizes_in

from hmdwarp import Fov, Pose, View, Warper
from hmdwarp.client import Compensator, PassInputs
from hmdwarp.frames import EyeImage
from hmdwarp.gpu import COLOUR, SCALAR, Gpu, allocate, upload

CHAINS = ("iterative:frames=1,resample=bilinear", *(f"iterative:frames={count}" for count in (1, 2, 3)))
FOV = Fov.symmetric(0.8, 0.55)


def view(k: int) -> View:
    """Return where frame k was drawn; -3 is shown."""
    half = 0.01 * k
    return View(Pose((0.02 * k, 0.005 * k, 0.0), (0.0, np.sin(half), 0.0, np.cos(half))), FOV)


def main() -> None:
    said = options(__doc__, size=("1280x800", "pixels"), rounds=(15, "in which the chains take turns"))
    (size,), rng = sizes_in(said.size), np.random.default_rng(0)
    y, x = np.mgrid[: size[1], : size[0]] // 100
    inverse_depth = np.where((x + y) % 3 == 0, 0.8, 0.25).astype(np.float32)
    rows = [[f"`{chain}`"] for chain in CHAINS]
    fills = ("none", "memory+pyramid")
    with Gpu() as gpu, contextlib.ExitStack() as stack:
        images = []
        for k in range(3):
            textures = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
            upload(textures[0], np.dstack([rng.random((*x.shape, 3), np.float32), np.ones(x.shape, np.float32)]))
            upload(textures[1], inverse_depth)
            images.append(EyeImage(view(k), *textures, drawn_ns=-k))
        inputs = PassInputs(images[0], view(-3), 0, (), tuple(images[1:]))
        for fill in fills:
            chains = {}
            for chain in CHAINS:
                plan = stack.enter_context(Warper(size, warp=chain, fill=fill, gpu=gpu)).plan
                chains[chain] = Compensator(gpu, plan, None, size, size)
                stack.callback(chains[chain].close)
            took = in_turns(gpu, {name: (lambda c=c: c.run(inputs)) for name, c in chains.items()}, said.rounds)
            for row, times in zip(rows, took.values(), strict=True):
                row.append(f"{np.median(times / took[CHAINS[0]]):.2f}")
    print_table(["", "alone", "with `memory+pyramid`"], rows)


if __name__ == "__main__":
    main()
