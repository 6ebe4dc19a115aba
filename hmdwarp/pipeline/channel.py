"""Transport of frames from the server to the client: through the link and, if chosen, a codec.

And how much a new frame would differ, in pixels, from the last one that was sent.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..frames import EyeImage, Frame
from ..geometry import View, WarpMap
from ..gpu.textures import download
from ..link import SCALES, Link, LinkOptions, Pacer, TransitStats
from ..scenes import Mesh, Scene
from ..sources.feed.message import request_bytes
from .frame_coder import CodedFrame, Coder, Reads

# A frame is sent if something may have moved by more than this.
SEEN_PX = 0.5
# A row and a column of the picture where the head's motion is looked at, its sides among them.
_LINES = 17
# A body that comes closer to an eye than this counts as near without bound.
_NEAREST_M = 0.01

Points = NDArray[np.float64]


@attrs.frozen(eq=False)
class _Sent:
    # One for each eye, and the largest inverse depth in its layers.
    eyes: tuple[tuple[EyeImage, float], ...]
    drawn_ns: int


class Changes:
    """Bound how far anything has moved on the screen since the last frame that was sent.

    The head's motion is that of the warp map, for points infinitely far and as near as the nearest
    in the frame. To it comes the largest motion of a body or of a deforming mesh, wherever it is.
    Whatever else changes the picture counts without bound: light of lamps that have moved, the
    light that a body stops, another recorded frame.

    content: tells what a renderer without a scene shows at an instant from what it shows at others.
    """

    def __init__(self, scene: Scene, content: Callable[[int], object] = lambda time_ns: None) -> None:
        self._scene, self._content = scene, content
        self._stops_light = sorted({mesh.body for mesh in scene.meshes if mesh.light_uv is not None} - {0})
        moving = [mesh for mesh in scene.meshes if not mesh.material.head_locked]
        self._movers = [
            _corners(scene, number, moving) for number in dict.fromkeys(mesh.body for mesh in moving) if number
        ]
        self._movers += [_vertices(mesh, scene.origin_m) for mesh in moving if mesh.deformation is not None]
        self._sent: _Sent | None = None

    def sent(self, frame: Frame) -> None:
        """Compare with this frame from now on; waits until it has been drawn."""
        self._sent = _Sent(tuple((eye, _nearest(eye)) for eye in frame.eyes), frame.drawn_ns)

    def moved_px(self, views: Sequence[View], now_ns: int) -> float:
        """Return a bound for a frame drawn now for these views; infinite before the first.

        In pixels of the frame that was sent.
        """
        if self._sent is None or len(views) != len(self._sent.eyes):
            return math.inf
        then_ns = self._sent.drawn_ns
        seen = (self._content, self.light_at, lambda time_ns: [each.showing(time_ns) for each in self._scene.panels])
        if any(at(then_ns) != at(now_ns) for at in seen):
            return math.inf
        moved = 0.0
        for (eye, nearest), view in zip(self._sent.eyes, views, strict=True):
            places = (eye.view.pose.position_m, view.pose.position_m)
            angles = (_moved_rad(points(then_ns), points(now_ns), places) for points in self._movers)
            left, right, down, up = eye.view.fov.tangents
            per_tangent = max(eye.size[0] / (right - left), eye.size[1] / (up - down))
            # An angle covers most pixels in a corner of the picture, towards its middle.
            per_rad = float(per_tangent * (1 + max(left * left, right * right) + max(down * down, up * up)))
            moved = max(moved, _by_head(eye, view, nearest) + max(angles, default=0.0) * per_rad)
        return moved

    def light_at(self, time_ns: int) -> object:
        """Return what tells the light of an instant from that of others; None where it is baked."""
        if not self._scene.lamps:
            return None
        lit_ns = self._scene.lit_ns(time_ns)
        return (
            tuple((*lamp.place(lit_ns), *lamp.fading(lit_ns), *lamp.light(lit_ns)) for lamp in self._scene.lamps),
            tuple(self._scene.bodies[number - 1].lit_as(lit_ns) for number in self._stops_light),
        )


# What moves by itself: (n, 3) points in the world at an instant. No other of its points moves
# farther, or lies outside the box around them.
Mover = Callable[[int], Points]


def _corners(scene: Scene, number: int, meshes: Sequence[Mesh]) -> Mover:
    """Return those of a body's box: a rigid motion moves no point of it farther."""
    body = scene.bodies[number - 1]
    positions = np.concatenate([mesh.positions for mesh in meshes if mesh.body == number]).astype(np.float64)
    ends = zip(positions.min(axis=0), positions.max(axis=0), strict=True)
    corners = np.array([(*corner, 1.0) for corner in product(*ends)])
    return lambda time_ns: (corners @ body.motion.state(time_ns).pose.matrix().T)[:, :3]


def _vertices(mesh: Mesh, origin_m: Points) -> Mover:
    deformation = mesh.deformation
    assert deformation is not None
    return lambda time_ns: np.asarray(deformation.positions(time_ns), np.float64) + origin_m


def _moved_rad(then: Points, now: Points, places: Sequence[Points]) -> float:
    """Return a bound on the angle by which a point has moved, seen from any of the places."""
    far_m = float(np.linalg.norm(now - then, axis=1).max(initial=0.0))
    if not far_m:
        return 0.0
    near_m = math.inf
    for low, high in ((points.min(axis=0), points.max(axis=0)) for points in (then, now)):
        # To the sphere around the box around the points.
        middle, radius_m = (low + high) / 2, np.linalg.norm(high - low) / 2
        near_m = min(near_m, *(float(np.linalg.norm(place - middle) - radius_m) for place in places))
    return far_m / near_m if near_m > _NEAREST_M else math.inf


def _by_head(eye: EyeImage, view: View, nearest: float) -> float:
    moved = WarpMap.between(eye.view, eye.size, View(view.pose, eye.view.fov), eye.size)
    x, y = (np.linspace(0.0, side, _LINES) for side in eye.size)
    pixels = np.stack(np.meshgrid(x, y), axis=-1)
    ends = [moved.apply(pixels, np.full(pixels.shape[:2], depth))[0] for depth in (0.0, nearest)]
    far = max(float(np.linalg.norm(end - pixels, axis=-1).max()) for end in ends)
    return far if math.isfinite(far) else math.inf


def _nearest(eye: EyeImage) -> float:
    """Return the largest inverse depth of any layer, 0 where all is infinitely far."""
    depths = (texture for texture in eye.textures() if (texture.components, texture.dtype) == (1, "f4"))
    return max(0.0, *(float(np.nanmax(download(texture))) for texture in depths))


@attrs.frozen(eq=False)
class ChannelSetup:
    """What a channel is made for: the network, what is coded, and who gets the frames."""

    network: LinkOptions
    latency_ns: int
    # Refresh rate of the display.
    rate_hz: float
    # None for frames that arrive as drawn.
    coder: Coder | None = None
    # What the client reads of a frame; no other layer is coded or counted.
    reads: Reads = Reads()
    # Called with each frame that the client used and no longer needs.
    offer: Callable[[Frame], None] = lambda frame: None  # noqa: E731
    # Called with a frame, whether it arrived, and when the sender hears of it.
    settled: Callable[[Frame, bool, int], None] = lambda frame, arrived, heard_ns: None  # noqa: E731


class Channel:
    """Send each frame that the server draws; return the newest that has arrived, as it arrived.

    When an encoded frame arrives, its decoded layers are written over its own textures. The times
    of rendering, encoding and decoding delay a frame only where the network's options say so. A
    server that is still at work on a frame, or whose client is, draws none: the slowest stage sets
    the pace.

    recycle: called with each frame that the client never used. callbacks: of the Link, in place of
    those for frames that are coded here.
    """

    def __init__(self, setup: ChannelSetup, recycle: Callable[[Frame], None], **callbacks: Any) -> None:
        network, self._coder, rate_hz = setup.network, setup.coder, setup.rate_hz
        self._reads, self._beside = setup.reads, Reads()
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
        self._weights: dict[object, Counter[str]] = {}  # of frames that have pictures alone
        # Summary of what stands before this link, given the refreshes per second.
        self.before: Callable[[float], dict[str, Any]] | None = None
        how: dict[str, Any] = {
            "discard": lambda coded: setup.offer(coded.frame),
            "wasted": lambda coded: recycle(coded.frame),
            "receive": self._coder.receive if self._coder is not None else None,
            "decoding": self._decoding,
            "settled": lambda coded, arrived, heard_ns: setup.settled(coded.frame, arrived, heard_ns),
        }
        self.link: Link[Any] = network.link(setup.latency_ns, **how | callbacks)

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
        if self._free_ns is None or now_ns >= self._free_ns:
            return False
        self._skipped += 1
        if self._overload is not None:
            self._overload.lower(now_ns, self._free_ns - now_ns)
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
        self._eyes, (width, height) = len(frame.eyes), frame.eyes[0].size
        self._full_pixels = self._full_pixels or width * height  # the first is a full one
        self._share, self._sent_scale = width * height / self._full_pixels, self.scale
        self._scales[self._sent_scale] += 1
        if self._coder is None:
            coded, sizes = CodedFrame(frame), self._uncoded_bytes(frame)
        else:
            wants_key = self.link.needs_key(now_ns)
            coded = self._coder.encode(frame, self._reads, self._beside, wants_key=wants_key)
            sizes = coded.layer_bytes()
        self._frames += 1
        self._bytes.update(sizes)
        render_ns = encode_ns = 0
        if self._stages is not None:  # they delay the frame, and keep the server busy
            took = frame.timings_ms
            took["render"] = frame.render_ms if self._stages.render is None else 0.0
            render_ns, encode_ns, decode_ns = self._stages.taken_ns(took, self._share)
            took |= {"render": render_ns * 1e-6, "encode": encode_ns * 1e-6}
            if self._stages.decode is not None:
                self._decode_ns = decode_ns
            self._free_ns = now_ns + max(render_ns, encode_ns, self._decode_ns)
        transit = self.link.send(coded, now_ns, sizes.total(), coded.is_key, render_ns, encode_ns)
        self._slowest_ns = max(render_ns, encode_ns, self._decode_ns, transit.transfer_ns)
        if self._overload is not None:
            self._overload.sent(now_ns, transit.queue_ns, self._slowest_ns)

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
        if self._stages is None:
            return 0
        took, (width, height) = coded.frame.timings_ms, coded.frame.eyes[0].size
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
        scales = {f"{scale:g}": self._scales[scale] for scale in SCALES}
        return {
            "frames": self.fates(),
            **({"stages_ms": attrs.asdict(self._stages)} if self._stages is not None else {}),
            "mbit_s": self._bytes.total() * megabits,
            "layers_mbit_s": {name: count * megabits for name, count in self._bytes.most_common()},
            "frame_bytes": self._bytes.total() / max(self._frames, 1),
            # What asks for a frame, or finds that nothing has changed, as the feed writes it.
            "up_mbit_s": (self._frames + self._unchanged) * request_bytes(self._eyes) * megabits,
            **({} if self._overload is None else {"resolution": {"frames": scales, "changes": self._overload.changes}}),
            **(self._coder.summary() if self._coder is not None else {"codec": "none"}),
            **({"proxy": self.before(rate_hz)} if self.before is not None else {}),
        }

    def close(self) -> None:
        """Recycle every frame still held, and free the codecs; the statistics stay readable."""
        self.link.close()
        if self._coder is not None:
            # Not left to the channel: a cycle holds it until garbage is collected.
            self._coder.close()
