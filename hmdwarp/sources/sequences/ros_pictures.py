"""Pictures in messages of ROS: colour and depth, raw or compressed."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError

# Bytes a pixel, and which of its channels are red, green and blue.
COLOURS = {
    "rgb8": (3, (0, 1, 2)),
    "bgr8": (3, (2, 1, 0)),
    "8UC3": (3, (2, 1, 0)),
    "rgba8": (4, (0, 1, 2)),
    "bgra8": (4, (2, 1, 0)),
    "8UC4": (4, (2, 1, 0)),
    "mono8": (1, (0, 0, 0)),
    "8UC1": (1, (0, 0, 0)),
}
# Type and metres per unit.
DEPTHS = {"16UC1": ("u2", 0.001), "mono16": ("u2", 0.001), "32FC1": ("f4", 1.0)}
_COMPRESSED_DEPTH = "compressedDepth"
_HEADER = 12  # bytes before the PNG of a compressed depth


def encoding_of(message: Any) -> str:
    """Return a name of COLOURS or DEPTHS, or "" for what is none that can be read.

    Compressed colour is of "rgb8"; compressed depth of its own encoding.
    """
    if hasattr(message, "encoding"):
        return str(message.encoding) if message.encoding in {*COLOURS, *DEPTHS} else ""
    encoding = str(message.format).partition(";")[0].strip()
    if encoding in DEPTHS:
        return encoding
    if _COMPRESSED_DEPTH in message.format:
        return "16UC1"
    return "rgb8" if any(word in message.format for word in ("jpeg", "jpg", "png")) else ""


def pixels_of(where: str, message: Any) -> NDArray[Any]:
    """Return (h, w, 3) uint8 sRGB, or (h, w) depth in its own unit. Errors: InputError."""
    encoding = encoding_of(message)
    if not encoding:
        found = getattr(message, "encoding", None) or message.format
        raise InputError(f"{where}: pictures of {found}; expected {', '.join([*COLOURS, *DEPTHS])}, JPEG or PNG")
    if not hasattr(message, "encoding"):
        return _decompressed(where, message, encoding)
    count, channels = COLOURS.get(encoding, (0, ()))
    kind = np.dtype("u1" if count else DEPTHS[encoding][0]).newbyteorder(">" if message.is_bigendian else "<")
    width = message.width * max(count, 1) * kind.itemsize
    data = np.asarray(message.data, np.uint8)
    if message.step < width or len(data) < message.step * message.height:
        raise InputError(
            f"{where}: {len(data)} bytes in rows of {message.step}; expected {message.width}x{message.height} pixels "
            f"of {encoding}"
        )
    rows = data[: message.step * message.height].reshape(message.height, message.step)[:, :width]
    values = np.ascontiguousarray(rows).view(kind)
    if not count:
        return values.astype(kind.newbyteorder("="))
    return values.reshape(message.height, message.width, count)[..., list(channels)]


def _decompressed(where: str, message: Any, encoding: str) -> NDArray[Any]:
    from PIL import Image

    data = bytes(np.asarray(message.data, np.uint8))
    if encoding in DEPTHS and _COMPRESSED_DEPTH in message.format:
        data = data[_HEADER:]
        if DEPTHS[encoding][0] != "u2":
            raise InputError(f"{where}: compressed depth of {encoding}; expected 16UC1, which is not quantised")
    try:
        with Image.open(io.BytesIO(data)) as picture:
            return np.asarray(picture if encoding in DEPTHS else picture.convert("RGB"))
    except (OSError, ValueError, SyntaxError) as error:
        raise InputError(f"{where}: a picture that cannot be read ({error}); expected JPEG or PNG") from error
