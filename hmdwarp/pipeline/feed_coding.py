"""Pictures of the feed through a codec, as the client would have them: both ends."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import MachineError
from ..frames.layers import PICTURE
from ..geometry import View
from ..link.codec import (
    AS_VIDEO,
    AS_VIDEO8,
    DEPTH_VIDEOS,
    EXACT,
    STEP,
    STOPS,
    VIDEOS,
    Coding,
    ColourDecoder,
    ColourEncoder,
    DepthDecoder,
    DepthEncoder,
    DepthVideoDecoder,
    DepthVideoEncoder,
    Packet,
    Undecodable,
    bytes_from_light,
    check_codec,
    codecs,
    depth_step,
    light_from_bytes,
    stops_of,
)
from ..sources.array_passes import LINEAR, SRGB8, Arrays
from ..sources.feed import bounds
from ..sources.feed.message import (
    AV1,
    DEPTH_CODES,
    DEPTH_EXACT,
    DEPTH_VIDEO,
    DEPTH_VIDEO8,
    H264,
    HEVC,
    INVERSE_DEPTH,
    NONE,
    RGBA8,
    RGBA16F,
    VP9,
    Ask,
    DepthCodes,
    FrameMessage,
    Picture,
    Wish,
)
from .feed_layers import unpacked
from .frame_coder import pixels_per_tangent

# The layer of frames whose picture is light alone; its table may have how far that reaches.
LIGHT = "light"
_CODECS = {H264: "h264", HEVC: "hevc", VP9: "vp9", AV1: "av1"}
_RAW_COLOURS = {RGBA16F: "float16", RGBA8: "srgb8"}
_RAW_DEPTHS = {INVERSE_DEPTH: "float32", DEPTH_CODES: "uint16"}
# What `bounds.CODED` counts a pixel for, by format of colour and of depth; and the bytes that an
# encoder keeps of one, FFV1's too.
_WORK = {H264: 1, HEVC: 4, VP9: 1, AV1: 3}, {DEPTH_VIDEO: 2, DEPTH_VIDEO8: 2}
_BYTES = {H264: 20, HEVC: 55, VP9: 90, AV1: 55}, {DEPTH_VIDEO: 65, DEPTH_VIDEO8: 65, DEPTH_EXACT: 40}
_FORMATS = {name: number for number, name in _CODECS.items()}
_DEPTHS = {AS_VIDEO: DEPTH_VIDEO, AS_VIDEO8: DEPTH_VIDEO8}
_VIDEOS = {number: DEPTH_VIDEOS[name] for name, number in _DEPTHS.items()}


def wish_of(
    raw: Wish, coding: Coding, rate_hz: float, views: Sequence[View], size: tuple[int, int], age_s: float
) -> Wish:
    """Return what to ask the server for, so that frames are coded as a run here would.

    raw: how they come without a codec. views, size: of the display; a guard band leaves the pixels
    as dense.
    """
    if codecs.get(coding.codec).is_none:
        return attrs.evolve(raw, rate_hz=rate_hz)
    step = STEP if coding.depth == EXACT else depth_step(pixels_per_tangent((view.fov, size) for view in views), age_s)
    return Wish(
        _FORMATS[coding.codec],
        _DEPTHS.get(coding.depth, DEPTH_EXACT),
        coding.crf,
        rate_hz,
        coding.bitrate_mbit or 0.0,
        step,
    )


def reading(wish: Wish, pictures: Collection[str]) -> Wish:
    """Return the wish without what nothing reads. pictures: as of PoseRequest."""
    colour, depth = (
        kind if name in pictures else NONE for name, kind in zip(PICTURE, (wish.colour, wish.depth), strict=True)
    )
    return attrs.evolve(wish, colour=colour, depth=depth)


def left_out(frame: FrameMessage, eye: int) -> frozenset[str]:
    """Return which pictures of a decoded frame did not come, by readable name."""
    both = zip(PICTURE, (frame.colours[eye], frame.inverse_depths[eye]), strict=True)
    return frozenset(name for name, picture in both if isinstance(picture, bytes))


def arrays_of(frame: FrameMessage, eye: int, size: tuple[int, int], missing: Collection[str] = ()) -> Arrays:
    """Return what a decoded frame has of one eye, in (w, h) pixels; nothing where it is missing."""
    of_colour, of_depth = PICTURE
    # Where nothing was drawn: one number each, at every pixel.
    no_colour, no_depth = np.broadcast_to(np.float16(0), (*size[::-1], 4)), np.broadcast_to(np.float32(-1), size[::-1])
    colour: Picture = no_colour if of_colour in missing else frame.colours[eye]
    depth: Picture = no_depth if of_depth in missing else frame.inverse_depths[eye]
    assert isinstance(colour, np.ndarray) and not isinstance(depth, bytes), "it is decoded"
    codes, step = (depth.codes, depth.step) if isinstance(depth, DepthCodes) else (depth, 1.0)
    encoding = SRGB8 if colour.dtype == np.uint8 else LINEAR
    return Arrays(colour, encoding, codes, step, is_inverse=True, is_apart=True)


def raw_form(frame: FrameMessage, before: Mapping[str, Any]) -> dict[str, Any]:
    """Return what summary.json says of raw frames: types, and the largest error of depth in 1/m.

    before: what it said after the frame before; {} for a coded frame, and the first.
    """
    if frame.is_coded:
        return {}
    error = max(before.get("depth_error", 0.0), depth_error(frame, Wish()))
    return {"colour": _RAW_COLOURS[frame.colour], "depth": _RAW_DEPTHS[frame.depth], "depth_error": error}


def depth_error(frame: FrameMessage, wish: Wish) -> float:
    """Return by how much coded depth may be wrong, in 1/m: as for frames that are coded here."""
    if frame.depth == DEPTH_CODES:
        return max(0.55 * depth.step for depth in frame.inverse_depths if isinstance(depth, DepthCodes))
    return {DEPTH_EXACT: wish.depth_step / 2, **dict.fromkeys(_VIDEOS, 2 * wish.depth_step)}.get(frame.depth, 0.0)


def codec_of(colour: int) -> str:
    """Return the name of the codec of a format of colour."""
    return _CODECS.get(colour, "none")


def codes_video(form: int, *, of_depth: bool = False) -> bool:
    """Return whether pictures of a format need those before them."""
    return form in (_VIDEOS if of_depth else _CODECS)


def check_work(ask: Ask) -> None:
    """Check what coding a frame will take. Errors: bounds.OutOfBounds."""
    bounds.CODED.check(_of_all_pixels(ask, _WORK))


def videos_for_browsers() -> dict[str, int]:
    """Return what this machine encodes, the best first; of each what a pixel counts, with depth."""
    found = {}
    for name in VIDEOS:
        with suppress(MachineError):
            check_codec(name)
            found[name] = _WORK[0][_FORMATS[name]] + _WORK[1][DEPTH_VIDEO8]
    return found


def _of_all_pixels(ask: Ask, of: tuple[dict[int, int], dict[int, int]]) -> int:
    of_pixel = of[0].get(ask.wish.colour, 0) + of[1].get(ask.wish.depth, 0)
    return len(ask.views) * ask.size[0] * ask.size[1] * of_pixel


class FeedEncoder:
    """Code the frames of one client, of one size, as it requests: colour in bytes for a video.

    Errors: as VideoEncoder.
    """

    def __init__(self, ask: Ask) -> None:
        self.wish, self.size, self._place = ask.wish, ask.size, 0
        self._eyes = [_EyeEncoder(ask.wish, ask.size) for _ in ask.views]
        # That its encoders hold, about.
        self.bytes = _of_all_pixels(ask, _BYTES)

    def suits(self, ask: Ask) -> bool:
        """Return whether the next frame may follow on the ones before."""
        return not ask.anew and (ask.wish, ask.size, len(ask.views)) == (self.wish, self.size, len(self._eyes))

    def encode(self, frame: FrameMessage) -> FrameMessage:
        """Return the frame, coded: the next of its stream."""
        place, self._place = self._place, self._place + 1
        sides = zip(self._eyes, frame.colours, frame.inverse_depths, strict=True)
        colours, depths = zip(*(eye.encode(colour, depth, not place) for eye, colour, depth in sides), strict=True)
        layers = [dict(of_eye) for of_eye in frame.layers]
        for of_eye, eye in zip(layers, self._eyes, strict=False):
            if LIGHT in of_eye and eye.stops:
                of_eye[LIGHT] = [np.array([[eye.stops]], np.float64)]
        return attrs.evolve(
            frame,
            layers=tuple(layers),
            colours=colours,
            inverse_depths=depths,
            colour=self.wish.colour or RGBA16F,
            depth=self.wish.depth or INVERSE_DEPTH,
            coded_size=self.size,
            begins=place == 0,
            place=place,
        )


class _EyeEncoder:
    def __init__(self, wish: Wish, size: tuple[int, int]) -> None:
        self._colour: ColourEncoder | None = None
        self._depth: DepthVideoEncoder | DepthEncoder | None = None
        if wish.colour in _CODECS:
            codec, mbit = codecs.get(_CODECS[wish.colour]), wish.bitrate_mbit or None
            self._colour = ColourEncoder(codec, size, wish.rate_hz, wish.crf, mbit)
        step = wish.depth_step or STEP
        if wish.depth in _VIDEOS:
            self._depth = DepthVideoEncoder(size, wish.rate_hz, step, _VIDEOS[wish.depth])
        elif wish.depth == DEPTH_EXACT:
            self._depth = DepthEncoder(size, step)
        # Powers of 2 beyond 1 that the bytes of light reach; see bytes_from_light.
        self.stops = 0

    def encode(self, colour: Any, depth: Any, key: bool) -> tuple[Any, Any]:
        if self._colour is not None:
            if colour.dtype == np.float16:
                light = np.ascontiguousarray(colour[..., :3])
                self.stops = max(stops_of(light), self.stops)
                colour = bytes_from_light(light, self.stops)
            colour, _ = self._colour.encode(colour[..., :3], key)
        if self._depth is not None:
            coded = self._depth.encode(depth)
            depth = coded.data if isinstance(coded, Packet) else coded
        return colour, depth


class FeedDecoder:
    """Decode the frames of a server, which may change their formats and size."""

    def __init__(self) -> None:
        self._eyes: list[_EyeDecoder] = []
        self._coded_as: tuple[Any, ...] = ()
        self.wants_anew = True

    def decode(self, frame: FrameMessage) -> FrameMessage:
        """Return the frame with pictures, but for those left out.

        Errors: Undecodable, until one begins the stream anew.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # what overflows is not finite, and left out
            found = self._decoded(frame)
        if not found.is_finite:
            raise Undecodable("numbers that are not finite in its pictures")
        found = unpacked(found)
        # Linear light where the bytes reach beyond 1.
        colours = list(found.colours)
        for eye, of_eye in enumerate(found.layers):
            colour, rows = colours[eye], of_eye.get(LIGHT, ())
            stops = [number for row in rows if isinstance(row, np.ndarray) for number in row.flat]
            if not stops or not isinstance(colour, np.ndarray) or colour.dtype != np.uint8:
                continue
            if len(stops) != 1 or stops[0] not in STOPS:
                raise Undecodable(f"light that reaches 2^{stops}: expected one of {STOPS}")
            light = light_from_bytes(np.asarray(colour[..., :3], np.uint8), int(stops[0]))
            colours[eye] = np.concatenate([light, (colour[..., 3:] > 0).astype(np.float16)], axis=-1)
        return attrs.evolve(found, colours=tuple(colours))

    def _decoded(self, frame: FrameMessage) -> FrameMessage:
        if not frame.is_coded:
            self.wants_anew = False
            return frame
        coded_as = frame.colour, frame.depth, frame.size, len(frame.views)
        if frame.begins and self._coded_as != coded_as:
            self._eyes, self._coded_as = [_EyeDecoder(frame) for _ in frame.views], coded_as
        self.wants_anew = True
        if self._coded_as != coded_as:
            raise Undecodable("another format, size or number of eyes than where the stream began")
        sides = zip(self._eyes, frame.colours, frame.inverse_depths, strict=True)
        colours, depths = zip(*(eye.decode(frame, colour, depth) for eye, colour, depth in sides), strict=True)
        self.wants_anew = False
        return attrs.evolve(frame, colours=colours, inverse_depths=depths)


class _EyeDecoder:
    def __init__(self, frame: FrameMessage) -> None:
        self._colour = ColourDecoder(codecs.get(_CODECS[frame.colour]), frame.size) if frame.colour in _CODECS else None
        self._video = DepthVideoDecoder(frame.size, _VIDEOS[frame.depth]) if frame.depth in _VIDEOS else None
        self._depth = DepthDecoder(frame.size)

    def decode(self, frame: FrameMessage, colour: Any, depth: Any) -> tuple[NDArray[Any], NDArray[np.float32]]:
        if self._video is not None:
            depth = self._video.decode(Packet(frame.place, frame.begins, depth))
        elif frame.depth == DEPTH_EXACT:
            depth = self._depth.decode(depth)
        elif isinstance(depth, DepthCodes):
            depth = depth.numbers()
        if self._colour is not None:
            self._colour.begin(frame.place, frame.begins)
            light = self._colour.decode(colour, frame.place)
            # A video has no coverage: what has no depth was not drawn. Without depth all of it was.
            drawn = np.full(light.shape[:2], True) if frame.depth == NONE else depth >= 0
            colour = np.dstack([light, np.where(drawn, 255, 0).astype(np.uint8)])
        return colour, depth
