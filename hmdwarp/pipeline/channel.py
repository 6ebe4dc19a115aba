"""Transport of frames from the server to the client: through the link and, if chosen, a codec."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from .frame_coder import CodedFrame, Coder
from .layers_read import Reads

if TYPE_CHECKING:
    from ..frames import Frame
    from ..link import Link, LinkOptions, TransitStats


class Channel:
    """Send each frame that the server draws; return the newest that has arrived, as it arrived.

    When an encoded frame arrives, its decoded layers are written over its own textures. The time of
    encoding and decoding is reported, never simulated, so that a replay is the same twice.

    coder: None for frames that arrive as drawn. reads: what the client reads of a frame; no other
    layer is coded or counted. offer: called with each frame that the client used and no longer
    needs. recycle: called with each frame that it never used.
    """

    def __init__(
        self,
        network: LinkOptions,
        latency_ns: int,
        coder: Coder | None,
        reads: Reads,
        offer: Callable[[Frame], None],
        recycle: Callable[[Frame], None],
    ) -> None:
        self._coder, self._reads, self._beside = coder, reads, Reads()
        self.latency_ns = latency_ns
        self._frames, self._bytes = 0, Counter[str]()
        self.link: Link[CodedFrame] = network.link(
            latency_ns,
            discard=lambda coded: offer(coded.frame),
            wasted=lambda coded: recycle(coded.frame),
            receive=coder.receive if coder is not None else None,
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
        """Code this too from now on, without counting it: a plan beside the client's reads it."""
        self._beside |= reads

    def send(self, frame: Frame, now_ns: int) -> None:
        """Send a frame from the server."""
        if self._coder is None:
            coded, sizes = CodedFrame(frame), Counter[str]()
            for (_, name), layer, data in self._reads.contents(frame):
                sizes[name] += layer.sent_bytes(data)
        else:
            wants_key = self.link.needs_key(now_ns)
            coded = self._coder.encode(frame, self._reads, self._beside, wants_key=wants_key)
            sizes = coded.layer_bytes()
        self._frames += 1
        self._bytes.update(sizes)
        self.link.send(coded, now_ns, sizes.total(), coded.is_key)

    def newest(self, now_ns: int) -> Frame | None:
        """Return the newest frame that has arrived by now, or None before the first."""
        coded = self.link.newest(now_ns)
        return coded.frame if coded is not None else None

    @property
    def transit(self) -> TransitStats | None:
        """Transit statistics of the shown frame, or None before the first."""
        return self.link.transit

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """Return the `link` of summary.json: frames, Mbit/s, time and loss of the codec."""
        frames = max(self._frames, 1)
        megabits = 8 * rate_hz / 1e6 / frames
        return {
            "frames": self.link.tally.as_dict(),
            "mbit_s": self._bytes.total() * megabits,
            "layers_mbit_s": {name: count * megabits for name, count in self._bytes.most_common()},
            "frame_bytes": self._bytes.total() / frames,
            **(self._coder.summary() if self._coder is not None else {"codec": "none"}),
        }

    def close(self) -> None:
        """Recycle every frame still held; the statistics stay readable."""
        self.link.close()
