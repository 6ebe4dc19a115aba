"""The scene as the client has it, and what the client keeps from frame to frame."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, ClassVar, TypeVar, cast

import moderngl

from ..frames import Frame
from ..geometry import View
from ..scenes import ArrivedState
from ..sources.server import Renderer

Size = tuple[int, int]


class Store:
    """Something that the client keeps for all passes that ask for the same: on the GPU, or not.

    A strategy declares one next to its warp, effect or fill. Each is made at first use, and closed
    with the client's scene. Which of its kind it is, `wanted` says: an attrs class, a tuple, or
    None where there is one only.
    """

    # The frame layer whose updates it receives, see receiver_of; "" for none.
    layer: ClassVar[str] = ""

    def __init__(self, client: ClientScene, wanted: Any) -> None:
        self.client, self.wanted = client, wanted

    def receive(self, content: Any) -> None:
        """Take what a frame brought; frames may come in any order, and more than once."""

    def begin_anew(self) -> None:
        """Forget what has arrived: the sender begins with nothing."""
        self.close()
        type(self).__init__(self, self.client, self.wanted)

    def weights(self) -> list[dict[str, Any]]:
        """Return what it takes in memory and on the link, one dict for each row of the report.

        `share` and `texture` say which model it is of; else the last entry is how many things it
        holds, named for them, and `geometry_bytes` is there.
        """
        return []

    def close(self) -> None:
        """Free its buffers; the shader library owns the programs."""


StoreT = TypeVar("StoreT", bound=Store)
_receivers: dict[str, type[Store]] = {}


def receiver_of(layer: str) -> Callable[[type[StoreT]], type[StoreT]]:
    """Return a decorator: the class receives the updates of that layer, a Delivered."""

    def register(kind: type[StoreT]) -> type[StoreT]:
        if layer in _receivers:
            raise ValueError(f"layer '{layer}' is received by {_receivers[layer].__name__} already")
        kind.layer = layer
        _receivers[layer] = kind
        return kind

    return register


class ClientScene:
    """What a client with some of the scene can draw by itself, for any view and instant.

    server: of the same scene; it draws the exact depth, and belongs to the caller. arrived: what
    the server's scene knows of its own motion, where that comes with the frames.
    """

    def __init__(self, server: Renderer, arrived: ArrivedState | None = None) -> None:
        self.server, self.gpu, self.scene = server, server.gpu, server.scene
        self._arrived = arrived
        self._stores: dict[tuple[type[Store], Hashable], Store] = {}
        # Of the newest frame that was received: what it built on, and when it was drawn.
        self._newest: tuple[int, int] | None = None

    @property
    def is_still(self) -> bool:
        """Whether the scene is known to look the same at all times and from everywhere."""
        return self.scene.is_still

    def draw_depth(self, view: View, size: Size, into: moderngl.Texture, time_ns: int = 0) -> None:
        """Draw inverse depth of all triangles into an r32f texture, -1 where nothing is."""
        self.server.draw_depth(view, size, into, time_ns)

    def store(self, kind: type[StoreT], wanted: Hashable = None) -> StoreT:
        """Return the store of that kind; it is made at first use."""
        key = (kind, wanted)
        if key not in self._stores:
            self._stores[key] = kind(self, wanted)
        return cast("StoreT", self._stores[key])

    def receive(self, frame: Frame) -> None:
        """Hand what a frame brings to the stores; call it with each frame that arrives."""
        if self._arrived is not None:
            self._arrived.take(frame.drawn_ns)
        began, drawn_ns = self._newest or (frame.began, frame.drawn_ns)
        if frame.began != began:  # it does not build on what is here: an older one is late, a newer one begins anew
            if frame.drawn_ns < drawn_ns:
                return
            for store in self._stores.values():
                if store.layer:
                    store.begin_anew()
        self._newest = frame.began, max(drawn_ns, frame.drawn_ns)
        for layer, kind in _receivers.items():
            for wanted, update in frame.eyes[0].carried.get(layer, {}).items():
                self.store(kind, wanted).receive(update.content)

    def weights(self) -> list[dict[str, Any]]:
        """Return the weights of all stores as they were made, first of those that never crossed."""
        found = [weight for store in self._stores.values() for weight in store.weights()]
        return sorted(found, key=lambda weight: "start_up_bytes" in weight)

    def close(self) -> None:
        """Close the stores; the caller closes the server."""
        for store in self._stores.values():
            store.close()
        self._stores.clear()
