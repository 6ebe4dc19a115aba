"""Twin of the environment warp. Each shown ray, projected onto the face it comes nearest to the
axis of."""

from __future__ import annotations

import numpy as np

from hmdwarp.geometry import View, face_views
from hmdwarp.geometry.cube import FACES
from reference._rays import FLOAT32_UNIT, Array, Places, pixel_centres, project
from reference.picture import ReferencePicture, TwinInputs, sample_covered


def environment(inputs: TwinInputs) -> ReferencePicture:
    """Every face looked into as a picture of its own view. Each ray takes the face whose axis it is
    nearest to. Rays that rounding may put on either of two faces are undecided."""
    side = inputs.cube.shape[1] // 3
    rays = inputs.directions(inputs.shown)
    views = face_views(View(inputs.rendered.pose, inputs.shown.fov), side)
    ahead = np.stack([rays @ view.pose.rotation.as_matrix()[:, 2] * -1 for view in views])
    error = direction_error(inputs)
    chosen, order = ahead.argmax(axis=0), np.sort(ahead, axis=0)
    out = np.zeros((*inputs.shape, 4))
    tolerance = np.zeros(inputs.shape)
    undecided = order[-1] - order[-2] <= 2 * error
    for index, (face, view) in enumerate(zip(FACES, views, strict=True)):
        picture = inputs.cube[face.row * side : (face.row + 1) * side, face.column * side : (face.column + 1) * side]
        pixels, _, _ = project(rays, np.zeros(3), np.zeros(rays.shape[:2]), view, (side, side))
        # The quotient of two coordinates, each off by `error`, the larger at least 1 / sqrt(3) of
        # the ray, times half a face; and the place itself, counted from the corner of the picture,
        # is rounded three times.
        bound = side * error / order[-1] + 3 * FLOAT32_UNIT * 3 * side
        here = chosen == index
        looked = sample_covered(picture, np.where(here[..., None], pixels, np.nan), bound, inputs.sampler_pixels)
        out[here], tolerance[here] = looked.colour[here], looked.tolerance[here]
        undecided |= looked.undecided & here
    return ReferencePicture(out, tolerance, undecided)


def direction_error(inputs: TwinInputs) -> Array:
    """(h, w): how far each coordinate of the shader's direction may be off. 8 u of the sum of its
    terms, as in pixel_error_bound."""
    shown, rendered, size = inputs.shown, inputs.rendered, inputs.shown_size
    turn = np.abs(rendered.pose.rotation.as_matrix().T @ shown.pose.rotation.as_matrix())
    to_tangent = np.abs(np.linalg.inv(shown.fov.pixel_from_tangent(size)))
    places = inputs.places or Places(pixel_centres(size))
    p = np.concatenate([places.pixels, np.ones((*places.pixels.shape[:-1], 1))], axis=-1)
    terms = 8 * places.rounding * FLOAT32_UNIT * (p @ (turn @ to_tangent).T).max(axis=-1)
    return terms + places.error * (turn @ to_tangent)[:, :2].sum(axis=-1).max()
