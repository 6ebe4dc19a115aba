"""A camera in the place of a headset: the eyes see what it sees."""

from __future__ import annotations

import attrs

from ..geometry import Fov
from ._model import Headset

NAME = "camera"


@attrs.frozen
class CameraDisplay(Headset):
    """The display of a camera's frames.

    The head and the left eye are where the camera is. A right eye sits ipd_m beside it, with the
    same field of view; for 0 there is none.
    """

    def fov(self, eye: int) -> Fov:
        """Return the field of view, the same for all eyes."""
        return self.left_fov

    @property
    def places_m(self) -> tuple[float, ...]:
        """How far each eye sits to the right of the camera."""
        return (0.0, self.ipd_m) if self.ipd_m else (0.0,)

    @property
    def flat_view(self) -> tuple[Fov, float]:
        """The camera's own view."""
        return self.left_fov, self.eye_size_m[0] / self.eye_size_m[1]


def camera_display(
    source: str, fov: Fov, size: tuple[int, int], refresh_hz: float, eye_distance_m: float = 0.0
) -> CameraDisplay:
    """Return the display of a camera. source: what recorded it; size: (w, h) of its pictures."""
    panel_m = (0.1, 0.1 * size[1] / size[0])
    return CameraDisplay(NAME, f"the camera of {source}", source, size, panel_m, refresh_hz, eye_distance_m, fov, None)
