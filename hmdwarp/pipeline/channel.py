"""Transport of frames from the server to the client: through the link and, if chosen, a codec."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import attrs

from ..frames import Frame
from ..link import SCALES, Link, LinkOptions, Pacer, TransitStats
from ..sources.feed.message import request_bytes
from .frame_coder import CodedFrame, Coder, Reads

# Called with a frame, whether it arrived, and when the sender hears of it.
Settled = Callable[["Frame", bool, int], None]


@attrs.frozen(eq=False)
class ChannelSetup:
    """What a channel is made for: the network, what is coded, and who gets the frames."""

    network: LinkOptions
    latency_ns: int
    # Refresh rate of the display.
    rate_hz: float
    # None for frames that arrive as drawn.
    coder: Coder | None
    # What the client reads of a frame; no other layer is coded or counted.
    reads: Reads
    # Called with each frame that the client used and no longer needs.
    offer: Callable[[Frame], None]
    # As of the link, with frames as they arrived.
    settled: Settled = lambda frame, arrived, heard_ns: None  # noqa: E731


class Channel:
    """Send each frame that the server draws; return the newest that has arrived, as it arrived.

    When an encoded frame arrives, its decoded layers are written over its own textures. The times
    of rendering, encoding and decoding delay a frame only where the network's options say so. A
    server that is still at work on a frame, or whose client is, draws none: the slowest stage sets
    the pace.

    recycle: called with each frame that the client never used.
    """

    def __init__(self, setup: ChannelSetup, recycle: Callable[[Frame], None]) -> None:
        network, coder, rate_hz = setup.network, setup.coder, setup.rate_hz
        self._coder, self._reads, self._beside = coder, setup.reads, Reads()
        self.latency_ns = setup.latency_ns
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
        self._refreshes = self._frames = self._skipped = self._unchanged = self._eyes = 0
        self._bytes = Counter[str]()
        # Summary of what stands before this link, given the refreshes per second.
        self.before: Callable[[float], dict[str, Any]] | None = None
        self.link: Link[CodedFrame] = network.link(
            setup.latency_ns,
            discard=lambda coded: setup.offer(coded.frame),
            wasted=lambda coded: recycle(coded.frame),
            receive=coder.receive if coder is not None else None,
            decoding=self._decoding,
            settled=lambda coded, arrived, heard_ns: setup.settled(coded.frame, arrived, heard_ns),
        )

    def retime(self, network: LinkOptions, latency_ns: int) -> None:
        """Set the latency of frames sent from now on; those in transit keep theirs.

        Errors: as LinkOptions.check.
        """
        self.link.delay_by(network.delays(latency_ns))
        self.latency_ns = latency_ns

    def read(self, reads: Reads) -> None:
        """Send what another plan reads from now on."""
        self._reads = reads

    def read_beside(self, reads: Reads) -> None:
        """Code this too from now on, without counting it: another plan reads it."""
        self._beside |= reads

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
            coded, sizes = CodedFrame(frame), self._uncoded_bytes(frame)
        else:
            wants_key = self.link.needs_key(now_ns)
            coded = self._coder.encode(frame, self._reads, self._beside, wants_key=wants_key)
            sizes = coded.layer_bytes()
        self._frames += 1
        self._bytes.update(sizes)
        render_ns, encode_ns = self._at_server(frame, now_ns)
        transit = self.link.send(coded, now_ns, sizes.total(), coded.is_key, render_ns, encode_ns)
        self._slowest_ns = max(render_ns, encode_ns, self._decode_ns, transit.transfer_ns)
        if self._overload is not None:
            self._overload.sent(now_ns, transit.queue_ns, self._slowest_ns)

    def _uncoded_bytes(self, frame: Frame) -> Counter[str]:
        """Return what a frame weighs that goes as it was drawn, by layer."""
        sizes = Counter[str]()
        for (_, name), layer, data in self._reads.contents(frame):
            sizes[name] += layer.sent_bytes(data)
        return sizes

    def _measure(self, frame: Frame) -> None:
        """Note the resolution of a frame; the first is a full one."""
        width, height = frame.eyes[0].size
        self._eyes = len(frame.eyes)
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

    def _decoding(self, coded: CodedFrame) -> int:
        """Return how long decoding delays a frame that was received."""
        if self._stages is None:
            return 0
        took = coded.frame.timings_ms
        width, height = coded.frame.eyes[0].size
        *_, self._decode_ns = self._stages.taken_ns(took, width * height / self._full_pixels)
        took["decode"] = self._decode_ns * 1e-6
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
        return {**self.link.tally.as_dict(), "skipped": self._skipped, "unchanged": self._unchanged}

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """Return the `link` of summary.json: frames, Mbit/s, time and loss of the codec.

        rate_hz: refreshes per second.
        """
        megabits = 8 * rate_hz / 1e6 / max(self._refreshes, 1)
        return {
            "frames": self.fates(),
            **({"stages_ms": attrs.asdict(self._stages)} if self._stages is not None else {}),
            "mbit_s": self._bytes.total() * megabits,
            "layers_mbit_s": {name: count * megabits for name, count in self._bytes.most_common()},
            "frame_bytes": self._bytes.total() / max(self._frames, 1),
            # What asks for a frame, or finds that nothing has changed, as the feed writes it.
            "up_mbit_s": (self._frames + self._unchanged) * request_bytes(self._eyes) * megabits,
            **self._about_resolution(),
            **(self._coder.summary() if self._coder is not None else {"codec": "none"}),
            **({"proxy": self.before(rate_hz)} if self.before is not None else {}),
        }

    def _about_resolution(self) -> dict[str, Any]:
        if self._overload is None:
            return {}
        scales = {f"{scale:g}": self._scales[scale] for scale in SCALES}
        return {"resolution": {"frames": scales, "changes": self._overload.changes}}

    def close(self) -> None:
        """Recycle every frame still held, and free the codecs; the statistics stay readable."""
        self.link.close()
        if self._coder is not None:
            # Not left to the channel: a cycle holds it until garbage is collected.
            self._coder.close()
