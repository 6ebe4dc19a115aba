"""The sizes that the pictures of one eye are derived from."""

from __future__ import annotations

import attrs

from ...geometry import Fov

Size = tuple[int, int]


@attrs.frozen
class EyeSizes:
    """What the size of every layer follows from; all sizes are (w, h) in pixels of one eye."""

    # The rendered picture, with its guard band.
    rendered: Size
    # The shown picture.
    shown: Size
    # The shown fields of view, one for each eye; the size of some layers follows from them.
    fovs: tuple[Fov, ...] = ()
