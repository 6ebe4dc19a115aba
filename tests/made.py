"""What a run makes that lives on the GPU: moderngl's own methods, counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import moderngl

# A scope lives in Python alone, but moderngl keeps each one until the context goes.
MAKERS = "buffer external_buffer texture external_texture texture_array texture3d texture_cube depth_texture"
MAKERS += " depth_texture_cube vertex_array program query framebuffer empty_framebuffer renderbuffer"
MAKERS += " depth_renderbuffer compute_shader sampler scope"


@contextmanager
def counting_made() -> Iterator[Counter[str]]:
    """How many of each of MAKERS are made inside the block."""
    made: Counter[str] = Counter()

    def counted(name: str) -> Callable[..., Any]:
        make = getattr(moderngl.Context, name)

        def count(*given: Any, **named: Any) -> Any:
            made[name] += 1
            return make(*given, **named)

        return count

    with ExitStack() as stack:
        for name in MAKERS.split():
            stack.enter_context(patch.object(moderngl.Context, name, counted(name)))
        yield made
