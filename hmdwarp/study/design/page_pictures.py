"""Pictures of a study's pages."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import InputError

if TYPE_CHECKING:
    from PIL.Image import Image

ENDINGS = (".png", ".jpg", ".jpeg")


def open_picture(path: Path | str) -> Image:
    """Load a picture, RGBA. Errors: InputError for a file that is none."""
    from PIL import Image

    try:
        with Image.open(path) as file:
            return file.convert("RGBA")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise InputError(f"no picture ({error}): expected a PNG or JPEG file") from error
