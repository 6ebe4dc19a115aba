"""Recorded frames in the place of a scene: what is loaded, and the display that belongs to it."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import attrs
import numpy as np

from ..errors import InputError
from ..geometry import Fov, GuardBand
from ..headsets import CameraDisplay, Headset, camera_display, load_headset
from ..scenes import Scene, load_scene
from ..sources.repairs import parse_repairs

if TYPE_CHECKING:
    from ..sources.sequences import Sequence
    from .options import PipelineOptions

Size = tuple[int, int]
Options = TypeVar("Options", bound="PipelineOptions")
_SAME_FOV = 1e-6  # rad, far below a pixel
LEAST_SHOWN = 16  # pixels on each side that a guard band must leave


@attrs.frozen(eq=False, slots=False)
class RecordedScene(Scene):
    """A scene of a recording's name, without anything in it."""

    sequence: Sequence = attrs.field(kw_only=True)


def recorded_scene(sequence: Sequence) -> RecordedScene:
    """Return what stands for the recording where a scene is expected."""
    everywhere = np.array([[-np.inf] * 3, [np.inf] * 3])
    return RecordedScene(
        sequence.name,
        f"recorded frames ({sequence.layout})",
        (),
        viewpoint=sequence.frames[0].pose,
        walk_bounds_m=everywhere,
        notes=sequence.notes,
        sequence=sequence,
    )


def scene_of(options: PipelineOptions) -> Scene:
    """Return the scene of the options, or what stands for their recorded frames.

    Errors: as load_scene, and as sequences.open.
    """
    if options.frames is None:
        return load_scene(options.scene, options.scene_options)
    from ..sources import sequences

    opened = sequences.open(options.frames, options.sequence_options)
    return recorded_scene(opened.repaired(parse_repairs(options.repair)))


def headset_of(options: PipelineOptions, scene: Scene) -> Headset:
    """Return the headset of the options, or the display that shows their recorded frames."""
    if isinstance(scene, RecordedScene):
        return display_of(scene.sequence, options.guard_factors, options.eye_distance_mm * 1e-3)
    return load_headset(options.headset)


def display_of(sequence: Sequence, guard: GuardBand | None = None, eye_distance_m: float = 0.0) -> CameraDisplay:
    """Return a display that shows what the camera sees.

    guard: shows the middle of it alone, so that the rest is a guard band. eye_distance_m: how far a
    right eye sits beside the camera; 0 for none.
    Errors: InputError for frames of several fields of view, and for a guard that leaves next to
    nothing.
    """
    first = sequence.frames[0]
    for frame in sequence.frames:
        if np.abs(np.subtract(frame.fov.tangents, first.fov.tangents)).max() > _SAME_FOV:
            raise InputError(
                f"{sequence.path}: {first.name} and {frame.name} have different fields of view: expected one for all, "
                "as the display has; replay those of each camera by themselves"
            )
    fov, size = _middle_of(first.fov, first.size, guard or GuardBand())
    return camera_display(str(sequence.path), fov, size, sequence.rate_hz or 1.0, eye_distance_m)


def _middle_of(fov: Fov, size: Size, guard: GuardBand) -> tuple[Fov, Size]:
    """Return the part of a field of view that a guard band leaves, in whole pixels."""
    tangents, kept, sides = fov.tangents, [], []
    for axis, factor in enumerate((guard.x, guard.y)):
        low, high = tangents[2 * axis : 2 * axis + 2]
        left = round(size[axis] / factor)
        if left < min(LEAST_SHOWN, size[axis]):
            raise InputError(
                f"{guard} leaves {left} of the {size[axis]} recorded pixels on one axis: expected at least "
                f"{LEAST_SHOWN}; use a smaller guard"
            )
        # As much to either side of the camera's axis as the guard band says.
        before = round((size[axis] - left) * abs(low) / (abs(low) + abs(high)))
        per_pixel = (high - low) / size[axis]
        kept.append(left)
        sides += [low + before * per_pixel, low + (before + left) * per_pixel]
    return (fov, size) if tuple(kept) == size else (Fov.from_tangents(sides), (kept[0], kept[1]))


def fitted(options: Options, scene: Scene) -> Options:
    """Return the options with the sizes that recorded frames give them.

    The shown picture has as many pixels as that part of the recording, or those of --size; late
    frames have those of all that was recorded, at the same scale. Others are unchanged.
    """
    if not isinstance(scene, RecordedScene):
        return options
    (wide, high), shown = scene.sequence.frames[0].size, headset_of(options, scene).eye_size_px
    size = options.size or shown
    rendered = (round(wide * size[0] / shown[0]), round(high * size[1] / shown[1]))
    return attrs.evolve(options, size=size, rendered_size=None if rendered == size else rendered)
