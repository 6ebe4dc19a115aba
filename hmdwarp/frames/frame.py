"""What was drawn, and the exact views it was drawn for: they travel together, always."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import attrs

from ..geometry import View
from ..poses import PoseSample
from .layers import PIXEL_BYTES, EyeSizes, Layer, layers

if TYPE_CHECKING:
    import moderngl

Picture = TypeVar("Picture")


@attrs.frozen(eq=False)
class EyeImage:
    """One eye's picture and its view. Rows run bottom to top, as OpenGL has them.

    Where nothing was drawn colour is (0, 0, 0, 0) and inverse depth is -1, so that a hole is
    neither averaged into its neighbours nor scattered. The further layers (see frames.layers) are
    read like a mapping: `image["cube"]`, `image.get("ids")`, `"wide" in image`.
    """

    view: View
    colour: moderngl.Texture  # rgba16f, linear light with coverage in alpha
    inverse_depth: moderngl.Texture  # r32f in 1/m
    # The further layers by name, as each layer's file describes them.
    carried: Mapping[str, Any] = attrs.field(factory=dict)
    drawn_ns: int = 0  # when it was drawn
    # 1/m by which a code may have changed the inverse depth of nearly every pixel; 0 as drawn.
    depth_error: float = 0.0
    # Of layers.PICTURE what no plan reads, and is empty therefore; the further layers are there.
    left_out: frozenset[str] = frozenset()

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) in pixels."""
        return self.colour.size

    def __getitem__(self, name: str) -> Any:
        return self.carried[name]

    def __contains__(self, name: str) -> bool:
        return name in self.carried

    def get(self, name: str, default: Any = None) -> Any:
        """Return a further layer's data, or `default` where the image lacks it."""
        return self.carried.get(name, default)

    def having(self, **data: Any) -> EyeImage:
        """Return the same image with these further layers; None takes one out."""
        merged = {**self.carried, **data}
        return attrs.evolve(self, carried={name: one for name, one in merged.items() if one is not None})

    def only(self, needs: Needs) -> EyeImage:
        """Return the image as frames drawn for these needs alone would carry it.

        The same object where nothing is left out, as at most refreshes: the loop asks at each.
        """
        if not self.carried:
            return self
        kept = {name: layers.get(name).only(one, needs[name]) for name, one in self.carried.items() if name in needs}
        if all(kept.get(name) is one for name, one in self.carried.items()):
            return self
        return attrs.evolve(self, carried=kept)

    def contents(self) -> list[tuple[type[Layer], Any]]:
        """Return every layer with its data, colour and inverse depth first."""
        everything = {"colour": self.colour, "inverse_depth": self.inverse_depth, **self.carried}
        return [(layers.get(name), data) for name, data in everything.items()]

    def textures(self) -> Iterator[moderngl.Texture]:
        """Yield every texture of every layer."""
        for layer, data in self.contents():
            yield from layer.textures(data)


@attrs.frozen(eq=False)
class Frame:
    """All eyes as the server drew them."""

    eyes: tuple[EyeImage, ...]
    drawn_ns: int
    # The world_from_head that the frame was drawn for, and its origin; None where only the views
    # are known.
    head: PoseSample | None = None
    # The GPU's work for it, as gpu.timers.Lap has it; read its time when that is done.
    drawing: Any = None
    # Tells apart what the sender began anew: what builds on the frames before begins with them.
    began: int = 0
    # Milliseconds of work on its way, by name (render, encode, decode); the worker enters them.
    timings_ms: dict[str, float] = attrs.field(factory=dict)
    # Instant of the scene that the pictures show, where a proxy made them of older ones.
    older_ns: int | None = None

    @property
    def shows_ns(self) -> int:
        """The instant of the scene that the pictures show."""
        return self.drawn_ns if self.older_ns is None else self.older_ns

    @property
    def render_ms(self) -> float:
        """How long the server drew it; waits for the GPU if it has not finished."""
        if "render" in self.timings_ms or self.drawing is None:
            return self.timings_ms.get("render", 0.0)
        return float(sum(milliseconds for _, milliseconds in self.drawing.read()))

    def pictures(self) -> list[tuple[int, EyeImage]]:
        """Return the number and the picture of each eye, a picture that both see once."""
        found = [(0, self.eyes[0])]
        for number, eye in enumerate(self.eyes):
            if eye.colour is not self.eyes[0].colour:
                found.append((number, eye))
        return found


@attrs.frozen
class Others:
    """Which other pictures a plan uses."""

    past: int = 0  # how many older frames the client keeps
    spacing_ns: int = 0  # the least time between two of them
    other_eye: bool = False  # whether the other eye's picture is used as well
    recent: int = 0  # how many frames straight before the newest the client keeps beside those

    def __bool__(self) -> bool:
        """Return whether any other picture is used."""
        return bool(self.past or self.other_eye or self.recent)

    def of(self, carried: Others, pictures: tuple[Picture, ...]) -> tuple[Picture, ...]:
        """Return those that this needs of the pictures that `carried` brought."""
        skipped = int(carried.other_eye and not self.other_eye)
        return pictures[skipped : skipped + self.count]

    @property
    def count(self) -> int:
        """The most other pictures that one eye gets, without the recent ones."""
        return self.past + self.other_eye


@layers.register
class OtherPictures(Layer):
    """Adds nothing to a frame: these pictures are frames that the link has brought already.

    The amount is an Others.
    """

    name = "others"
    summary = "the other eye's picture and older frames, which the client has already"
    of_client = True
    nothing, something = Others(), Others(past=1, other_eye=True)

    @classmethod
    def bytes(cls, amount: Others, sizes: EyeSizes) -> int:
        return 0

    @classmethod
    def merged(cls, amount: Others, other: Others) -> Others:
        """Return enough for both, with the shorter of their spacings."""
        spacings = [each.spacing_ns for each in (amount, other) if each.past]
        past, other_eye = max(amount.past, other.past), amount.other_eye or other.other_eye
        return Others(past, min(spacings, default=0), other_eye, max(amount.recent, other.recent))

    @classmethod
    def serves(cls, carried: Others, needed: Others) -> bool:
        """Return whether at least as many are kept, equally far apart; more do not disturb."""
        past = not needed.past or (needed.past <= carried.past and needed.spacing_ns == carried.spacing_ns)
        return past and carried.other_eye >= needed.other_eye and carried.recent >= needed.recent


class Needs(Mapping[str, Any]):
    """How much of each layer a plan needs, by layer name.

    An amount is True, a number, or what the layer's file says. What is not needed is not there:
    `name in needs` says whether a layer is. Immutable and hashable. `Needs(peeled=2, cube=True) |
    Needs(peeled=1)` is enough for both.
    """

    __slots__ = ("_amounts", "others")

    def __init__(self, **amounts: Any) -> None:
        """Errors: UnknownNameError for a name that is no layer's."""
        self._amounts = {layers.get(name).name: amounts[name] for name in sorted(amounts) if amounts[name]}
        # The other eye's picture and the older frames that the client keeps.
        self.others: Others = self._amounts.get("others", Others())

    def __getitem__(self, name: str) -> Any:
        return self._amounts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._amounts)

    def __len__(self) -> int:
        return len(self._amounts)

    def __hash__(self) -> int:
        return hash(frozenset(self._amounts.items()))

    def __repr__(self) -> str:
        return f"Needs({', '.join(f'{name}={amount!r}' for name, amount in self.items())})"

    def __or__(self, other: Needs) -> Needs:
        both = {**self, **other}
        both |= {name: layers.get(name).merged(self[name], other[name]) for name in self if name in other}
        return Needs(**both)

    def serve(self, needed: Needs) -> bool:
        """Return whether frames drawn for these needs suit a plan that needs `needed`."""
        every = [layers.get(name) for name in {*self, *needed}]
        return all(
            layer.serves(self.get(layer.name, layer.nothing), needed.get(layer.name, layer.nothing)) for layer in every
        )


def frame_bytes(
    needs: Needs, sizes: EyeSizes, reads: Collection[str] | None = None, *, eyes: int = 2
) -> dict[str, int]:
    """Return the bytes of each needed layer of a frame, by readable name.

    reads: readable names; colour and inverse depth count only if they are among them, None for
    both.
    """
    found = {}
    for layer in sorted(layers, key=lambda one: not one.always):
        name = layer.readable()
        amount = (reads is None or name in reads) if layer.always else needs.get(layer.name)
        if amount and (count := layer.bytes(amount, sizes)):
            found[name] = count if layer.per_frame else eyes * count
    return found


def video_pixels(weights: Mapping[str, int]) -> int:
    """Return the pixels of video that a frame takes to decode, of all eyes.

    weights: as frame_bytes returns them. Layers that are no pictures count nothing.
    """
    known = {layer.readable(): layer.formats for layer in layers if layer.formats}
    return sum(
        weight * len(known[name]) // sum(PIXEL_BYTES[kind] for kind in known[name])
        for name, weight in weights.items()
        if name in known
    )
