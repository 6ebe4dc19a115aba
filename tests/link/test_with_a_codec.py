"""Frames that are encoded, sent through a network that loses some, and decoded.

What the loop does with these parts.
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from coded_frames import pictures

from hmdwarp.colour import picture_from_linear
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Decoder, Encoder, Packet, Undecodable

pytest.importorskip("av")
SIZE, RATE_HZ, LATENCY_NS = (64, 64), 60, 50_000_000


@attrs.define(eq=False)
class EncodedFrame:
    """A frame on its way, and what came of it."""

    packet: Packet
    picture: np.ndarray | None = None


@attrs.define
class Stream:
    """One eye: encoder, link, decoder."""

    options: LinkOptions
    encoder: Encoder = attrs.field(factory=lambda: Encoder("h264", SIZE, RATE_HZ))
    decoder: Decoder = attrs.field(factory=lambda: Decoder("h264", SIZE))
    wasted: list[int] = attrs.field(factory=list)
    shown: list[int | None] = attrs.field(factory=list)
    keys: list[int] = attrs.field(factory=list)

    def receive(self, encoded: EncodedFrame) -> bool:
        try:
            encoded.picture = self.decoder.decode(encoded.packet)
        except Undecodable:
            return False
        return True

    def run(self, count: int):
        link = self.options.link(
            LATENCY_NS, wasted=lambda encoded: self.wasted.append(encoded.packet.number), receive=self.receive
        )
        drawn = pictures(SIZE, count)
        for k, picture in enumerate(drawn):
            now_ns = k * 10**9 // RATE_HZ
            if link.needs_key(now_ns):
                self.encoder.request_key()
            packet = self.encoder.encode(picture)
            self.keys += [k] if packet.key else []
            link.send(EncodedFrame(packet), now_ns, packet.size_bytes, packet.key)
            encoded = link.newest(now_ns)
            self.shown.append(encoded.packet.number if encoded is not None else None)
            if encoded is not None:
                self.looks_like_its_original(encoded, drawn)
        return link

    def looks_like_its_original(self, encoded: EncodedFrame, drawn) -> None:
        before, after = drawn[encoded.packet.number], encoded.picture
        assert (after[..., 3] == before[..., 3]).all()
        wrong = picture_from_linear(after).astype(float) - picture_from_linear(before)
        # 28 dB of what is covered: broken chains lie far below
        assert np.mean(wrong[before[..., 3] > 0] ** 2) < 255**2 / 10**2.8


def test_a_network_that_loses_nothing_shows_every_frame_as_long_after_as_it_takes():
    stream = Stream(LinkOptions())
    link = stream.run(20)
    late = -(-LATENCY_NS * RATE_HZ // 10**9)
    assert stream.shown == [None] * late + list(range(20 - late))
    assert stream.keys == [0]
    assert link.tally.as_dict()["shown"] == 20 - late


def test_a_loss_is_answered_with_a_key_frame_and_nothing_broken_is_shown():
    """After a loss the picture stands still until a key frame has come.

    The loss is noticed a delay after sending, the sender hears of it another delay later, and the
    key frame takes a third.
    """
    stream = Stream(LinkOptions.of({"loss": "0.138", "loss_burst": 2.0, "link_seed": 3}))
    link = stream.run(120)
    tally = link.tally
    assert tally.lost > 0
    assert tally.undecodable > 0
    assert len(stream.keys) > 1
    assert tally.drawn == 120 == tally.lost + tally.undecodable + tally.superseded + tally.shown + tally.under_way
    assert sorted(stream.wasted) == sorted(set(stream.wasted))
    assert len(stream.wasted) == tally.lost + tally.undecodable
    shown = [number for number in stream.shown if number is not None]
    assert shown == sorted(shown)
    # The first loss of all: its key frame is sent two delays later, to the refresh.
    gap = -(-2 * LATENCY_NS * RATE_HZ // 10**9)
    assert stream.keys[1] == stream.wasted[0] + gap


def test_with_jitter_the_decoder_still_gets_frames_in_order():
    stream = Stream(LinkOptions.of({"jitter": "uniform:40"}))
    link = stream.run(90)
    assert link.tally.late == link.tally.undecodable == link.tally.lost == 0
    assert stream.keys == [0]
    assert link.tally.superseded > 0


def test_a_narrow_network_drops_frames_and_recovers():
    """The frames make 0.1 Mbit a second, 0.04 fit through.

    The queue fills, and what it drops calls for key frames.
    """
    stream = Stream(LinkOptions.of({"bandwidth": "0.04", "queue": 60.0}))
    link = stream.run(150)
    assert link.tally.dropped > 0
    assert link.tally.drawn == link.tally.dropped + link.tally.sent == 150
    assert len(stream.keys) > 1
    assert stream.shown[-1] > stream.keys[1]
