"""Scopes that bind a framebuffer and moderngl flags; each is created once."""

from __future__ import annotations

import moderngl


def drawing_into(framebuffer: moderngl.Framebuffer, flags: int | None = None) -> moderngl.Scope:
    """Return a scope that draws into `framebuffer` with only these flags on.

    flags: moderngl's; None leaves them unchanged. The same framebuffer and flags give the same
    scope: a context with gc_mode "context_gc" keeps a part of each scope ever made, which in a loop
    is a leak.
    """
    if framebuffer.extra is None:
        framebuffer.extra = {}
    made = framebuffer.extra
    if flags not in made:
        made[flags] = framebuffer.ctx.scope(framebuffer, flags)
    return made[flags]
