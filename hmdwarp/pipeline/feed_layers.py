"""Further layers of the feed: what clients ask for; textures to parts of a message, and back."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..frames import EyeImage, EyeSizes, Needs
from ..frames.layers import OWN, Layer, layers
from ..geometry import View
from ..gpu.textures import COLOUR, NUMBER, SCALAR, download, upload
from ..link.codec import Undecodable
from ..sources.feed import bounds
from ..sources.feed.message import FrameMessage
from ..sources.feed.parts import BadPart, Layers, Packed, Wanted, packed, unpacked_bytes
from ..sources.server import Renderer
from .motion_vectors import velocity_of

Array = NDArray[Any]
_KINDS = {"rgba16f": COLOUR, "r32f": SCALAR, "r16ui": NUMBER}
VELOCITY = "velocity"
# In m, m/s and rad/s: what moves is multiplied by its age and stays a number.
_LARGEST = 1e6
_MOST_TABLE = 1 << 20  # bytes of a layer besides its pictures


def fed(needs: Needs) -> list[str]:
    """Return the needed layers that a server sends; others are the client's or absent."""
    return [name for name in needs if layers.get(name).fed]


def wanted_of(needs: Needs, views: Sequence[View], shown_size: tuple[int, int]) -> Wanted | None:
    """Return what to ask a server for. views: as shown."""
    amounts = tuple((name, _number_of(needs[name])) for name in fed(needs))
    return Wanted(amounts, shown_size, tuple(view.fov for view in views)) if amounts else None


def _number_of(amount: Any) -> int:
    return amount.value if isinstance(amount, enum.Flag) else int(amount)


def needs_of_client(wanted: Wanted | None) -> Needs:
    """Return what a client wants. Errors: InputError for a layer that frames cannot carry."""
    found: dict[str, Any] = {}
    for name, number in wanted.layers if wanted is not None else ():
        if name not in layers.names() or not layers.get(name).fed:
            raise InputError(f"there is no layer '{name}' here")
        try:
            found[name] = type(layers.get(name).something)(number)
        except ValueError:  # its text has several lines
            found[name] = 0
        if _number_of(found[name]) != number:
            raise InputError(f"there is no {number} of layer '{name}': docs/feed.md says how much there is")
    return Needs(**found)


def sizes_of(wanted: Wanted, size: tuple[int, int]) -> EyeSizes:
    """Return what the sizes of layers follow from. size: of the rendered picture."""
    return EyeSizes(size, wanted.size, wanted.fovs)


def parts_of(eye: EyeImage, needs: Needs, *, packs: bool) -> Layers:
    """Return the needed layers of one eye as arrays. packs: without loss, for a slow network."""
    found: dict[str, list[Array | Packed]] = {}
    for name in needs:
        layer, numbers = layers.get(name), layers.get(name).numbers(eye[name])
        drawn = [picture if isinstance(picture, np.ndarray) else download(picture) for picture in layer.sent(eye[name])]
        found[name] = [packed(picture) for picture in drawn] if packs else [*drawn]
        if numbers is not None:
            found[name].append(numbers)
    return found


def unpacked(frame: FrameMessage) -> FrameMessage:
    """Return the frame with numbers in place of packed parts, and velocities of motion vectors.

    Its depth must be decoded. Errors: Undecodable.
    """
    if not frame.layers:
        return frame
    try:
        found = tuple(
            {
                name: [part.numbers() if isinstance(part, Packed) else part for part in parts]
                for name, parts in of_eye.items()
            }
            for of_eye in frame.layers
        )
        for of_eye, view, depth in zip(found, frame.views, frame.inverse_depths, strict=True):
            if len(of_eye.get(VELOCITY, ())) > 1:
                if isinstance(depth, bytes):
                    raise InputError("motion vectors without depth")
                of_eye[VELOCITY] = [velocity_of(of_eye[VELOCITY], view, depth)]
    except (BadPart, InputError) as error:
        raise Undecodable(str(error)) from error
    return attrs.evolve(frame, layers=found)


def wanted_alone(frame: FrameMessage, wanted: Wanted | None) -> FrameMessage:
    """Return the frame with the requested layers alone: others are never unpacked.

    Errors: Undecodable where one claims to be larger than requested.
    """
    names = {} if wanted is None else dict(wanted.layers)
    found = tuple({name: of_eye[name] for name in of_eye if name in names} for of_eye in frame.layers)
    for of_eye in found:
        for name, parts in of_eye.items():
            assert wanted is not None
            layer, sizes = layers.get(name), sizes_of(wanted, frame.size)
            most = bounds.most_beside(frame.size) if layer.size_class == OWN else layer.bytes(names[name], sizes)
            if unpacked_bytes([{name: parts}]) > most + _MOST_TABLE:
                raise Undecodable(f"layer '{name}' claims to be larger than requested")
    return attrs.evolve(frame, layers=found)


def misfit(frame: FrameMessage, wanted: Wanted | None) -> str:
    """Return why a frame's layers are not the requested ones, "" if they are."""
    if wanted is None:
        return ""
    sizes = sizes_of(wanted, frame.size)
    for of_eye in frame.layers or ({},) * len(frame.views):
        for name, number in wanted.layers:
            if name not in of_eye:
                return f"the server sends no layer '{name}'"
            wrong = _misfit_of(layers.get(name), number, list(of_eye[name]), sizes)
            if wrong:
                return f"layer '{name}' of the server: {wrong}"
    return ""


def _misfit_of(layer: type[Layer], number: int, parts: list[Any], sizes: EyeSizes) -> str:
    formats = layer.pictures(number)
    pictures, numbers = parts[: len(formats)], parts[len(formats) :]
    if len(pictures) < len(formats) or len(numbers) > 1:
        return f"{len(parts)} parts: expected {len(formats)} pictures"
    for one, form in zip(pictures, formats, strict=True):
        channels, dtype = _KINDS[form]
        wide, high = one.shape[1::-1] if layer.size_class == OWN else layer.size(sizes)
        shape = (high, wide, channels) if channels > 1 else (high, wide)
        if layer.size_class == OWN and one.nbytes > bounds.most_beside(sizes.rendered):
            return f"{wide}x{high} pixels beside {sizes.rendered[0]}x{sizes.rendered[1]}: too many"
        if one.shape != shape or one.dtype != np.dtype(dtype):
            return f"{one.dtype} of shape {one.shape}: expected {np.dtype(dtype)} of {shape}"
        if one.dtype.kind == "f" and not np.isfinite(one).all():
            return "numbers that are not finite"
    if numbers and (numbers[0].dtype != np.float64 or not (np.abs(numbers[0]) <= _LARGEST).all()):
        return f"numbers beside its pictures: expected f64 of {_LARGEST:g} at most"
    return layer.misfit(pictures, numbers[0] if numbers else None)


def made(server: Renderer, parts: Layers, wanted: Wanted | None) -> dict[str, Any]:
    """Return the data of the wanted layers of one eye, in textures of the server's pools."""
    return {name: _made(server, layers.get(name), number, parts[name]) for name, number in _of(wanted)}


def _of(wanted: Wanted | None) -> tuple[tuple[str, int], ...]:
    return () if wanted is None else wanted.layers


def _made(server: Renderer, layer: type[Layer], number: int, parts: Sequence[Any]) -> Any:
    formats, textures = layer.pictures(number), []
    for one, form in zip(parts, formats, strict=False):
        textures.append(server.acquire(one.shape[1::-1], _KINDS[form], depth=False).colour)
        upload(textures[-1], one)
    return layer.made(textures, parts[-1] if len(parts) > len(formats) else None)
