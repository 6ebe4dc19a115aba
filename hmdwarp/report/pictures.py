"""Pictures for people: strips of labelled panels, the error map in colour, and image files.

Pictures are (h, w, 3) uint8 sRGB, top row first.
"""

from __future__ import annotations

import functools
import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import HmdwarpError

Picture = NDArray[np.uint8]
Panel = tuple[str, Picture]

_PAPER, _INK, _GAP = (255, 255, 255), (60, 60, 60), 6


def magma(error_map: NDArray[Any]) -> Picture:
    """Colour an error map as FLIP does, from dark (no error) to bright.

    error_map: (h, w) bytes, or floats 0..1; returns (h, w, 3).
    """
    levels = np.asarray(error_map)
    if levels.dtype != np.uint8:
        levels = np.rint(np.clip(levels, 0, 1) * 255).astype(np.uint8)
    coloured: Picture = _magma_table()[levels]
    return coloured


@functools.cache
def _magma_table() -> Picture:
    from matplotlib import colormaps

    table: Picture = np.rint(np.asarray(colormaps["magma"](np.arange(256)))[:, :3] * 255).astype(np.uint8)
    return table


def comparison_panels(
    rendered: Picture | None, warped: Picture, truth: Picture, error_map: NDArray[Any]
) -> list[Panel]:
    """Return the four panels of every comparison, in this order; without a late picture, three."""
    first = [] if rendered is None else [("late frame", rendered)]
    return [*first, ("warped", warped), ("truth", truth), ("error (FLIP)", magma(error_map))]


def labelled_strip(panels: Sequence[Panel], *, columns: int | None = None) -> Picture:
    """Lay panels side by side (or in rows of `columns`), each with its label above, on white.

    Panels may differ in size: smaller ones are enlarged by repeating pixels, or shrunk, to the
    first one's height.
    Errors: HmdwarpError without any panel.
    """
    from PIL import Image, ImageDraw, ImageFont

    if not panels:
        raise HmdwarpError("a strip of pictures needs at least one panel")
    height = panels[0][1].shape[0]
    images = [_scaled(picture, height) for _, picture in panels]
    columns = columns or len(panels)
    cell = max(image.width for image in images) + _GAP
    text = max(11, round(height / 24), round(columns * cell / 80))  # 10 pixels where the strip is shown 800 wide
    font = ImageFont.load_default(text)
    label = round(text * 1.6)
    rows = -(-len(panels) // columns)
    strip = Image.new("RGB", (columns * cell - _GAP, rows * (label + height + _GAP) - _GAP), _PAPER)
    draw = ImageDraw.Draw(strip)
    for index, ((name, _), image) in enumerate(zip(panels, images, strict=True)):
        x, y = index % columns * cell, index // columns * (label + height + _GAP)
        draw.text((x + 2, y + label / 2), name, fill=_INK, font=font, anchor="lm")
        strip.paste(image, (x, y + label))
    return np.asarray(strip)


def _scaled(picture: Picture, height: int) -> Any:
    from PIL import Image

    image = Image.fromarray(np.ascontiguousarray(picture))
    if image.height == height:
        return image
    width = max(1, round(image.width * height / image.height))
    return image.resize(
        (width, height), Image.Resampling.NEAREST if image.height < height else Image.Resampling.LANCZOS
    )


def png_bytes(picture: NDArray[Any]) -> bytes:
    """Encode a picture, (h, w, 3) or (h, w) uint8, as a PNG file.

    At zlib's quickest level: a quarter of the time of level 6 for 7 % more bytes.
    """
    return _encoded(picture, "PNG", compress_level=1)


def jpeg_bytes(picture: NDArray[Any]) -> bytes:
    """Encode a picture as a JPEG file without chroma subsampling: about a tenth of the PNG."""
    return _encoded(picture, "JPEG", quality=90, subsampling=0)


def _encoded(picture: NDArray[Any], kind: str, **options: object) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(picture, dtype=np.uint8)).save(buffer, kind, **options)
    return buffer.getvalue()
