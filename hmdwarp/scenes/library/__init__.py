"""The scenes of the library: a table each, and most a model."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import attrs

from ...registry import Registry
from .._scene import Scene
from ..input_events import InputLog
from ._models import moving, stored_scene


@attrs.frozen(eq=False)
class SceneSource:
    """A registered scene before it is built; listing scenes builds nothing."""

    name: str
    summary: str
    build: Callable[[], Scene]  # makes the scene, the same arrays every time
    effects: tuple[str, ...] = ()  # names of the effects that the built scene's content calls for
    # The fields of the built scene, by name, that follow from inputs; None where none do.
    reacts: Callable[[InputLog], dict[str, Any]] | None = None


def _of_table(name: str, table: dict[str, Any]) -> SceneSource:
    reacts = partial(moving, table, arrays={}) if table.get("reacts") else None
    effects = tuple(table.get("effects", ()))
    return SceneSource(name, table["summary"], partial(stored_scene, name, table), effects, reacts)


scenes: Registry[SceneSource] = Registry("scene", __name__, group="scenes", of_table=_of_table, columns="effects")
