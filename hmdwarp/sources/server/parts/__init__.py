"""Content of frames besides plain surfaces, by families: in the picture, or as layers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, ClassVar, Generic, TypeVar

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ....base import Registry
from ....frames import EyeImage, Needs
from ....frames.layers import layers
from ....geometry import View
from ....gpu import Gpu
from ....gpu.textures import COLOUR, SCALAR, Owner, allocate
from ....scenes import Scene
from ..passes import ScenePasses, SceneTextures
from ..targets import MOST_SETTINGS, Framebuffers, LastUsed, Renderer, Target

_VIEWS = ("cube", "difference", "foveated", "motion", "scene_update", "views", "wide")
_BLENDED = ("cutouts", "light", "overlay", "panels", "peeled", "transparency")
_MODULES = dict.fromkeys(_VIEWS, "views") | dict.fromkeys(_BLENDED, "blended")
parts: Registry[type[Part]] = Registry("part", __name__, modules=_MODULES)


@attrs.frozen(eq=False)
class Drawing:
    view: View  # as the eye has it, without guard band
    size: tuple[int, int]  # (w, h) pixels of it
    time_ns: int = 0  # the scene's clock
    needs: Needs = Needs()  # the layers to draw
    shown_size: tuple[int, int] | None = None  # (w, h) of the display's picture, where this one has another resolution
    marched: bool = False  # whether plane mirrors show only what the picture itself shows, see Server
    age_ns: int = 0  # how old the frame will be when it is seen
    client: Hashable = None  # for whom it is drawn, where that matters; None for the one that there is

    def of_light(self, view: View, size: tuple[int, int]) -> Drawing:
        """Return another picture at this instant, lit alike, without layers or overlays."""
        kept = {name for name in self.needs if layers.get(name).lights or layers.get(name).laid_over}
        needs = Needs(**{name: amount for name, amount in self.needs.items() if name in kept})
        return Drawing(view, size, self.time_ns, needs)


@attrs.frozen(eq=False)
class DrawContext:
    gpu: Gpu
    scene: Scene
    textures: SceneTextures  # the scene's, on the GPU
    framebuffers: Framebuffers
    colour: ScenePasses  # the passes of the plain surfaces
    acquire: Callable[..., Target]  # (size, kind, depth=): freed with the frame; kind as in gpu.textures
    draw: Callable[[View, tuple[int, int], Drawing], EyeImage]  # draws a whole picture of another view
    passes_for: Callable[[Drawing], ScenePasses]  # those of the plain surfaces, lit as its layers say
    # draw_colour(passes, view, into, time_ns): with as many samples a pixel as the picture has.
    draw_colour: Callable[[ScenePasses, View, moderngl.Texture, int], None]
    renderer: Callable[[Scene], Renderer]  # renderer(scene): a server of another scene; who makes it closes it


class Part(Owner, ABC):
    """One kind of content, made when a scene has any or frames need a layer `drawn_by` it."""

    name: ClassVar[str]
    order: ClassVar[int]
    of_client: ClassVar[bool] = False  # whether it depends on the frames before: each client has its own then

    def __init__(self, context: DrawContext) -> None:
        self.context = context
        self._kept: LastUsed[tuple[str, tuple[int, int]], Target] = LastUsed()

    def kept(self, use: str, size: tuple[int, int], kind: tuple[int, str] = COLOUR, *, depth: bool = True) -> Target:
        """Return a target that belongs to the part, one for each use and size."""
        gl, kinds = self.context.gpu.gl, (kind, SCALAR) if depth else (kind,)
        return self._kept.made((use, size), lambda: Target(*(allocate(gl, size, one) for one in kinds)))

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        """Return whether the scene has any of it in the picture itself."""
        return False

    def passes_for(self, drawing: Drawing) -> ScenePasses | None:
        """Return what draws the plain surfaces in place of the server's passes, or None."""
        return None

    @abstractmethod
    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        """Draw what is not a needed layer into the eye; return the eye with its layers."""

    def add_depth(self, view: View, time_ns: int, into: moderngl.Texture) -> None:  # noqa: B027 (most have none)
        """Draw content that has a depth into the inverse depth of the plain surfaces."""

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        """Return the layers that all eyes share, once a frame. views: with guard band."""
        return {}

    def heard(self, carried: Mapping[str, Any], arrived: bool, heard_ns: int) -> None:  # noqa: B027 (most do not)
        """Take note of whether a frame with these layers arrived, heard of at that instant."""

    def has_more(self, now_ns: int) -> bool:
        return False

    def trim(self) -> None:
        for _, target in self._kept.trimmed(lambda _, target: target.bytes):
            target.release(self.context.framebuffers.forget)

    def close(self) -> None:
        """Free its resources; the shader library owns programs, the server acquired targets."""
        super().close()
        for target in self._kept.values():
            target.release()


Array = NDArray[np.float64]
FIRST_ROUND_TRIP_NS = 200_000_000  # from sending to the news of the arrival, until the first news says it
FRAMES = 16  # the head's speed is the fastest between two of so many frames
NEAREST_M = 0.1  # an eye that is this near to a piece, or inside, sees all of it


class Sender:
    book: Any  # what was sent, a frames.layers.Book
    complete = False  # whether nothing waits to be sent

    def has_more(self, now_ns: int) -> bool:
        return not self.complete


Wanted = TypeVar("Wanted")
S = TypeVar("S", bound=Sender)


class Sending(Part, Generic[Wanted, S]):
    of_client = True

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._senders: LastUsed[Wanted, S] = LastUsed()

    @abstractmethod
    def make_sender(self, wanted: Wanted) -> S:
        """Return the sender of a variant."""

    def sender(self, wanted: Wanted) -> S:
        return self._senders.made(wanted, lambda: self.make_sender(wanted))

    def needed(self, drawing: Drawing) -> list[Wanted]:
        """Return the variants that a picture needs, in their order; others are kept, but a few."""
        found = sorted(drawing.needs.get(self.name, frozenset()))
        for wanted in found:
            self.sender(wanted)
        self._senders.beyond(max(MOST_SETTINGS, len(found)))
        return found

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye

    def heard(self, carried: Mapping[str, Any], arrived: bool, heard_ns: int) -> None:
        for wanted, update in carried.get(self.name, {}).items():
            if wanted in self._senders:
                self._senders[wanted].book.heard(update, arrived, heard_ns)

    def has_more(self, now_ns: int) -> bool:
        return any(sender.has_more(now_ns) for sender in self._senders.values())


class Head:
    def __init__(self) -> None:
        self._seen: deque[tuple[int, View]] = deque(maxlen=FRAMES)

    def see(self, view: View, now_ns: int) -> None:
        if not self._seen or now_ns > self._seen[-1][0]:
            self._seen.append((now_ns, view))

    def reach(self, within_ns: int | None) -> tuple[float, float]:
        within_ns = within_ns or FIRST_ROUND_TRIP_NS
        metres = radians = 0.0
        for (before_ns, before), (now_ns, now) in zip(self._seen, list(self._seen)[1:], strict=False):
            times = within_ns / (now_ns - before_ns)
            metres = max(metres, times * float(np.linalg.norm(now.pose.position_m - before.pose.position_m)))
            turned = before.pose.angle_to(now.pose)
            radians = max(radians, min(times * turned, math.pi))
        return metres, radians


def boxes_at(
    scene: Scene, bodies: NDArray[np.int64], centres: Array, halves: Array, time_ns: int
) -> tuple[Array, Array]:
    """Return centres and halves (n, 3) at an instant; bodies' from their axes, however turned."""
    centres, halves = centres.copy(), halves.copy()
    for number in set(bodies.tolist()) - {0}:
        world_from_body = scene.bodies[number - 1].motion.state(time_ns).pose.matrix()
        own = bodies == number
        centres[own] = centres[own] @ world_from_body[:3, :3].T + world_from_body[:3, 3] - scene.origin_m
        halves[own] = np.linalg.norm(halves[own], axis=1, keepdims=True)
    return centres, halves


def distances(eye: Array, centres: Array, halves: Array) -> Array:
    away: Array = np.linalg.norm(np.maximum(np.abs(centres - eye) - halves, 0), axis=1)
    return away
