"""The registry of effects, with the choice of effects for a scene and a run."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING

from ...errors import InputError
from ...registry import Registry, unknown_name
from ._base import Effect

if TYPE_CHECKING:
    from ...scenes import Scene

AUTO, NONE, FORBID = "auto", "none", "no-"


class EffectRegistry(Registry[Effect]):
    """Effects by name, with an order in which lists show them."""

    def of(self, scene: Scene) -> tuple[str, ...]:
        """Return the names of the effects that a scene calls for."""
        return self.ordered(one.name for one in self if not one.by_name_only and _occurs(one, scene))

    def selected(self, text: str, declared: Collection[str], scene: Scene | None = None) -> tuple[str, ...]:
        """Return the names of the effects that a run compensates: `declared`, changed by `text`.

        text: "auto" changes nothing, "none" forbids all. Else names separated by commas, each
        forced, or forbidden by a leading "no-". Forcing an effect without content costs its pass
        and changes no picture; what only a name asks for is left out in a `scene` without content.
        Errors: UnknownNameError for a name; InputError for one that is both forced and forbidden.
        """
        forced, forbidden = self._told(text)
        idle = {name for name in forced if self.get(name).by_name_only and not _occurs(self.get(name), scene)}
        return self.ordered({*declared, *forced} - forbidden - idle)

    def forced(self, text: str) -> frozenset[str]:
        """Return the names that `text` forces. text, errors: as `selected`."""
        return frozenset(self._told(text)[0])

    def _told(self, text: str) -> tuple[set[str], set[str]]:
        """Return the names that are forced and those that are forbidden."""
        known = self.names()
        forced, forbidden = set[str](), set[str]()
        for word in filter(None, (part.strip() for part in text.split(","))):
            name = word.removeprefix(FORBID)
            if word == NONE:
                forbidden.update(known)
            elif name in known:
                (forced if name == word else forbidden).add(name)
            elif word != AUTO:
                raise unknown_name("effect", name, [*known, *(f"{FORBID}{one}" for one in known), AUTO, NONE])
        if both := self.ordered(forced & forbidden):
            raise InputError(f"--effects '{text}': {', '.join(both)} both forced and forbidden; choose one of the two")
        return forced, forbidden

    def ordered(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return the names in the order of their effects."""
        return tuple(sorted(names, key=lambda name: self.get(name).order))


def _occurs(effect: Effect, scene: Scene | None) -> bool:
    """Return whether some mesh has the effect; True where the scene is not known."""
    return scene is None or any(effect.applies(scene, mesh) for mesh in scene.meshes)
