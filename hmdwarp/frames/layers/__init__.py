"""The layers that a frame can carry: tables, and classes where one is no texture, by family."""

from __future__ import annotations

import enum
import heapq
import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any, ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import Registry
from ...geometry import Fov

if TYPE_CHECKING:
    import moderngl


Size = tuple[int, int]

# Bytes of a pixel, by OpenGL's name of the texture format.
PIXEL_BYTES = {"rgba16f": 8, "r32f": 4, "r16ui": 2}
BYTES = "bytes"  # what is sent of a layer that is no texture
MOST_BUDGET = 1 << 24  # bytes of a frame that may be asked for, of what comes little by little
# Settings of what is needed, a row for each variant.
Rows = tuple[tuple[float, ...], ...]

# How a texture is coded on the link: by the video codec, with light beyond 1 clipped or kept, by
# the codes of inverse depth or of vectors, which bound the error of each pixel, or packed without
# loss. What is lossy keeps coverage and holes exact.
VIDEO, BRIGHT_VIDEO, DEPTH, VECTORS, PACKED = "video", "video beyond 1", "inverse depth", "vectors", "packed"
# How one of each format is coded where its layer does not say.
USUAL_CODINGS = {"rgba16f": VIDEO, "r32f": DEPTH, "r16ui": PACKED}

# Whose size a layer has: the rendered picture's, the shown one's, or its own.
RENDERED, SHOWN, OWN = "rendered", "shown", "own"


@attrs.frozen
class EyeSizes:
    """What the size of every layer follows from; all sizes are (w, h) in pixels of one eye."""

    rendered: Size  # the rendered picture, with its guard band
    shown: Size  # the shown picture
    # The shown fields of view, one for each eye; the size of some layers follows from them.
    fovs: tuple[Fov, ...] = ()


@attrs.frozen(eq=False)
class Surface:
    """Another surface of the same view and size; holes as in EyeImage."""

    colour: moderngl.Texture  # rgba16f, linear light with coverage in alpha
    inverse_depth: moderngl.Texture  # r32f in 1/m, -1 in holes

    def textures(self) -> tuple[moderngl.Texture, moderngl.Texture]:
        """Return both textures."""
        return self.colour, self.inverse_depth


def readable(name: str) -> str:
    """Return the name by which passes read a layer."""
    return f"rendered.{name}"


class Layer:
    """One kind of content of a frame; a file of its own with a subclass is its declaration.

    A layer is usually one texture for each eye; then `name`, `summary`, `formats` and `drawn_by`
    are enough, and `codings` where a texture holds neither light (rgba16f) nor inverse depth
    (r32f). A layer that is no picture (points, an atlas, photons) leaves `formats` empty and
    overrides `bytes`, `textures`, `sent` and, where its data must be freed, `release`. Every layer
    may come from another process: one of more than a texture overrides `made` too, and one of more
    than textures `numbers` and `misfit`.
    """

    name: ClassVar[str]  # the key in Needs and in EyeImage; passes read it as "rendered.<name>"
    summary: ClassVar[str]  # one line for listings
    # The texture formats of one unit of the layer, keys of PIXEL_BYTES.
    formats: ClassVar[tuple[str, ...]] = ()
    size_class: ClassVar[str] = RENDERED  # RENDERED, SHOWN, or OWN where the layer overrides `size`
    # The server's part that draws it, "" for what the server draws anyway or not at all.
    drawn_by: ClassVar[str] = ""
    # How each of `formats` is coded; () for the usual way, see USUAL_CODINGS.
    codings: ClassVar[tuple[str, ...]] = ()
    # Whether both eyes carry the same data, which is drawn, sent, counted and released once for
    # each frame.
    per_frame: ClassVar[bool] = False
    always: ClassVar[bool] = False  # whether every frame has it, needed or not
    apart: ClassVar[bool] = False  # whether the picture lacks what the layer shows
    laid_over: ClassVar[bool] = False  # whether the client lays it over whatever else it shows
    # Whether the client makes it of the frames that it has: no server sends it.
    of_client: ClassVar[bool] = False
    # Whether what a frame has of it depends on the frames before: then none can be left out.
    builds_on_frames: ClassVar[bool] = False
    # Whether it is made from the picture: that must be the one which its plan alone would get.
    made_from_picture: ClassVar[bool] = False
    lights: ClassVar[bool] = False  # whether it only says how the picture is lit: no pass reads it
    # Whether the client draws the scene by it, in place of a picture of it.
    draws_scene: ClassVar[bool] = False
    # The amount of plans that need none of it, and one that needs as much as there is, or some.
    nothing: ClassVar[Any] = 0
    something: ClassVar[Any] = True

    @classmethod
    def readable(cls) -> str:
        """Return the name by which passes read it."""
        return readable(cls.name)

    @classmethod
    def size(cls, sizes: EyeSizes) -> Size:
        """Return its (w, h) in pixels."""
        return sizes.shown if cls.size_class == SHOWN else sizes.rendered

    @classmethod
    def bytes(cls, amount: Any, sizes: EyeSizes) -> int:
        """Return the uncompressed bytes of `amount` of it, for one eye or (per_frame) all."""
        width, height = cls.size(sizes)
        return sum(PIXEL_BYTES[kind] for kind in cls.pictures(amount)) * width * height

    @classmethod
    def kept_bytes(cls, amount: Any) -> int:
        """Return the bytes that a server keeps for `amount` of it from frame to frame."""
        return 0

    @classmethod
    def pictures(cls, amount: Any) -> tuple[str, ...]:
        """Return the format of each texture or array of `amount` of it, in the order of `sent`.

        Of a number or a frozenset there are as many units, of any other amount one.
        """
        count = len(amount) if isinstance(amount, frozenset) else amount if isinstance(amount, int) else 1
        return count * cls.formats

    @classmethod
    def stated(cls, amount: Any) -> int | Rows:
        """Return an amount as messages state it: a number, or rows of settings."""
        if isinstance(amount, frozenset):
            return tuple(attrs.astuple(each) for each in sorted(amount))
        if attrs.has(type(amount)):
            return (attrs.astuple(amount),)
        if isinstance(amount, float):
            return ((amount,),)
        return amount.value if isinstance(amount, enum.Flag) else int(amount)

    @classmethod
    def amount_of(cls, stated: int | Rows) -> Any:
        """Return the amount that is stated so. Errors: ValueError for one that cannot be."""
        like, found = cls.something, None
        several = isinstance(like, frozenset)
        kind = type(next(iter(like)) if several else like)
        if isinstance(stated, int):
            found = None if several or attrs.has(kind) else kind(stated)
        elif attrs.has(kind):
            each, fields = [], attrs.fields(kind)
            for row in stated:
                if len(row) != len(fields):
                    raise ValueError(f"{len(row)} settings: expected {len(fields)}")
                each.append(kind(*(type(field.default)(value) for field, value in zip(fields, row, strict=True))))
            found = frozenset(each) if several else each[0] if len(each) == 1 else None
        elif kind is float:
            ((found,),) = stated
        if found is None or cls.stated(found) != stated:
            raise ValueError(f"{stated} is no amount of it")
        return found

    @classmethod
    def numbers(cls, data: Any) -> NDArray[Any] | None:
        """Return what its data hold besides textures, as rows of float64; None for nothing."""
        return None

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: NDArray[Any] | None) -> str:
        """Return why pictures of the right formats and numbers are not its data, "" if they are."""
        return "" if numbers is None else "there are numbers beside its pictures: expected none"

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: Any, drawn_ns: int) -> Any:
        """Return the data of what was sent, in the order of `sent`, and numbers that fit.

        drawn_ns: when it was drawn.
        """
        if isinstance(amount, frozenset):
            return dict(zip(sorted(amount), sent, strict=True))
        return sent[0] if sent else amount

    @classmethod
    def merged(cls, amount: Any, other: Any) -> Any:
        """Return an amount that is enough for both."""
        return amount | other if isinstance(amount, frozenset | enum.Flag) else max(amount, other)

    @classmethod
    def serves(cls, carried: Any, needed: Any) -> bool:
        """Return whether frames that carry `carried` suit passes that need `needed`.

        Of a frozenset more does not disturb.
        """
        return bool(needed <= carried if isinstance(needed, frozenset) else carried == needed)

    @classmethod
    def only(cls, data: Any, amount: Any) -> Any:
        """Return the part of the data that a plan which needs `amount` would get alone."""
        if isinstance(amount, frozenset):
            return data if data.keys() == amount else {each: data[each] for each in sorted(amount)}
        return data[:amount] if isinstance(data, tuple) else data

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        """Return every texture of its data, none of True; the server takes its own back."""
        if isinstance(data, Mapping | tuple):
            each = data.values() if isinstance(data, Mapping) else data
            return [texture for one in each for texture in cls.textures(one)]
        return data.textures() if hasattr(data, "textures") else () if data is True else (data,)

    @classmethod
    def coded_as(cls) -> tuple[str, ...]:
        """Return the coding of each of `formats`; what is no picture is packed."""
        return cls.codings or tuple(USUAL_CODINGS[kind] for kind in cls.formats) or (PACKED,)

    @classmethod
    def sent(cls, data: Any) -> Iterable[moderngl.Texture | NDArray[Any]]:
        """Return what passes read of its data: textures, in the order of `formats`, or arrays.

        The link writes what it has decoded over them, so arrays are writable.
        """
        return cls.textures(data)

    @classmethod
    def coded(cls, data: Any) -> Iterator[tuple[moderngl.Texture | NDArray[Any], str]]:
        """Yield what is sent, each with its coding."""
        return zip(cls.sent(data), cycle(cls.coded_as()), strict=False)

    @classmethod
    def sent_bytes(cls, data: Any) -> int:
        """Return its bytes on a link without a codec; no more than `bytes`."""
        return sum(
            one.nbytes if hasattr(one, "nbytes") else one.width * one.height * one.components * int(one.dtype[1:])
            for one in cls.sent(data)
        )

    @classmethod
    def release(cls, data: Any) -> None:
        """Free what belongs to no pool of the server's; called once, when the frame is recycled."""


def between(least: float, most: float) -> Any:
    """Return an attrs validator of a number that other processes may state."""

    def check(_: object, field: attrs.Attribute[Any], value: float) -> None:
        if not least <= value <= most:
            raise ValueError(f"{field.name} is {value:g}: expected {least:g} to {most:g}")

    return check


# What passes read of an eye's own picture.
PICTURE = (readable("colour"), readable("inverse_depth"))


def _of_table(name: str, table: dict[str, Any]) -> type[Layer]:
    facts = {key: tuple(value) if isinstance(value, list) else value for key, value in table.items()}
    return type(name, (Layer,), {**facts, "name": name})


_MODULES = {
    **dict.fromkeys(("cube", "foveated", "foveated_depth", "ids", "peeled"), "pictures"),
    **dict.fromkeys(("reflection", "transparent", "views", "wide"), "pictures"),
    **dict.fromkeys(("difference", "scene_update"), "scene_parts"),
}
layers: Registry[type[Layer]] = Registry("layer", __name__, of_table=_of_table, modules=_MODULES)


def readable_names() -> tuple[str, ...]:
    """Return what passes may read of a frame, one name for each layer; imports no layer."""
    return tuple(readable(name) for name in layers.names())


# Data that cross the link little by little are bytes, each by its number. They cross in fragments,
# so that any of them fits a budget, and a lost fragment is sent again by itself.

# As much as fits an Ethernet frame with its headers.
FRAGMENT_BYTES = 1400
# Number of the thing, of the fragment, how many fragments the thing has, bytes of this one.
_HEAD = struct.Struct("<IIIH")

Fragment = tuple[int, int]  # the thing, and which of its fragments


@attrs.frozen(eq=False)
class Update:
    """What one frame brings of what crosses little by little."""

    content: NDArray[np.uint8]  # its pieces; the link writes what it has decoded over it
    # What the sender needs to know again when it hears of the frame.
    pieces: tuple[Any, ...] = ()
    sent_ns: int = 0


class Delivered(Layer):
    """No picture but an Update of what the client keeps, for each thing that is wanted.

    The amount is a frozenset of those: hashable and ordered, with a `budget`, the most bytes of
    each frame. A client.Store with this layer's name receives the updates.
    """

    per_frame = True
    builds_on_frames = True
    nothing = frozenset()

    @classmethod
    def bytes(cls, amount: Any, sizes: EyeSizes) -> int:
        return sum(each.budget for each in amount)

    @classmethod
    def pictures(cls, amount: Any) -> tuple[str, ...]:
        return (BYTES,) * len(amount)

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: Any, drawn_ns: int) -> Any:
        return super().made([*map(Update, sent)], numbers, amount, drawn_ns)

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()

    @classmethod
    def sent(cls, data: Mapping[Any, Update]) -> Iterable[NDArray[Any]]:
        return [update.content for update in data.values()]


class Book:
    """What the sender of updates knows of them.

    What is on its way waits for the news, however long it takes; see Link.settled for what the news
    assumes.
    """

    def __init__(self) -> None:
        # When it is heard, a number that keeps equal instants in order, the update, its fate.
        self._news: list[tuple[int, int, Update, bool]] = []
        self._heard = 0
        # From sending to hearing of the arrival, of the last update that is known to have arrived;
        # None before the first.
        self.round_trip_ns: int | None = None

    def heard(self, update: Update, arrived: bool, heard_ns: int) -> None:
        """Take note of an update's fate, of which the sender hears at that instant."""
        heapq.heappush(self._news, (heard_ns, self._heard, update, arrived))
        self._heard += 1

    def settle(self, now_ns: int) -> None:
        """Act on the news heard by now."""
        while self._news and self._news[0][0] <= now_ns:
            heard_ns, _, update, arrived = heapq.heappop(self._news)
            if arrived:
                self.round_trip_ns = heard_ns - update.sent_ns
            for piece in update.pieces:
                self._settle(piece, arrived=arrived)

    def _settle(self, piece: Any, *, arrived: bool) -> None:
        """Enter the fate of a piece."""
        raise NotImplementedError


class Outbox(Book):
    """The sender's side of fragments: each thing until it has arrived.

    A fragment that was lost is sent again once the sender hears of the loss.
    """

    def __init__(self, things: Sequence[bytes]) -> None:
        super().__init__()
        self._things = tuple(things)
        self._waiting = {number: set(range(_fragments(thing))) for number, thing in enumerate(things)}

    @property
    def waiting(self) -> frozenset[int]:
        """The things of which something is to be sent."""
        return frozenset(self._waiting)

    def update(self, order: Iterable[int], budget: int, now_ns: int) -> Update:
        """Return the next fragments, of the first things in `order` that wait.

        order: a thing may occur more than once. budget: bytes; one fragment is sent however small
        it is.
        """
        out, sent = bytearray(), list[Fragment]()
        waiting = (
            (number, index) for number in dict.fromkeys(order) for index in sorted(self._waiting.get(number, ()))
        )
        for number, index in waiting:
            thing = self._things[number]
            data = thing[FRAGMENT_BYTES * index : FRAGMENT_BYTES * (index + 1)]
            if sent and len(out) + _HEAD.size + len(data) > budget:
                break
            out += _HEAD.pack(number, index, _fragments(thing), len(data)) + data
            sent.append((number, index))
        for number, index in sent:
            self._waiting[number].discard(index)
            if not self._waiting[number]:
                del self._waiting[number]
        return Update(np.frombuffer(bytes(out), np.uint8).copy(), tuple(sent), now_ns)

    def heard(self, update: Update, arrived: bool, heard_ns: int) -> None:
        if update.pieces:
            super().heard(update, arrived, heard_ns)

    def _settle(self, piece: Fragment, *, arrived: bool) -> None:
        if not arrived:
            self._waiting.setdefault(piece[0], set()).add(piece[1])


class Inbox:
    """The receiver's side: things as they become whole, in any order of arrival."""

    def __init__(self) -> None:
        self._begun: dict[int, dict[int, bytes]] = {}
        self._whole: set[int] = set()
        self.bytes = 0

    @property
    def whole(self) -> int:
        """How many things are whole."""
        return len(self._whole)

    def take(self, content: NDArray[np.uint8]) -> Iterator[tuple[int, bytes]]:
        """Take an update's content; yield the number and bytes of each thing that is now whole.

        Errors: struct.error and ValueError for bytes that are no fragments.
        """
        data, at = content.tobytes(), 0
        self.bytes += len(data)
        while at < len(data):
            number, index, count, length = _HEAD.unpack_from(data, at)
            at += _HEAD.size + length
            if at > len(data) or index >= count:
                raise ValueError("a fragment that does not fit")
            if number in self._whole:
                continue
            begun = self._begun.setdefault(number, {})
            begun[index] = data[at - length : at]
            if len(begun) == count:
                self._whole.add(number)
                del self._begun[number]
                yield number, b"".join(begun[index] for index in range(count))


def _fragments(thing: bytes) -> int:
    return max(1, -(-len(thing) // FRAGMENT_BYTES))
