"""Where to draw, and with which switches on: moderngl's scopes, each made once."""

from __future__ import annotations

import moderngl


def drawing_into(framebuffer: moderngl.Framebuffer, flags: int | None = None) -> moderngl.Scope:
    """`with drawing_into(framebuffer, flags):` draws there, with those of moderngl's switches on alone; None leaves them as they are.

    The same scope for the same framebuffer and flags: a context that collects by itself (gc_mode "context_gc") keeps a piece of each one
    that was ever made, which in a loop is a leak.
    """
    if framebuffer.extra is None:
        framebuffer.extra = {}
    made = framebuffer.extra
    if flags not in made:
        made[flags] = framebuffer.ctx.scope(framebuffer, flags)
    return made[flags]
