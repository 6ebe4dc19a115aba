"""What a run asks of the GPU.

Which programs it compiles, what it allocates, how often it dispatches and draws, what a frame
weighs.
"""

from __future__ import annotations

import functools
from collections import Counter

import attrs
import moderngl
import pytest
from replays import small

from hmdwarp.frames import frame_bytes
from hmdwarp.gpu import ShaderLibrary, timers
from hmdwarp.run import set_up_replay

ALLOCATIONS = ("texture", "buffer", "framebuffer", "depth_renderbuffer", "vertex_array")
WORK = ((moderngl.ComputeShader, "run"), (moderngl.ComputeShader, "run_indirect"), (moderngl.VertexArray, "render"))
WORK += ((moderngl.VertexArray, "render_indirect"),)


@attrs.frozen
class Costs:
    """shaders: the files of all programs compiled.

    made: how many of each kind of thing. work: dispatches and draws of one refresh, drawing the
    frame included. layers: bytes of each layer of a frame; sent: of a frame, as the link
    was told. textures: how many of each size, components and type.
    """

    shaders: frozenset[str]
    made: dict[str, int]
    work: dict[str, int]
    layers: dict[str, int]
    sent: int
    textures: dict[tuple, int]


def costs_of(refreshes: int = 3, **options: object) -> Costs:
    """Return the costs of a small run in its steady state; the same run is counted once."""
    return _costs_of(refreshes, tuple(sorted(options.items())))


@functools.cache
def _costs_of(refreshes: int, options: tuple[tuple[str, object], ...]) -> Costs:
    shaders: set[str] = set()
    made, work, textures = Counter(), Counter(), Counter()
    asked = small(latency_ms=50.0, rate_hz=60.0, **dict(options))
    with pytest.MonkeyPatch.context() as patch:
        get = ShaderLibrary._get

        def recorded(self, paths, defines, *more):
            shaders.update(paths)
            return get(self, paths, defines, *more)

        patch.setattr(ShaderLibrary, "_get", recorded)
        patch.setattr(timers, "check_clocks", _uncounted(timers.check_clocks, made, textures))
        for kind in ALLOCATIONS:
            patch.setattr(moderngl.Context, kind, _counted(getattr(moderngl.Context, kind), made, kind, textures))
        for owner, name in WORK:
            patch.setattr(owner, name, _counted(getattr(owner, name), work, f"{owner.__name__}.{name}", None))
        with set_up_replay(asked) as setup:
            shown = 0
            for number, instant_ns in setup.schedule.numbered():
                work.clear()
                setup.loop.draw(instant_ns)
                shown += number >= 0 and setup.loop.show(instant_ns) is not None
                if shown == refreshes:
                    break
            assert shown == refreshes
            layers = frame_bytes(setup.plans[0].needs, setup.sizes, setup.plans[0].layers)
            return Costs(
                frozenset(shaders), dict(made), dict(work), layers, setup.channel.transit.size_bytes, dict(textures)
            )


def _uncounted(probe, *counters: Counter):
    """What the probe of the clock makes is not the run's, and depends on how busy a machine is."""

    def call(gl):
        before = [Counter(counter) for counter in counters]
        found = probe(gl)
        for counter, old in zip(counters, before, strict=True):
            counter.clear()
            counter.update(old)
        return found

    return call


def _counted(function, counter: Counter, name: str, textures: Counter | None):
    def call(*args, **kwargs):
        counter[name] += 1
        if name == "texture" and textures is not None:
            textures[tuple(args[1]), args[2], kwargs.get("dtype", "f1")] += 1
        return function(*args, **kwargs)

    return call
