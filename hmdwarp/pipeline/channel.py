"""Transport of frames from the server to the client: through the link and, if chosen, a codec.

And how much a new frame would differ, in pixels, from the last one that was sent.
"""

from __future__ import annotations

import itertools
import math
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from statistics import median
from typing import TYPE_CHECKING, Any, Self

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import picture_from_linear
from ..client import Plan, needs_of
from ..frames import EyeImage, Frame, Needs
from ..frames.layers import BRIGHT_VIDEO, DEPTH, VECTORS, VIDEO, Layer, layers
from ..geometry import Fov, View, WarpMap
from ..gpu import download, upload
from ..link import SUM, Link, LinkOptions, Pacer, TransitStats, codec
from ..link.codec import Coding, Packet, Undecodable
from ..metrics import psnr
from ..scenes import Scene
from ..sources.feed.message import request_bytes

if TYPE_CHECKING:
    import moderngl


# Number of the eye, and name of the layer.
Place = tuple[int, str]


@attrs.frozen
class Reads:
    """Layers by readable name, and how much of each."""

    names: frozenset[str] = frozenset()
    needs: Needs = Needs()

    @classmethod
    def of(cls, plans: Iterable[Plan]) -> Reads:
        """Return what any of the plans reads."""
        plans = tuple(plans)
        return cls(frozenset(name for plan in plans for name in plan.layers), needs_of(plans))

    @property
    def pictures(self) -> frozenset[str]:
        """What is read that the server draws for an eye, by readable name."""
        return self.names & {layer.readable() for layer in layers if not layer.per_frame}

    def __or__(self, other: Reads) -> Reads:
        return Reads(self.names | other.names, self.needs | other.needs)

    def contents(self, frame: Frame) -> list[tuple[Place, type[Layer], Any]]:
        """Return each layer that is read, with its data; what both eyes share comes once."""
        found = []
        for eye, image in frame.pictures():
            for layer, data in image.only(self.needs).contents():
                if layer.readable() in self.names and not (eye and layer.per_frame):
                    found.append(((eye, layer.name), layer, data))
        return found


# At most so many samples are kept: half an hour at 60 Hz.
_KEPT = 1 << 17
# Coding loss is measured on every tenth frame, because it costs a comparison of two pictures.
_LOOK_EVERY = 10
_VIDEOS = (VIDEO, BRIGHT_VIDEO)
_LEAST_MBIT = 0.01  # that a stream takes

# A layer of an eye, and which of its textures or arrays.
Key = tuple[int, str, int]
Content = NDArray[Any]


# One texture or array of every frame, coded in the order of drawing: encodes, given whether the
# packet must need none before it, and decodes. Errors: Undecodable.
_Stream = tuple[Callable[[Content, bool], Packet], Callable[[Packet], Content]]


@attrs.frozen(eq=False)
class CodedFrame:
    """A frame in transit."""

    frame: Frame
    packets: Mapping[Key, Packet] = {}  # empty where nothing is encoded
    # The packets that the client's plan reads; others are for plans that are compared with it.
    counted: frozenset[Key] = frozenset()
    # What decoded content is written over.
    into: Mapping[Key, moderngl.Texture | Content] = {}
    # The pictures before encoding; kept only where the loss is measured.
    before: Mapping[Key, NDArray[np.uint8]] = {}

    @property
    def is_key(self) -> bool:
        """Whether it can be decoded without those before it."""
        return not self.packets or all(packet.key for packet in self.packets.values())

    def layer_bytes(self) -> Counter[str]:
        """Return the bytes of what is counted, by layer."""
        sizes = Counter[str]()
        for key in self.counted:
            sizes[key[1]] += len(self.packets[key].data)
        return sizes


class Coder:
    """The streams of a run, one for each texture or array, opened by its first frame.

    How a layer is coded says its declaration in frames.layers. A bit rate is shared by the videos
    of an eye, by their pixels; depth takes what its code needs beside it.

    age_s: how old a frame is when it is seen, which the steps of depth follow.
    """

    def __init__(self, coding: Coding, rate_hz: float, age_s: float) -> None:
        self._coding, self._rate_hz, self._age_s = coding, rate_hz, age_s
        self._streams: dict[Key, _Stream] = {}
        self._encoded = itertools.count()
        self._encode_ms, self._decode_ms, self._lost_db = (deque[float](maxlen=_KEPT) for _ in range(3))

    @classmethod
    def of(cls, coding: Coding, rate_hz: float, age_ns: int) -> Self | None:
        """Return what codes frames that are seen at that age; None where they go as they are."""
        return None if codec.codecs.get(coding.codec).is_none else cls(coding, rate_hz, age_ns * 1e-9)

    def encode(self, frame: Frame, reads: Reads, beside: Reads | None = None, *, wants_key: bool) -> CodedFrame:
        """Encode what is read of a frame; its time is entered in the frame's timings.

        beside: what is read for comparison; it is coded too, and takes no time and no bytes.
        """
        counted = frozenset(_parts(frame, reads))
        parts = _parts(frame, reads | (beside or Reads()))
        drawn = {key: into if isinstance(into, np.ndarray) else download(into) for key, (into, _) in parts.items()}
        pixels = {key: drawn[key].size if coding in _VIDEOS else 0 for key, (_, coding) in parts.items()}
        streams, step = (
            self._streams,
            depth_step(self._coding, [(eye.view.fov, eye.size) for eye in frame.eyes], self._age_s),
        )
        for key in parts.keys() - streams.keys():
            of_eye = sum(count for other, count in pixels.items() if other[0] == key[0])
            streams[key] = self._stream(drawn[key], parts[key][1], pixels[key] / max(of_eye, 1), step)
        packets, took_ms = {}, 0.0
        for key, content in drawn.items():
            started = time.perf_counter_ns()
            packets[key] = streams[key][0](content, wants_key)
            took_ms += (time.perf_counter_ns() - started) * 1e-6 if key in counted else 0
        frame.timings_ms["encode"] = took_ms
        self._encode_ms.append(took_ms)
        looked_at = counted if next(self._encoded) % _LOOK_EVERY == 0 else ()
        before = {key: picture_from_linear(drawn[key]) for key in looked_at if pixels[key]}
        # Half a step, and as video for 98 % of pixels two.
        error = 2 * step if self._coding.depth in codec.DEPTH_VIDEOS else step / 2
        frame = attrs.evolve(frame, eyes=tuple(attrs.evolve(eye, depth_error=error) for eye in frame.eyes))
        return CodedFrame(frame, packets, counted, {key: into for key, (into, _) in parts.items()}, before)

    def receive(self, coded: CodedFrame) -> bool:
        """Decode into the frame's own textures; return False if the frame cannot be decoded."""
        arrived: dict[Key, Content] = {}
        took_ms = 0.0
        for key, packet in coded.packets.items():
            started = time.perf_counter_ns()
            # Each stream gets its packet, whatever has become of the others.
            with suppress(Undecodable):
                arrived[key] = self._streams[key][1](packet)
            took_ms += (time.perf_counter_ns() - started) * 1e-6 if key in coded.counted else 0
        if len(arrived) < len(coded.packets):
            return False
        coded.frame.timings_ms["decode"] = took_ms
        self._decode_ms.append(took_ms)
        for key, into in coded.into.items():
            if isinstance(into, np.ndarray):
                into[...] = arrived[key]
            else:
                upload(into, arrived[key])
        for key, before in coded.before.items():
            self._lost_db.append(psnr(picture_from_linear(arrived[key]), before))
        return True

    def close(self) -> None:
        """Free the codecs, several MB a stream; the figures stay readable."""
        self._streams.clear()

    def summary(self) -> dict[str, Any]:
        """Return the codec's part of summary.json; a figure is None where nothing was coded."""
        figures = {"encode_ms": self._encode_ms, "decode_ms": self._decode_ms, "coded_psnr_db": self._lost_db}
        told = {name: median(values) if values else None for name, values in figures.items()}
        return {"codec": self._coding.codec, **told}

    def _stream(self, drawn: Content, coding: str, share: float, step: float) -> _Stream:
        """Return a new stream. share: of its eye's bit rate."""
        size, asked, rate_hz = drawn.shape[1::-1], self._coding, self._rate_hz
        if coding == DEPTH and (how := codec.DEPTH_VIDEOS.get(asked.depth)) is not None:
            return codec.DepthVideoEncoder(size, rate_hz, step, how).encode, codec.DepthVideoDecoder(size, how).decode
        if coding in _VIDEOS:
            mbit = None if asked.bitrate_mbit is None else max(_LEAST_MBIT, share * asked.bitrate_mbit)
            quality: dict[str, Any] = {"crf": asked.crf, "bitrate_mbit": mbit, "keeps_beyond_1": coding == BRIGHT_VIDEO}
            return codec.Encoder(asked.codec, size, rate_hz, **quality).encode, codec.Decoder(asked.codec, size).decode
        # Packets of all else refer to no other.
        pack: Callable[[Content], bytes] = codec.pack
        unpack: Callable[[bytes], Content] = codec.unpack
        if coding == DEPTH:
            pack, unpack = codec.DepthEncoder(size, step).encode, codec.DepthDecoder(size).decode
        elif coding == VECTORS:
            channels = drawn.shape[2]
            pack, unpack = codec.VectorEncoder(size, channels).encode, codec.VectorDecoder(size, channels).decode
        return lambda content, key: Packet(0, True, pack(content)), lambda packet: unpack(packet.data)


def _parts(frame: Frame, reads: Reads) -> dict[Key, tuple[moderngl.Texture | Content, str]]:
    """Return every texture and array that is read, with its coding."""
    is_light = "light" in frame.eyes[0]  # that an albedo will take from: what is beyond 1 is kept
    return {
        (eye, name, number): (into, BRIGHT_VIDEO if is_light and coding == VIDEO else coding)
        for (eye, name), layer, data in reads.contents(frame)
        for number, (into, coding) in enumerate(layer.coded(data))
    }


def depth_step(coding: Coding, pictures: Iterable[tuple[Fov, tuple[int, int]]], age_s: float) -> float:
    """Return the step of coded depth; pictures: field of view and size, the densest counts."""
    if coding.depth == codec.EXACT:
        return codec.STEP
    sides = ((size, fov.tangents) for fov, size in pictures)
    densest = max(max(w / (right - left), h / (up - down)) for (w, h), (left, right, down, up) in sides)
    return codec.depth_step(float(densest), age_s)


# A frame is sent if something may have moved by more than this.
SEEN_PX = 0.5
# A row and a column of the picture where the head's motion is looked at, its sides among them.
_LINES = 17


class Changes:
    """Bound how far anything has moved on the screen since the last frame that was sent.

    The head's motion is that of the warp map, for points infinitely far and as near as the nearest
    in the frame. Whatever else changes the picture counts without bound: bodies and meshes that
    have moved, light of lamps, the light that a body stops, panels, another recorded frame.

    content: tells what a renderer without a scene shows at an instant from what it shows at others.
    """

    def __init__(self, scene: Scene, content: Callable[[int], object] = lambda time_ns: None) -> None:
        self._scene, self._content = scene, content
        self._stops_light = sorted({mesh.body for mesh in scene.meshes if mesh.light_uv is not None} - {0})
        shown = [mesh for mesh in scene.meshes if not mesh.material.head_locked]
        self._moving = sorted({mesh.body for mesh in shown} - {0})
        self._soft = [mesh.deformation for mesh in shown if mesh.deformation is not None]
        # Each eye with the largest inverse depth in its layers, and when that was drawn.
        self._sent: list[tuple[EyeImage, float]] = []
        self._drawn_ns = 0

    def sent(self, frame: Frame) -> None:
        """Compare with this frame from now on; waits until it has been drawn."""
        self._sent, self._drawn_ns = [], frame.drawn_ns
        for eye in frame.eyes:
            depths = [texture for texture in eye.textures() if (texture.components, texture.dtype) == (1, "f4")]
            nearest = max(0.0, *(float(np.nanmax(download(texture))) for texture in depths))
            self._sent.append((eye, nearest))

    def moved_px(self, views: Sequence[View], now_ns: int) -> float:
        """Return a bound for a frame drawn now for these views; infinite before the first.

        In pixels of the frame that was sent.
        """
        if len(views) != len(self._sent) or self.state_at(self._drawn_ns) != self.state_at(now_ns):
            return math.inf
        moved = 0.0
        for (eye, nearest), view in zip(self._sent, views, strict=True):
            by_head = WarpMap.between(eye.view, eye.size, View(view.pose, eye.view.fov), eye.size)
            pixels = np.stack(np.meshgrid(*(np.linspace(0.0, side, _LINES) for side in eye.size)), axis=-1)
            for depth in (0.0, nearest):
                ways = by_head.apply(pixels, np.full(pixels.shape[:2], depth))[0] - pixels
                moved = max(moved, float(np.nan_to_num(np.linalg.norm(ways, axis=-1), nan=math.inf).max()))
        return moved

    def state_at(self, time_ns: int) -> tuple[object, ...]:
        """Return what tells an instant of the scene from those that look otherwise."""
        scene = self._scene
        poses = [scene.bodies[number - 1].motion.state(time_ns).pose for number in self._moving]
        soft = [np.asarray(each.positions(time_ns)).tobytes() for each in self._soft]
        panels = [each.showing(time_ns) for each in scene.panels]
        lit_ns = scene.lit_ns(time_ns) if scene.lamps else 0  # else all light is baked
        lamps = [(*lamp.place(lit_ns), *lamp.fading(lit_ns), *lamp.light(lit_ns)) for lamp in scene.lamps]
        stopped = [scene.bodies[number - 1].lit_as(lit_ns) for number in self._stops_light if scene.lamps]
        return self._content(time_ns), poses, soft, panels, lamps, stopped


# The network's options, its latency in ns, the display's refresh rate, and what codes the frames;
# None for frames that arrive as drawn.
Way = tuple[LinkOptions, int, float, Coder | None]


class Channel:
    """Send each frame that the server draws; return the newest that has arrived, as it arrived.

    When an encoded frame arrives, its decoded layers are written over its own textures. The times
    of rendering, encoding and decoding delay a frame only where the network's options say so. A
    server that is still at work on a frame, or whose client is, draws none: the slowest stage sets
    the pace.

    reads: what the client reads of a frame; no other layer is coded or counted. offer, recycle:
    called with each frame that the client no longer needs, and that it never used. tell: called
    with a frame, whether it arrived, and when the sender hears of it. callbacks: of the Link, in
    place of those for frames that are coded here.
    """

    def __init__(
        self,
        recycle: Callable[[Frame], None],
        way: Way,
        reads: Reads,
        offer: Callable[[Frame], None],
        tell: Callable[[Frame, bool, int], None],
        **callbacks: Any,
    ) -> None:
        network, self.latency_ns, rate_hz, self._coder = way
        self._reads, self._beside = reads, Reads()
        self._pacer = Pacer(network.server_rate_hz, rate_hz)
        # Whether stages delay a frame; how long the last one was decoded; and when the server can
        # draw again.
        self._sums, self._decode_ns, self._free_ns = network.response == SUM, 0, -math.inf
        self._refreshes = self._frames = self._skipped = self._eyes = 0
        self.unchanged = 0  # frames that were not drawn, because nothing would have changed
        self._bytes = Counter[str]()
        self._weights: dict[object, Counter[str]] = {}  # of frames that have pictures alone
        # Summary of what stands before this link, given the refreshes per second.
        self.before: Callable[[float], dict[str, Any]] | None = None
        how: dict[str, Any] = {
            "discard": lambda coded: offer(coded.frame),
            "wasted": lambda coded: recycle(coded.frame),
            "receive": self._coder.receive if self._coder is not None else None,
            "decoding": self._decoding,
            "settled": lambda coded, arrived, heard_ns: tell(coded.frame, arrived, heard_ns),
        }
        self.link: Link[Any] = network.link(self.latency_ns, **how | callbacks)

    def retime(self, network: LinkOptions, latency_ns: int) -> None:
        """Set the latency of frames sent from now on; those in transit keep theirs.

        Errors: as LinkOptions.check.
        """
        self.link.delay_by(network.delays(latency_ns))
        self.latency_ns = latency_ns

    def read(self, reads: Reads) -> None:
        """Send what another plan reads from now on."""
        self._reads = reads
        self._weights.clear()

    def read_beside(self, reads: Reads) -> None:
        """Code this too from now on, without counting it: another plan reads it."""
        self._beside |= reads

    def due(self, now_ns: int) -> list[int]:
        """Return the instants at which the server draws, up to now; call it once a refresh."""
        self._refreshes += 1
        return self._pacer.due(now_ns)

    def is_busy(self, now_ns: int) -> bool:
        """Return whether the server cannot draw at this instant, which is counted."""
        is_busy = self._sums and now_ns < self._free_ns
        self._skipped += is_busy
        return is_busy

    def send(self, frame: Frame, now_ns: int) -> None:
        """Send a frame from the server."""
        self._eyes = len(frame.eyes)
        if self._coder is None:
            coded, sizes = CodedFrame(frame), self._uncoded_bytes(frame)
        else:
            wants_key = self.link.needs_key(now_ns)
            coded = self._coder.encode(frame, self._reads, self._beside, wants_key=wants_key)
            sizes = coded.layer_bytes()
        self._frames += 1
        self._bytes.update(sizes)
        render_ns = encode_ns = 0
        if self._sums:  # they delay the frame, and keep the server busy
            render_ns, encode_ns = round(frame.render_ms * 1e6), round(frame.timings_ms.get("encode", 0.0) * 1e6)
            self._free_ns = now_ns + max(render_ns, encode_ns, self._decode_ns)
        self.link.send(coded, now_ns, sizes.total(), coded.is_key, render_ns, encode_ns)

    def _uncoded_bytes(self, frame: Frame) -> Counter[str]:
        """Return what a frame weighs that goes as it was drawn, by layer."""
        first, last = frame.eyes[0], frame.eyes[-1]
        key = first.colour.size, last.colour.size, first.colour is last.colour
        # Pictures alone weigh the same each time.
        is_plain = not (first.carried or last.carried)
        if is_plain and key in self._weights:
            return self._weights[key]
        sizes = Counter[str]()
        for (_, name), layer, data in self._reads.contents(frame):
            sizes[name] += layer.sent_bytes(data)
        if is_plain:
            self._weights[key] = sizes
        return sizes

    def _decoding(self, coded: CodedFrame) -> int:
        """Return how long decoding delays a frame that was received."""
        self._decode_ns = round(coded.frame.timings_ms.get("decode", 0.0) * 1e6) if self._sums else 0
        return self._decode_ns

    def newest(self, now_ns: int) -> Frame | None:
        """Return the newest frame that has arrived by now, or None before the first."""
        coded = self.link.newest(now_ns)
        return coded.frame if coded is not None else None

    @property
    def transit(self) -> TransitStats | None:
        """Transit statistics of the shown frame, or None before the first."""
        return self.link.transit

    def fates(self) -> dict[str, int]:
        """Return what became of every frame, and of the instants at which none was drawn."""
        return {**self.link.tally.as_dict(), "skipped": self._skipped, "unchanged": self.unchanged}

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """Return the `link` of summary.json: frames, Mbit/s, time and loss of the codec.

        rate_hz: refreshes per second.
        """
        megabits = 8 * rate_hz / 1e6 / max(self._refreshes, 1)
        return {
            "frames": self.fates(),
            "mbit_s": self._bytes.total() * megabits,
            "layers_mbit_s": {name: count * megabits for name, count in self._bytes.most_common()},
            "frame_bytes": self._bytes.total() / max(self._frames, 1),
            # What asks for a frame, or finds that nothing has changed, as the feed writes it.
            "up_mbit_s": (self._frames + self.unchanged) * request_bytes(self._eyes) * megabits,
            **(self._coder.summary() if self._coder is not None else {"codec": "none"}),
            **({"proxy": self.before(rate_hz)} if self.before is not None else {}),
        }

    def close(self) -> None:
        """Recycle every frame still held, and free the codecs; the statistics stay readable."""
        self.link.close()
        if self._coder is not None:
            # Not left to the channel: a cycle holds it until garbage is collected.
            self._coder.close()
