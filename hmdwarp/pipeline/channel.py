"""A frame's way from the server to the client: through the link, and on the way through a codec where one is asked for."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from statistics import median
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import picture_from_linear
from ..gpu.textures import download, upload
from ..link.codec import Coding, Decoder, Encoder, Packet, Undecodable, packed_bytes
from ..metrics.image import psnr_db

if TYPE_CHECKING:
    import moderngl

    from ..frames.frame import EyeImage, Frame
    from ..link import Link, LinkOptions, TransitStats

KEPT = 1 << 17  # figures of so many frames: half an hour at 60 Hz, and no more in a run of hours
LOOK_EVERY = 10  # what coding loses is looked at in every tenth frame: that costs a comparison of two pictures


@attrs.frozen(eq=False)
class EncodedFrame:
    """A frame on its way; packets: one for each eye, none where nothing is encoded. before: what the colours were, to be looked at."""

    frame: Frame
    packets: tuple[Packet, ...] = ()
    before: tuple[NDArray[np.uint8], ...] = ()


class Channel:
    """Takes each frame the server draws; hands out the newest that has arrived, as it has arrived.

    A frame that is encoded gets its decoded colour and inverse depth written over its own textures when it arrives; its other layers are
    counted as packed without loss. offer: gets each frame the client had in hand and needs no more; recycle: those it never had.
    weight_bytes: of a frame, where nothing is encoded. How long encoding and decoding take is reported, never simulated: a replay stays
    the same twice.
    """

    def __init__(
        self,
        network: LinkOptions,
        latency_ns: int,
        coder: Coder | None,
        weight_bytes: int,
        offer: Callable[[Frame], None],
        recycle: Callable[[Frame], None],
    ) -> None:
        self._coder, self._weight = coder, weight_bytes
        self.latency_ns = latency_ns
        self._frames = self._bytes = 0
        self.link: Link[EncodedFrame] = network.link(
            latency_ns,
            discard=lambda encoded: offer(encoded.frame),
            wasted=lambda encoded: recycle(encoded.frame),
            receive=coder.receive if coder is not None else None,
        )

    def retime(self, network: LinkOptions, latency_ns: int) -> None:
        """Frames sent from now on take another latency; those under way arrive as they would have. Errors: as LinkOptions.check."""
        self.link.delay_by(network.delays(latency_ns))
        self.latency_ns = latency_ns

    def send(self, frame: Frame, now_ns: int) -> None:
        """A frame leaves the server."""
        if self._coder is None:
            encoded, size, key = EncodedFrame(frame), self._weight, True
        else:
            encoded, size, key = self._coder.encode(frame, wants_key=self.link.needs_key(now_ns))
        self._frames += 1
        self._bytes += size
        self.link.send(encoded, now_ns, size, key)

    def newest(self, now_ns: int) -> Frame | None:
        """The newest frame that has arrived by now, None before the first."""
        encoded = self.link.newest(now_ns)
        return encoded.frame if encoded is not None else None

    @property
    def transit(self) -> TransitStats | None:
        """How the frame that is shown came through."""
        return self.link.transit

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """The `link` of summary.json: what became of the frames, Mbit/s of both eyes, and what the codec took and lost."""
        mean_bytes = self._bytes / self._frames if self._frames else 0.0
        return {
            "frames": self.link.tally.as_dict(),
            "mbit_s": mean_bytes * 8 * rate_hz / 1e6,
            "frame_bytes": mean_bytes,
            **(self._coder.summary() if self._coder is not None else {"codec": "none"}),
        }

    def close(self) -> None:
        """Give every frame back that is still held; the tally stays."""
        self.link.close()


class Coder:
    """Both eyes' streams. size: (w, h) of a late picture. sends_depth: whether inverse depth counts as sent; some warps need none."""

    def __init__(self, coding: Coding, size: tuple[int, int], rate_hz: float, *, sends_depth: bool = True) -> None:
        self._codec, self._sends_depth = coding.codec, sends_depth
        told = {"crf": coding.crf, "bitrate_mbit": coding.bitrate_mbit}
        self._encoders = [Encoder(coding.codec, size, rate_hz, **told) for _ in range(2)]
        self._decoders = [Decoder(coding.codec, size) for _ in range(2)]
        self._encoded = 0
        self._encode_ms, self._decode_ms, self._lost_db = (deque[float](maxlen=KEPT) for _ in range(3))

    def encode(self, frame: Frame, *, wants_key: bool) -> tuple[EncodedFrame, int, bool]:
        """(parcel, bytes, whether it can be decoded without those before it)."""
        if wants_key:
            for encoder in self._encoders:
                encoder.request_key()
        pictures = [(picture_from_linear(download(eye.colour)), download(eye.inverse_depth)) for eye in frame.eyes]
        started = time.perf_counter_ns()
        packets = tuple(encoder.encode(*picture) for encoder, picture in zip(self._encoders, pictures, strict=True))
        frame.took_ms["encode"] = _milliseconds_since(started)
        looked_at = self._encoded % LOOK_EVERY == 0
        self._encoded += 1
        self._encode_ms.append(frame.took_ms["encode"])
        size = sum(len(packet.colour) + self._sends_depth * len(packet.depth) for packet in packets)
        size += sum(packed_bytes(download(layer)) for layer in _other_layers(frame.eyes))
        before = tuple(colour for colour, _ in pictures) if looked_at else ()
        return EncodedFrame(frame, packets, before), size, all(packet.key for packet in packets)

    def receive(self, encoded: EncodedFrame) -> bool:
        """Decode what has arrived into the frame's own textures; False if it builds on what never came."""
        started = time.perf_counter_ns()
        pictures, failed = [], False
        for decoder, packet in zip(self._decoders, encoded.packets, strict=True):
            try:
                pictures.append(decoder.decode(packet))
            except Undecodable:
                failed = True  # the other eye's stream must hear of this frame too
        if failed:
            return False
        encoded.frame.took_ms["decode"] = _milliseconds_since(started)
        self._decode_ms.append(encoded.frame.took_ms["decode"])
        for eye, picture in zip(encoded.frame.eyes, pictures, strict=True):
            upload(eye.colour, picture.rgba())
            upload(eye.inverse_depth, picture.inverse_depth)
        for before, picture in zip(encoded.before, pictures, strict=False):
            self._lost_db.append(psnr_db(picture.colour, before))
        return True

    def summary(self) -> dict[str, Any]:
        """Its part of summary.json; None where nothing was coded."""
        figures = {"encode_ms": self._encode_ms, "decode_ms": self._decode_ms, "coded_psnr_db": self._lost_db}
        return {"codec": self._codec, **{name: median(values) if values else None for name, values in figures.items()}}


def _other_layers(eyes: tuple[EyeImage, ...]) -> list[moderngl.Texture]:
    """All but colour and inverse depth of the pictures themselves."""
    return [
        texture
        for eye in eyes
        for texture in eye.textures()
        if texture is not eye.colour and texture is not eye.inverse_depth
    ]


def _milliseconds_since(started_ns: int) -> float:
    return (time.perf_counter_ns() - started_ns) * 1e-6
