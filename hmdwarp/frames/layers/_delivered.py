"""Layers that are no pictures but updates of something that the client keeps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

from ._base import Layer
from ._sizes import EyeSizes

if TYPE_CHECKING:
    import moderngl
    from numpy.typing import NDArray


class Wanted(Protocol):
    """What is delivered little by little; hashable and ordered."""

    @property
    def budget(self) -> int:
        """Bytes of each frame, at most."""


class Content(Protocol):
    """What one frame brings of it."""

    @property
    def content(self) -> NDArray[Any]:
        """The bytes; the link writes what it has decoded over it."""


class Delivered(Layer):
    """A Content for each Wanted. The amount is the frozenset of them."""

    per_frame = True
    builds_on_frames = True
    nothing = frozenset()

    @classmethod
    def bytes(cls, amount: frozenset[Wanted], sizes: EyeSizes) -> int:
        return sum(each.budget for each in amount)

    @classmethod
    def merged(cls, amount: frozenset[Wanted], other: frozenset[Wanted]) -> frozenset[Wanted]:
        return amount | other

    @classmethod
    def serves(cls, carried: frozenset[Wanted], needed: frozenset[Wanted]) -> bool:
        """Return whether all that is needed is delivered; more does not disturb."""
        return needed <= carried

    @classmethod
    def only(cls, data: Mapping[Any, Content], amount: frozenset[Any]) -> Mapping[Any, Content]:
        return data if data.keys() == amount else {each: data[each] for each in sorted(amount)}

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()

    @classmethod
    def sent(cls, data: Mapping[Any, Content]) -> Iterable[NDArray[Any]]:
        return [update.content for update in data.values()]
