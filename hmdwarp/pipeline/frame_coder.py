"""Coding of frames: every layer that is read through a stream of its own, and back."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from statistics import median
from typing import TYPE_CHECKING, Any, Self

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.plan import Plan, needs_of
from ..colour import picture_from_linear
from ..frames import Frame, Needs
from ..frames.layers import BRIGHT_VIDEO, DEPTH, VECTORS, VIDEO, Layer, layers
from ..geometry import Fov
from ..gpu.textures import download, upload
from ..link.codec import (
    DEPTH_VIDEOS,
    EXACT,
    STEP,
    Coding,
    Decoder,
    DepthDecoder,
    DepthEncoder,
    DepthVideoDecoder,
    DepthVideoEncoder,
    Encoder,
    Packet,
    Undecodable,
    VectorDecoder,
    VectorEncoder,
    codecs,
    depth_step,
    pack,
    unpack,
)
from ..metrics import psnr

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


@attrs.frozen(eq=False)
class _Stream:
    """One texture or array of every frame, coded in the order of drawing."""

    # Given whether the packet must need none before it.
    encode: Callable[[Content, bool], Packet]
    # Errors: Undecodable.
    decode: Callable[[Packet], Content]

    @classmethod
    def of_each(cls, pack: Callable[[Content], bytes], unpack: Callable[[bytes], Content]) -> _Stream:
        """Return a stream whose packets refer to no other."""
        return cls(lambda content, key: Packet(0, True, pack(content)), lambda packet: unpack(packet.data))


@attrs.frozen(eq=False)
class CodedFrame:
    """A frame in transit."""

    frame: Frame
    # Empty where nothing is encoded.
    packets: Mapping[Key, Packet] = attrs.field(factory=dict)
    # The packets that the client's plan reads; others are for plans that are compared with it.
    counted: frozenset[Key] = frozenset()
    # What decoded content is written over.
    into: Mapping[Key, moderngl.Texture | Content] = attrs.field(factory=dict)
    # The pictures before encoding; kept only where the loss is measured.
    before: Mapping[Key, NDArray[np.uint8]] = attrs.field(factory=dict)

    @property
    def is_key(self) -> bool:
        """Whether it can be decoded without those before it."""
        return not self.packets or all(packet.key for packet in self.packets.values())

    def layer_bytes(self) -> Counter[str]:
        """Return the bytes of what is counted, by layer."""
        out = Counter[str]()
        for key in self.counted:
            out[key[1]] += self.packets[key].size_bytes
        return out


class Coder:
    """The streams of a run, one for each texture or array and each size of frame.

    Each is opened by its first frame.

    How a layer is coded says its declaration in frames.layers. A bit rate is shared by the videos
    of an eye, by their pixels; depth takes what its code needs beside it.

    age_s: how old a frame is when it is seen, which the steps of depth follow.
    """

    def __init__(self, coding: Coding, rate_hz: float, age_s: float) -> None:
        self._coding, self._rate_hz, self._age_s = coding, rate_hz, age_s
        # By the size of the frame.
        self._streams: dict[tuple[int, int], dict[Key, _Stream]] = {}
        self._last_size = (0, 0)
        self._encoded = 0
        self._encode_ms, self._decode_ms, self._lost_db = (deque[float](maxlen=_KEPT) for _ in range(3))

    @classmethod
    def of(cls, coding: Coding, rate_hz: float, age_ns: int) -> Self | None:
        """Return what codes frames that are seen at that age; None where they go as they are."""
        return None if codecs.get(coding.codec).is_none else cls(coding, rate_hz, age_ns * 1e-9)

    def encode(self, frame: Frame, reads: Reads, beside: Reads | None = None, *, wants_key: bool) -> CodedFrame:
        """Encode what is read of a frame; its time is entered in the frame's timings.

        beside: what is read for comparison; it is coded too, and takes no time and no bytes.
        """
        counted = frozenset(_parts(frame, reads))
        parts = _parts(frame, reads | beside if beside is not None else reads)
        drawn = {key: into if isinstance(into, np.ndarray) else download(into) for key, (into, _) in parts.items()}
        pixels = {key: drawn[key].size if coding in _VIDEOS else 0 for key, (_, coding) in parts.items()}
        size, step = frame.eyes[0].size, STEP
        streams = self._streams.setdefault(size, {})
        if self._coding.depth != EXACT:
            step = depth_step(pixels_per_tangent((eye.view.fov, eye.size) for eye in frame.eyes), self._age_s)
        for key in parts.keys() - streams.keys():
            of_eye = sum(count for other, count in pixels.items() if other[0] == key[0])
            streams[key] = self._stream(drawn[key], parts[key][1], pixels[key] / max(of_eye, 1), step)
        # A stream that was left for another size begins anew.
        wants_key, self._last_size = wants_key or size != self._last_size, size
        packets, took_ms = {}, 0.0
        for key, content in drawn.items():
            started = time.perf_counter_ns()
            packets[key] = streams[key].encode(content, wants_key)
            took_ms += (time.perf_counter_ns() - started) * 1e-6 if key in counted else 0
        frame.timings_ms["encode"] = took_ms
        self._encode_ms.append(took_ms)
        looked_at = counted if self._encoded % _LOOK_EVERY == 0 else ()
        before = {key: picture_from_linear(drawn[key]) for key in looked_at if pixels[key]}
        self._encoded += 1
        # Half a step, and as video for 98 % of pixels two.
        error = 2 * step if self._coding.depth in DEPTH_VIDEOS else step / 2
        frame = attrs.evolve(frame, eyes=tuple(attrs.evolve(eye, depth_error=error) for eye in frame.eyes))
        return CodedFrame(frame, packets, counted, {key: into for key, (into, _) in parts.items()}, before)

    def receive(self, coded: CodedFrame) -> bool:
        """Decode into the frame's own textures; return False if the frame cannot be decoded."""
        arrived: dict[Key, Content] = {}
        streams, took_ms = self._streams[coded.frame.eyes[0].size], 0.0
        for key, packet in coded.packets.items():
            started = time.perf_counter_ns()
            # Each stream gets its packet, whatever has become of the others.
            with suppress(Undecodable):
                arrived[key] = streams[key].decode(packet)
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
        size, asked = drawn.shape[1::-1], self._coding
        if coding == DEPTH and (how := DEPTH_VIDEOS.get(asked.depth)) is not None:
            video = DepthVideoEncoder(size, self._rate_hz, step, how)
            return _Stream(video.encode, DepthVideoDecoder(size, how).decode)
        if coding == DEPTH:
            return _Stream.of_each(DepthEncoder(size, step).encode, DepthDecoder(size).decode)
        if coding == VECTORS:
            channels = drawn.shape[2]
            return _Stream.of_each(VectorEncoder(size, channels).encode, VectorDecoder(size, channels).decode)
        if coding not in _VIDEOS:
            return _Stream.of_each(pack, unpack)
        rate = None if asked.bitrate_mbit is None else max(_LEAST_MBIT, share * asked.bitrate_mbit)
        beyond = coding == BRIGHT_VIDEO
        encoder = Encoder(asked.codec, size, self._rate_hz, crf=asked.crf, bitrate_mbit=rate, keeps_beyond_1=beyond)
        return _Stream(encoder.encode, Decoder(asked.codec, size).decode)


def _parts(frame: Frame, reads: Reads) -> dict[Key, tuple[moderngl.Texture | Content, str]]:
    """Return every texture and array that is read, with its coding."""
    is_light = "light" in frame.eyes[0]  # that an albedo will take from: what is beyond 1 is kept
    return {
        (eye, name, number): (into, BRIGHT_VIDEO if is_light and coding == VIDEO else coding)
        for (eye, name), layer, data in reads.contents(frame)
        for number, (into, coding) in enumerate(layer.coded(data))
    }


def pixels_per_tangent(pictures: Iterable[tuple[Fov, tuple[int, int]]]) -> float:
    """Return how densely pictures of a field of view and size are drawn: of both axes the most."""
    sides = ((size, fov.tangents) for fov, size in pictures)
    return float(max(max(w / (right - left), h / (up - down)) for (w, h), (left, right, down, up) in sides))
