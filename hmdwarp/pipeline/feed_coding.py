"""What crosses the feed: pictures through a codec, and further layers; both ends of it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError, MachineError
from ..frames import EyeImage, EyeSizes, Frame, Needs
from ..frames.layers import BYTES, OWN, PICTURE, Layer, layers
from ..frames.layers.pictures import FOVEATED
from ..geometry import Fov, Fovea, FoveaGrid, Pose, View, grid_of
from ..gpu import COLOUR, NUMBER, SCALAR, download, upload
from ..link import codec
from ..link.codec import Coding, Packet, Undecodable
from ..sources.array_passes import LINEAR, SRGB8, Arrays
from ..sources.feed import bounds, message
from ..sources.feed.message import Ask, DepthCodes, FrameMessage, Picture, Wish
from ..sources.feed.parts import BadPart, Layers, Packed, Wanted, packed, unpacked_bytes
from ..sources.server import Renderer
from .channel import depth_step

Array = NDArray[np.float64]
Size = tuple[int, int]
# Scale and offset of the vectors' x, y, z; metres at z = 0 and at z = 1; seconds since the frame
# before; that frame's eye: pose, head_from_eye, angles.
NUMBERS = 3 + 3 + 2 + 1 + 18
# Halves are rounded within 2^-11 of their value, and what is computed from them as often again.
_RELATIVE, _ABSOLUTE = 2.0**-10, 2.0**-20


def velocity_of(parts: Sequence[NDArray[Any]], view: View, inverse_depth: NDArray[Any]) -> NDArray[np.float16]:
    """Return (h, w, 4): m/s along the eye's axes, and 1 where something moves by itself.

    parts: the vectors, and a row of NUMBERS. view, inverse_depth: of the picture. Vectors of lower
    resolution are spread to the pixels around them whose depth is theirs. Errors: InputError.
    """
    if len(parts) != 2 or parts[0].ndim != 3 or parts[1].shape != (1, NUMBERS):
        raise InputError(f"motion vectors: expected a picture of 4 numbers a pixel, and a row of {NUMBERS}")
    with np.errstate(all="ignore"):  # whatever numbers come: what is not finite in the end does not move
        vectors, told = parts[0].astype(np.float64), parts[1][0].astype(np.float64)
        near, far, seconds = told[6:9]
        finite = np.isfinite(np.delete(told, (6, 7))).all()
        if not (finite and seconds > 0 and (near > 0 and far > 0 and near != far or near == far == 0)):
            raise InputError(
                f"motion vectors over {seconds:g} s, from {near:g} to {far:g} m: expected finite numbers, a time above "
                "0, and two distances, or 0 and 0 for vectors of two numbers"
            )
        vectors = np.nan_to_num(vectors[..., :3], posinf=0, neginf=0) * told[:3] + told[3:6]
        # The rows and columns of the picture that the centres of the vectors' pixels lie in.
        own = [
            ((np.arange(count) + 0.5) * many / count).astype(np.intp)
            for many, count in zip(inverse_depth.shape, vectors.shape[:2], strict=True)
        ]
        depth = inverse_depth[np.ix_(*own)].astype(np.float64)
        before = View(Pose(told[9:12], told[12:16]), Fov(*told[23:27]), Pose(told[16:19], told[19:23]))
        # What an engine's z stands for, in 1/m: at z = 0 and at z = 1; None for vectors without z.
        has_depth, of_z = depth > 0, None if near == far else (1 / near, 1 / far)
        # The pixels' centres, from -1 to 1, y down.
        rows, columns = (2 * (np.arange(count) + 0.5) / count - 1 for count in vectors.shape[:2])
        x, y = np.meshgrid(columns, rows)
        here = _points(view.fov.tangents, x, y, np.where(has_depth, depth, 1.0))
        then_from_now = before.pose.relative_to(view.pose).inverse()
        # In the eye before: where it would have been had it stood still, and where the vectors say.
        still = then_from_now.rotation.apply(here.reshape(-1, 3)).reshape(here.shape) + then_from_now.position_m
        now = _ndc(view.fov.tangents, here, of_z)
        by_head = now - _ndc(before.fov.tangents, still, of_z)
        if of_z is None:
            # It had the depth that it would have, had it stood still.
            vectors = np.dstack([vectors[..., :2], by_head[..., 2]])
        place = now - vectors
        inverse = -1 / still[..., 2] if of_z is None else of_z[0] + place[..., 2] * (of_z[1] - of_z[0])
        # Behind the eye nothing was seen.
        then = _points(before.fov.tangents, place[..., 0], place[..., 1], np.where(inverse > 0, inverse, np.nan))
        rounding = _RELATIVE * np.abs(vectors) + _ABSOLUTE
        moves = has_depth & (np.abs(vectors - by_head) > rounding).any(axis=2) & np.isfinite(then).all(axis=2)
        velocity = np.zeros((*depth.shape, 4))
        back = then_from_now.rotation.inv()
        velocity[moves, :3] = back.apply((still - then)[moves]) / told[8]
        velocity[moves, 3] = 1
        found = np.clip(velocity, -65504, 65504).astype(np.float16)
    return found if depth.shape == inverse_depth.shape else _spread(found, depth, inverse_depth)


def _points(tangents: Array, x: Array, y: Array, inverse_depth: Array) -> Array:
    """Return points in the eye's axes."""
    left, right, down, up = tangents
    along = np.stack([left + (right - left) * (x + 1) / 2, up - (up - down) * (y + 1) / 2, -np.ones_like(x)], axis=-1)
    return along / inverse_depth[..., None]


def _ndc(tangents: Array, points: Array, of_z: tuple[float, float] | None) -> Array:
    """Return x, y from -1 to 1, y down, and z as the engine has it, 0 without."""
    left, right, down, up = tangents
    inverse = -1 / points[..., 2]
    x, y = points[..., 0] * inverse, points[..., 1] * inverse
    z = np.zeros_like(x) if of_z is None else (inverse - of_z[0]) / (of_z[1] - of_z[0])
    return np.stack([2 * (x - left) / (right - left) - 1, 2 * (up - y) / (up - down) - 1, z], axis=-1)


def _spread(found: NDArray[np.float16], depth: Array, inverse_depth: NDArray[Any]) -> NDArray[np.float16]:
    """Return, for each pixel, the velocity of that of the four around it whose depth is nearest."""
    shape, best = inverse_depth.shape, np.full(inverse_depth.shape, np.inf)
    out = np.zeros((*shape, 4), np.float16)
    places = [(np.arange(many) + 0.5) * count / many - 0.5 for many, count in zip(shape, depth.shape, strict=True)]
    for steps in itertools.product((0, 1), repeat=2):
        rows, columns = (
            np.clip(np.floor(place).astype(np.intp) + step, 0, count - 1)
            for place, step, count in zip(places, steps, depth.shape, strict=True)
        )
        apart = np.abs(depth[np.ix_(rows, columns)] - inverse_depth)
        nearer = apart < best
        out[nearer] = found[np.ix_(rows, columns)][nearer]
        best[nearer] = apart[nearer]
    return out


_KINDS = {"rgba16f": COLOUR, "r32f": SCALAR, "r16ui": NUMBER}
_NOTHING = np.zeros((0, 0))  # sent of a layer that adds nothing to a frame, so that it is told
VELOCITY, FOVEA_GRID = "velocity", "foveated"
# In m, m/s and rad/s: what moves is multiplied by its age and stays a number.
_LARGEST = 1e6
_MOST_TABLE = 1 << 20  # bytes of a layer besides its pictures


def wanted_of(needs: Needs, views: Sequence[View], shown_size: Size) -> Wanted | None:
    """Return what to ask a server for; other layers are the client's. views: as shown."""
    of_server = [layer for layer in map(layers.get, needs) if not layer.of_client]
    amounts = tuple((layer.name, layer.stated(needs[layer.name])) for layer in of_server)
    return Wanted(amounts, shown_size, tuple(view.fov for view in views)) if amounts else None


def fovea_of(needs: Needs) -> tuple[Fovea | None, frozenset[str], Needs]:
    """Return the fovea that is needed or None, the pictures it makes coarser, and the rest."""
    found = [name for name in FOVEATED if name in needs]
    stand_for = frozenset(picture for name, picture in zip(FOVEATED, PICTURE, strict=True) if name in found)
    rest = Needs(**{name: amount for name, amount in needs.items() if name not in FOVEATED})
    return needs[found[0]] if found else None, stand_for, rest


def grids_of(frame: FrameMessage, size: Size) -> tuple[FoveaGrid, ...]:
    """Return the grid of each eye's foveated pictures.

    size: of the whole ones. Errors: Undecodable.
    """
    grids = []
    for of_eye in frame.layers or ({},) * len(frame.views):
        parts = of_eye.get(FOVEA_GRID, ())
        try:
            if len(parts) != 1 or unpacked_bytes([{FOVEA_GRID: parts}]) > _MOST_TABLE:
                raise InputError(f"{len(parts)} grids of a foveated picture: expected one")
            numbers = parts[0].numbers() if isinstance(parts[0], Packed) else parts[0]
            grids.append(grid_of(numbers, frame.size))
        except (BadPart, InputError) as error:
            raise Undecodable(str(error)) from error
        if grids[-1].size != size:
            raise Undecodable(f"a foveated picture of {grids[-1].size} pixels: expected {size}")
    return tuple(grids)


def needs_of_client(wanted: Wanted | None) -> Needs:
    """Return what a client wants. Errors: InputError for a layer that frames cannot carry."""
    found: dict[str, Any] = {}
    for name, stated in wanted.layers if wanted is not None else ():
        if name not in layers.names() or layers.get(name).of_client or layers.get(name).always:
            raise InputError(f"there is no layer '{name}' here")
        try:
            found[name] = layers.get(name).amount_of(stated)
        except (TypeError, ValueError, OverflowError) as error:
            why = str(error).partition("\n")[0]
            raise InputError(f"there is no {stated} of layer '{name}' ({why}): see docs/feed.md") from error
    return Needs(**found)


def sizes_of(wanted: Wanted, size: Size) -> EyeSizes:
    """Return what the sizes of layers follow from. size: of the rendered picture."""
    return EyeSizes(size, wanted.size, wanted.fovs)


def parts_of(frame: Frame, needs: Needs, *, packs: bool) -> tuple[Layers, ...]:
    """Return the needed layers of each eye as arrays; what both share is in the first one's.

    packs: without loss, for a slow network.
    """
    found = tuple(dict[str, list[NDArray[Any] | Packed]]() for _ in frame.eyes)
    for (number, eye), name in itertools.product(enumerate(frame.eyes), needs):
        layer = layers.get(name)
        if not (number and layer.per_frame):
            sent, numbers = layer.sent(eye[name]), layer.numbers(eye[name])
            drawn = [one.reshape(1, -1) if isinstance(one, np.ndarray) else download(one) for one in sent]
            rest = [numbers] if numbers is not None else [] if drawn else [_NOTHING]
            found[number][name] = [*(packed(picture) if packs else picture for picture in drawn), *rest]
    return found


def unpacked(frame: FrameMessage) -> FrameMessage:
    """Return the frame with numbers in place of packed parts, and velocities of motion vectors.

    Its depth must be decoded. Errors: Undecodable.
    """
    if not frame.layers:
        return frame
    found = []
    try:
        for eye, (of_eye, view) in enumerate(zip(frame.layers, frame.views, strict=True)):
            own = {}
            for name, parts in of_eye.items():
                own[name] = [part.numbers() if isinstance(part, Packed) else part for part in parts]
            if len(own.get(VELOCITY, ())) > 1:
                if isinstance(frame.inverse_depths[eye], bytes):
                    raise InputError("motion vectors without depth")
                own[VELOCITY] = [velocity_of(own[VELOCITY], view, frame.inverse_depth(eye))]
            found.append(own)
    except (BadPart, InputError) as error:
        raise Undecodable(str(error)) from error
    return attrs.evolve(frame, layers=tuple(found))


def wanted_alone(frame: FrameMessage, wanted: Wanted | None, drawn: Size) -> FrameMessage:
    """Return the frame with the requested layers alone: others are never unpacked.

    drawn: (w, h) of the whole picture.
    Errors: Undecodable where one claims to be larger than requested.
    """
    names = needs_of_client(wanted)
    found = tuple({name: of_eye[name] for name in of_eye if name in names} for of_eye in frame.layers)
    for of_eye in found:
        for name, parts in of_eye.items():
            assert wanted is not None
            layer, sizes = layers.get(name), sizes_of(wanted, drawn)
            most = bounds.most_beside(drawn) if layer.size_class == OWN else layer.bytes(names[name], sizes)
            if unpacked_bytes([{name: parts}]) > most + _MOST_TABLE:
                raise Undecodable(f"layer '{name}' claims to be larger than requested")
    return attrs.evolve(frame, layers=found)


def misfit(frame: FrameMessage, wanted: Wanted | None, drawn: Size | None = None) -> str:
    """Return why a frame's layers are not the requested ones, "" if they are.

    drawn: (w, h) of the whole picture where that is foveated.
    """
    if wanted is None:
        return ""
    sizes, amounts = sizes_of(wanted, drawn or frame.size), needs_of_client(wanted)
    for eye, of_eye in enumerate(frame.layers or ({},) * len(frame.views)):
        for name, amount in amounts.items():
            layer = layers.get(name)
            if eye and layer.per_frame:
                continue
            if name not in of_eye:
                return f"the server sends no layer '{name}'"
            if wrong := next(filter(None, _misfits_of(layer, layer.pictures(amount), list(of_eye[name]), sizes)), ""):
                return f"layer '{name}' of the server: {wrong}"
    return ""


def _misfits_of(layer: type[Layer], formats: Sequence[str], parts: list[Any], sizes: EyeSizes) -> Iterator[str]:
    """Yield why the parts are no layer's: what follows on the first reason may not run."""
    pictures, numbers = parts[: len(formats)], [one for one in parts[len(formats) :] if one.shape[1:] != (0,)]
    if len(pictures) < len(formats) or len(numbers) > 1:
        yield f"{len(parts)} parts: expected {len(formats)} pictures"
    for one, form in zip(pictures, formats, strict=True):
        if form == BYTES:
            if one.dtype != np.uint8 or len(one) != 1:
                yield f"{one.dtype} of shape {one.shape}: expected a row of bytes"
            continue
        channels, dtype = _KINDS[form]
        wide, high = one.shape[1::-1] if layer.size_class == OWN else layer.size(sizes)
        shape = (high, wide, channels) if channels > 1 else (high, wide)
        if layer.size_class == OWN and one.nbytes > bounds.most_beside(sizes.rendered):
            yield f"{wide}x{high} pixels beside {sizes.rendered[0]}x{sizes.rendered[1]}: too many"
        if one.shape != shape or one.dtype != np.dtype(dtype):
            yield f"{one.dtype} of shape {one.shape}: expected {np.dtype(dtype)} of {shape}"
        if one.dtype.kind == "f" and not np.isfinite(one).all():
            yield "numbers that are not finite"
    if numbers and (numbers[0].dtype != np.float64 or not (np.abs(numbers[0]) <= _LARGEST).all()):
        yield f"numbers beside its pictures: expected f64 of {_LARGEST:g} at most"
    yield layer.misfit(pictures, numbers[0] if numbers else None)


def made(server: Renderer, eyes: Sequence[EyeImage], parts: Sequence[Layers], wanted: Wanted | None) -> list[EyeImage]:
    """Return the eyes with the wanted layers, in textures of the server's pools."""
    shared, found = dict[str, Any](), []
    for eye, of_eye in zip(eyes, parts, strict=True):
        own = dict[str, Any]()
        for name, amount in needs_of_client(wanted).items():
            layer, sent = layers.get(name), list[Any]()
            if name in shared:
                continue
            formats, sides = layer.pictures(amount), list[Any](of_eye[name])
            for one, form in zip(sides, formats, strict=False):
                if form == BYTES:
                    sent.append(one.ravel())
                else:
                    sent.append(server.acquire(one.shape[1::-1], _KINDS[form], depth=False).colour)
                    upload(sent[-1], one)
            numbers = sides[-1] if len(sides) > len(formats) else None
            (shared if layer.per_frame else own)[name] = layer.made(sent, numbers, amount, eye.drawn_ns)
        found.append(eye.having(**shared, **own))
    return found


# The layer of frames whose picture is light alone; its table may have how far that reaches.
LIGHT = "light"
CODECS = {message.H264: "h264", message.HEVC: "hevc", message.VP9: "vp9", message.AV1: "av1"}
# Of a pixel, by format of colour and of depth: what `bounds.CODED` counts it for, and the bytes
# that an encoder keeps of it, FFV1's too.
_COSTS = (
    {message.H264: (1, 20), message.HEVC: (4, 55), message.VP9: (1, 90), message.AV1: (3, 55)},
    {message.DEPTH_VIDEO: (2, 65), message.DEPTH_VIDEO8: (2, 65), message.DEPTH_EXACT: (0, 40)},
)
_FORMATS = {name: number for number, name in CODECS.items()}
_DEPTHS = {codec.AS_VIDEO: message.DEPTH_VIDEO, codec.AS_VIDEO8: message.DEPTH_VIDEO8}
_VIDEOS = {number: codec.DEPTH_VIDEOS[name] for name, number in _DEPTHS.items()}


def wish_of(raw: Wish, coding: Coding, rate_hz: float, views: Sequence[View], size: Size, age_s: float) -> Wish:
    """Return what to ask the server for, so that frames are coded as a run here would.

    raw: how they come without a codec. views, size: of the display; a guard band leaves the pixels
    as dense.
    """
    if codec.codecs.get(coding.codec).is_none:
        return attrs.evolve(raw, rate_hz=rate_hz)
    step = depth_step(coding, [(view.fov, size) for view in views], age_s)
    forms = _FORMATS[coding.codec], _DEPTHS.get(coding.depth, message.DEPTH_EXACT)
    return Wish(*forms, coding.crf, rate_hz, coding.bitrate_mbit or 0.0, step)


def left_out(frame: FrameMessage, eye: int) -> frozenset[str]:
    """Return which pictures of a decoded frame did not come, by readable name."""
    both = zip(PICTURE, (frame.colours[eye], frame.inverse_depths[eye]), strict=True)
    return frozenset(name for name, picture in both if isinstance(picture, bytes))


def arrays_of(frame: FrameMessage, eye: int, size: Size, missing: Collection[str] = ()) -> Arrays:
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


def depth_error(frame: FrameMessage, wish: Wish) -> float:
    """Return by how much coded depth may be wrong, in 1/m: as for frames that are coded here."""
    if frame.depth == message.DEPTH_CODES:
        return max(0.55 * depth.step for depth in frame.inverse_depths if isinstance(depth, DepthCodes))
    steps = {message.DEPTH_EXACT: 0.5, **dict.fromkeys(_VIDEOS, 2.0)}.get(frame.depth, 0.0)
    return steps * wish.depth_step


def stands_alone(frame: FrameMessage) -> bool:
    """Return whether a frame can be decoded without those before it."""
    return frame.begins or not (frame.colour in CODECS or frame.depth in _VIDEOS)


def check_work(ask: Ask) -> None:
    """Check what coding a frame will take. Errors: bounds.OutOfBounds."""
    bounds.CODED.check(_of_all_pixels(ask)[0])


def videos_for_browsers() -> dict[str, int]:
    """Return what this machine encodes, the best first; of each what a pixel counts, with depth."""
    found = {}
    for name in codec.VIDEOS:
        with suppress(MachineError):
            codec.codecs.get(name).check()
            found[name] = _COSTS[0][_FORMATS[name]][0] + _COSTS[1][message.DEPTH_VIDEO8][0]
    return found


def _of_all_pixels(ask: Ask) -> tuple[int, ...]:
    pixels = len(ask.views) * ask.size[0] * ask.size[1]
    both = (costs.get(form, (0, 0)) for costs, form in zip(_COSTS, (ask.wish.colour, ask.wish.depth), strict=True))
    return tuple(pixels * sum(of_pixel) for of_pixel in zip(*both, strict=True))


class FeedEncoder:
    """Code the frames of one client, of one size, as it requests: colour in bytes for a video.

    Errors: as VideoEncoder.
    """

    def __init__(self, ask: Ask) -> None:
        self.wish, self.size, self._place = ask.wish, ask.size, 0
        self._eyes = [_encoders(ask.wish, ask.size) for _ in ask.views]
        # Powers of 2 beyond 1 that the bytes of each eye's light reach; see bytes_from_light.
        self._stops = [0] * len(ask.views)
        self.bytes = _of_all_pixels(ask)[1]  # that its encoders hold, about

    def suits(self, ask: Ask) -> bool:
        """Return whether the next frame may follow on the ones before."""
        return not ask.anew and (ask.wish, ask.size, len(ask.views)) == (self.wish, self.size, len(self._eyes))

    def encode(self, frame: FrameMessage) -> FrameMessage:
        """Return the frame, coded: the next of its stream."""
        place, self._place = self._place, self._place + 1
        colours, depths, layers = list[Any](), list[Any](), [dict(of_eye) for of_eye in frame.layers]
        for eye, (of_colour, of_depth) in enumerate(self._eyes):
            colour: Any = frame.colours[eye]
            if of_colour is not None:
                if colour.dtype == np.float16:
                    light = np.ascontiguousarray(colour[..., :3])
                    self._stops[eye] = max(codec.stops_of(light), self._stops[eye])
                    colour = codec.bytes_from_light(light, self._stops[eye])
                colour, _ = of_colour.encode(colour[..., :3], not place)
            colours.append(colour)
            depths.append(of_depth(frame.inverse_depths[eye]))
            if self._stops[eye] and eye < len(layers) and LIGHT in layers[eye]:
                layers[eye][LIGHT] = [np.array([[self._stops[eye]]], np.float64)]
        coded: dict[str, Any] = {"colours": tuple(colours), "inverse_depths": tuple(depths), "layers": tuple(layers)}
        coded |= {"colour": self.wish.colour or message.RGBA16F, "depth": self.wish.depth or message.INVERSE_DEPTH}
        return attrs.evolve(frame, **coded, coded_size=self.size, begins=place == 0, place=place)


def _encoders(wish: Wish, size: Size) -> tuple[codec.ColourEncoder | None, Callable[[Any], Any]]:
    """Return what codes an eye's colour, None where it goes as it is, and its depth."""
    colour, step = None, wish.depth_step or codec.STEP
    if wish.colour in CODECS:
        how, mbit = codec.codecs.get(CODECS[wish.colour]), wish.bitrate_mbit or None
        colour = codec.ColourEncoder(how, size, wish.rate_hz, wish.crf, mbit)
    if wish.depth in _VIDEOS:
        video = codec.DepthVideoEncoder(size, wish.rate_hz, step, _VIDEOS[wish.depth])
        return colour, lambda depth: video.encode(depth).data
    return colour, codec.DepthEncoder(size, step).encode if wish.depth == message.DEPTH_EXACT else lambda depth: depth


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
        found, self.wants_anew = frame, frame.is_coded
        if frame.is_coded:
            coded_as = frame.colour, frame.depth, frame.size, len(frame.views)
            if frame.begins and self._coded_as != coded_as:
                self._eyes, self._coded_as = [_EyeDecoder(frame) for _ in frame.views], coded_as
            if self._coded_as != coded_as:
                raise Undecodable("another format, size or number of eyes than where the stream began")
            sides = zip(self._eyes, frame.colours, frame.inverse_depths, strict=True)
            with np.errstate(over="ignore", invalid="ignore"):  # what overflows is not finite, and left out
                pictures = [eye.decode(frame, colour, depth) for eye, colour, depth in sides]
            of_colour, of_depth = zip(*pictures, strict=True)
            found, self.wants_anew = attrs.evolve(frame, colours=of_colour, inverse_depths=of_depth), False
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
            if len(stops) != 1 or stops[0] not in codec.STOPS:
                raise Undecodable(f"light that reaches 2^{stops}: expected one of {codec.STOPS}")
            light = codec.light_from_bytes(np.asarray(colour[..., :3], np.uint8), int(stops[0]))
            colours[eye] = np.concatenate([light, (colour[..., 3:] > 0).astype(np.float16)], axis=-1)
        return attrs.evolve(found, colours=tuple(colours))


class _EyeDecoder:
    def __init__(self, frame: FrameMessage) -> None:
        how = codec.codecs.get(CODECS[frame.colour]) if frame.colour in CODECS else None
        self._colour = codec.ColourDecoder(how, frame.size) if how is not None else None
        self._video = codec.DepthVideoDecoder(frame.size, _VIDEOS[frame.depth]) if frame.depth in _VIDEOS else None
        self._depth = codec.DepthDecoder(frame.size)

    def decode(self, frame: FrameMessage, colour: Any, depth: Any) -> tuple[NDArray[Any], NDArray[np.float32]]:
        if self._video is not None:
            depth = self._video.decode(Packet(frame.place, frame.begins, depth))
        elif frame.depth == message.DEPTH_EXACT:
            depth = self._depth.decode(depth)
        elif isinstance(depth, DepthCodes):
            depth = depth.numbers()
        if self._colour is not None:
            self._colour.begin(frame.place, frame.begins)
            light = self._colour.decode(colour, frame.place)
            # A video has no coverage: what has no depth was not drawn. Without depth all of it was.
            drawn = np.full(light.shape[:2], True) if frame.depth == message.NONE else depth >= 0
            colour = np.dstack([light, np.where(drawn, 255, 0).astype(np.uint8)])
        return colour, depth
