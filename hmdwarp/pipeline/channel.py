"""Transport of frames from the server to the client: through the link and, if chosen, a codec."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable
from statistics import median
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import picture_from_linear
from ..frames.layers import PACKED
from ..gpu.textures import download, upload
from ..link import SCALES, Pacer
from ..link.codec import Coding, Decoder, Encoder, Packet, Undecodable, packed_bytes
from ..metrics import psnr_db

if TYPE_CHECKING:
    import moderngl

    from ..frames import Frame
    from ..link import Link, LinkOptions, TransitStats

# At most so many samples are kept: half an hour at 60 Hz.
KEPT = 1 << 17
# Coding loss is measured on every tenth frame, because it costs a comparison of two pictures.
LOOK_EVERY = 10


@attrs.frozen(eq=False)
class EncodedFrame:
    """A frame in transit."""

    frame: Frame
    # One for each eye; empty where nothing is encoded.
    packets: tuple[Packet, ...] = ()
    # The colours before encoding; kept only where the loss is measured.
    before: tuple[NDArray[np.uint8], ...] = ()


class Channel:
    """Send each frame that the server draws; return the newest that has arrived, as it arrived.

    When an encoded frame arrives, its decoded colour and inverse depth are written over its own
    textures; its other layers are counted as packed without loss. The times of rendering, encoding
    and decoding delay a frame only where the network's options say so. A server that is still at
    work on a frame, or whose client is, draws none: the slowest stage sets the pace.

    weight_bytes: size of a frame where nothing is encoded. offer: called with each frame that the
    client used and no longer needs. recycle: called with each frame that it never used. rate_hz: of
    the display.
    """

    def __init__(
        self,
        network: LinkOptions,
        latency_ns: int,
        coder: Coder | None,
        weight_bytes: int,
        offer: Callable[[Frame], None],
        recycle: Callable[[Frame], None],
        rate_hz: float,
    ) -> None:
        self._coder, self._weight = coder, weight_bytes
        self.latency_ns = latency_ns
        self._pacer = Pacer(network.server_rate_hz, rate_hz)
        self._stages = network.response
        # When the server can draw again, and how long the last frame was decoded.
        self._free_ns: int | None = None
        self._decode_ns = 0
        self._overload = network.overload_at(rate_hz)
        # Of the last frame: its scale, its share of the pixels of a full one, its slowest stage.
        self._sent_scale, self._share, self._slowest_ns = 1.0, 1.0, 0
        self._full_pixels = 0
        self._scales: Counter[float] = Counter()
        self._refreshes = self._frames = self._bytes = self._skipped = self._unchanged = 0
        self.link: Link[EncodedFrame] = network.link(
            latency_ns,
            discard=lambda encoded: offer(encoded.frame),
            wasted=lambda encoded: recycle(encoded.frame),
            receive=coder.receive if coder is not None else None,
            decoding=self._decoding,
        )

    def retime(self, network: LinkOptions, latency_ns: int) -> None:
        """Set the latency of frames sent from now on; those in transit keep theirs.

        Errors: as LinkOptions.check.
        """
        self.link.delay_by(network.delays(latency_ns))
        self.latency_ns = latency_ns

    def due(self, now_ns: int) -> list[int]:
        """Return the instants at which the server draws, up to now; call it once a refresh."""
        self._refreshes += 1
        return self._pacer.due(now_ns)

    def is_busy(self, now_ns: int) -> bool:
        """Return whether the server cannot draw at this instant, which is counted."""
        if self._free_ns is None or now_ns >= self._free_ns:
            return False
        self._skipped += 1
        if self._overload is not None:
            self._overload.busy(now_ns, self._free_ns)
        return True

    @property
    def scale(self) -> float:
        """The share of the full width and height that the next frame should have."""
        return self._overload.scale if self._overload is not None else 1.0

    def has_to_send(self, now_ns: int) -> bool:
        """Return whether a frame is wanted even if nothing moved: one is missing, or too coarse."""
        return self.link.needs_key(now_ns) or self.scale > self._sent_scale

    def leave_out(self, now_ns: int) -> None:
        """Count a frame that was not drawn, because nothing would have changed."""
        self._unchanged += 1
        if self._overload is not None:
            self._overload.sent(now_ns, 0, self._slowest_ns)

    def send(self, frame: Frame, now_ns: int) -> None:
        """Send a frame from the server."""
        self._measure(frame)
        if self._coder is None:
            encoded, size, key = EncodedFrame(frame), round(self._weight * self._share), True
        else:
            encoded, size, key = self._coder.encode(frame, wants_key=self.link.needs_key(now_ns))
        self._frames += 1
        self._bytes += size
        render_ns, encode_ns = self._at_server(frame, now_ns)
        transit = self.link.send(encoded, now_ns, size, key, render_ns, encode_ns)
        self._slowest_ns = max(render_ns, encode_ns, self._decode_ns, transit.transfer_ns)
        if self._overload is not None:
            self._overload.sent(now_ns, transit.queue_ns, self._slowest_ns)

    def _measure(self, frame: Frame) -> None:
        """Note the resolution of a frame; the first is a full one."""
        width, height = frame.eyes[0].size
        self._full_pixels = self._full_pixels or width * height
        self._share = width * height / self._full_pixels
        self._sent_scale = self.scale
        self._scales[self._sent_scale] += 1

    def _at_server(self, frame: Frame, now_ns: int) -> tuple[int, int]:
        """Return how long rendering and encoding delay the frame, and keep the server busy."""
        if self._stages is None:
            return 0, 0
        took = frame.timings_ms
        took["render"] = frame.render_ms if self._stages.render is None else 0.0
        render_ns, encode_ns, decode_ns = self._stages.taken_ns(took, self._share)
        took |= {"render": render_ns * 1e-6, "encode": encode_ns * 1e-6}
        if self._stages.decode is not None:
            self._decode_ns = decode_ns
        self._free_ns = now_ns + max(render_ns, encode_ns, self._decode_ns)
        return render_ns, encode_ns

    def _decoding(self, encoded: EncodedFrame) -> int:
        """Return how long decoding delays a frame that was received."""
        if self._stages is None:
            return 0
        took = encoded.frame.timings_ms
        width, height = encoded.frame.eyes[0].size
        *_, self._decode_ns = self._stages.taken_ns(took, width * height / self._full_pixels)
        took["decode"] = self._decode_ns * 1e-6
        return self._decode_ns

    def newest(self, now_ns: int) -> Frame | None:
        """Return the newest frame that has arrived by now, or None before the first."""
        encoded = self.link.newest(now_ns)
        return encoded.frame if encoded is not None else None

    @property
    def transit(self) -> TransitStats | None:
        """Transit statistics of the shown frame, or None before the first."""
        return self.link.transit

    def fates(self) -> dict[str, int]:
        """Return what became of every frame, and of the instants at which none was drawn."""
        return {**self.link.tally.as_dict(), "skipped": self._skipped, "unchanged": self._unchanged}

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """Return the `link` of summary.json: frames, Mbit/s, time and loss of the codec.

        rate_hz: refreshes per second.
        """
        return {
            "frames": self.fates(),
            **({"stages_ms": attrs.asdict(self._stages)} if self._stages is not None else {}),
            "mbit_s": self._bytes / max(1, self._refreshes) * 8 * rate_hz / 1e6,
            "frame_bytes": self._bytes / max(1, self._frames),
            **self._about_resolution(),
            **(self._coder.summary() if self._coder is not None else {"codec": "none"}),
        }

    def _about_resolution(self) -> dict[str, Any]:
        if self._overload is None:
            return {}
        scales = {f"{scale:g}": self._scales[scale] for scale in SCALES}
        return {"resolution": {"frames": scales, "changes": self._overload.changes}}

    def close(self) -> None:
        """Recycle every frame still held; the statistics stay readable."""
        self.link.close()


class Coder:
    """Codec streams of both eyes.

    size: (w, h) of a rendered picture. sends_depth: whether inverse depth counts as sent; some
    warps do not need it.
    """

    def __init__(self, coding: Coding, size: tuple[int, int], rate_hz: float, *, sends_depth: bool = True) -> None:
        self._codec, self._sends_depth = coding.codec, sends_depth
        self._coding, self._rate_hz = coding, rate_hz
        # The streams of the full size are opened at once, others by their first frame.
        self._streams = {size: self._opened(size)}
        self._last_size = size
        self._encoded = 0
        self._encode_ms, self._decode_ms, self._lost_db = (deque[float](maxlen=KEPT) for _ in range(3))

    def _opened(self, size: tuple[int, int]) -> tuple[list[Encoder], list[Decoder]]:
        coding = self._coding
        encoders = [
            Encoder(coding.codec, size, self._rate_hz, crf=coding.crf, bitrate_mbit=coding.bitrate_mbit)
            for _ in range(2)
        ]
        return encoders, [Decoder(coding.codec, size) for _ in range(2)]

    def encode(self, frame: Frame, *, wants_key: bool) -> tuple[EncodedFrame, int, bool]:
        """Return (frame, bytes, whether it can be decoded without those before it).

        A frame of another size than the one before is always one that can.
        """
        size = frame.eyes[0].size
        if size not in self._streams:
            self._streams[size] = self._opened(size)
        encoders, _ = self._streams[size]
        if wants_key or size != self._last_size:
            for encoder in encoders:
                encoder.request_key()
        self._last_size = size
        pictures = [(picture_from_linear(download(eye.colour)), download(eye.inverse_depth)) for eye in frame.eyes]
        started = time.perf_counter_ns()
        packets = tuple(encoder.encode(*picture) for encoder, picture in zip(encoders, pictures, strict=True))
        frame.timings_ms["encode"] = _milliseconds_since(started)
        measured = self._encoded % LOOK_EVERY == 0
        self._encoded += 1
        self._encode_ms.append(frame.timings_ms["encode"])
        count = sum(len(packet.colour) + self._sends_depth * len(packet.depth) for packet in packets)
        count += sum(layer.coded_bytes(data, _packed) for layer, data in frame.contents() if layer.coding == PACKED)
        before = tuple(colour for colour, _ in pictures) if measured else ()
        return EncodedFrame(frame, packets, before), count, all(packet.key for packet in packets)

    def receive(self, encoded: EncodedFrame) -> bool:
        """Decode into the frame's own textures; return False if the frame cannot be decoded."""
        started = time.perf_counter_ns()
        pictures, failed = [], False
        _, decoders = self._streams[encoded.frame.eyes[0].size]
        for decoder, packet in zip(decoders, encoded.packets, strict=True):
            try:
                pictures.append(decoder.decode(packet))
            except Undecodable:
                failed = True  # report it to the other eye's stream too
        if failed:
            return False
        encoded.frame.timings_ms["decode"] = _milliseconds_since(started)
        self._decode_ms.append(encoded.frame.timings_ms["decode"])
        for eye, picture in zip(encoded.frame.eyes, pictures, strict=True):
            upload(eye.colour, picture.rgba())
            upload(eye.inverse_depth, picture.inverse_depth)
        for before, picture in zip(encoded.before, pictures, strict=False):
            self._lost_db.append(psnr_db(picture.colour, before))
        return True

    def summary(self) -> dict[str, Any]:
        """Return the codec's part of summary.json, or None where nothing was coded."""
        figures = {"encode_ms": self._encode_ms, "decode_ms": self._decode_ms, "coded_psnr_db": self._lost_db}
        return {"codec": self._codec, **{name: median(values) if values else None for name, values in figures.items()}}


def _packed(content: moderngl.Texture | NDArray[Any]) -> int:
    return packed_bytes(content if isinstance(content, np.ndarray) else download(content))


def _milliseconds_since(started_ns: int) -> float:
    return (time.perf_counter_ns() - started_ns) * 1e-6
