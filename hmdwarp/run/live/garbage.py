"""Python's garbage collector, kept out of the way of the pictures."""

from __future__ import annotations

import gc


class GarbageControl:
    """While it is entered, garbage is looked for after a picture was handed over, not in the middle of one.

    What is there at the start (modules, shaders, the scene) is set aside first, so that no collection looks through it.
    on: False leaves everything to Python, to compare.
    """

    def __init__(self, on: bool = True) -> None:
        self._on = on
        self._was_enabled = False

    def __enter__(self) -> GarbageControl:
        self._was_enabled = gc.isenabled()
        if self._on:
            gc.collect()
            gc.freeze()
            gc.disable()
        return self

    def between(self) -> None:
        """After a picture was handed over: the youngest objects alone, which a refresh makes some hundred of."""
        if self._on:
            gc.collect(0)

    def __exit__(self, *_: object) -> None:
        if self._on:
            gc.unfreeze()
            if self._was_enabled:
                gc.enable()
