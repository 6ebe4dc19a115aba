# Shows: a warp of your own, registered from outside the package; its shader is own_warp.comp.
# Writes: summary.json, frames.csv, report.html

import sys
from pathlib import Path

import attrs

import hmdwarp
from hmdwarp.client.warps import Warp, warps


@warps.register
class Wall(Warp):
    """Moves the rendered picture as a wall at one distance."""

    name = "wall"
    summary = "moves the picture as a wall at one distance"
    kind = "gather"
    reads = ("rendered.colour",)
    exact_when = "everything lies on the wall"
    gets_wrong = "what is nearer moves too little, what is farther too much"
    source = "examples/own_warp.py"
    Settings = attrs.make_class("WallSettings", {"distance_m": attrs.field(default=2.0, type=float)}, frozen=True)

    def prepare(self):
        self.program = self.gpu.shaders.compute(str(Path(__file__).with_suffix(".comp").resolve()), ROWS=8)

    def run(self, inputs, into):
        rendered = inputs.rendered
        view_map = hmdwarp.WarpMap.between(inputs.shown, self.shown_size, rendered.view, self.rendered_size)
        rendered.colour.use(0)
        into.bind_for_writing(0)
        self.set_sizes(self.program)
        self.program.uniforms.set(
            rendered_colour=0, written=0, H=view_map.H, e=view_map.e, distance_m=self.settings.distance_m
        )
        self.program.run(*into.size)


out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/own_warp")
run = {"trace": "walk", "headset": "rift-dk1", "size": (96, 120), "seconds": 0.3, "images": 0, "workers": 0, "out": out}
options = hmdwarp.RunOptions(warp="wall:distance_m=1.5", **run)
print(hmdwarp.replay(options).summary["quality"]["flip"])
