"""Twin of a warp that looks through the lens itself. The lens's ray for each colour of each panel
pixel, handed to the warp's own twin."""

from __future__ import annotations

import attrs
import numpy as np

from hmdwarp.geometry import Fov, View
from hmdwarp.headsets import COLOURS, Headset
from reference._rays import FLOAT32_UNIT, Array, Places
from reference.lens import tangent_from_lens
from reference.picture import ReferencePicture, TwinInputs, near_edge
from reference.scanout import Twin, scanned_out


def fused(
    inputs: TwinInputs, twin: Twin, headset: Headset, eye: int, panel_size: tuple[int, int], last: View | None = None
) -> ReferencePicture:
    """The panel picture (h, w, 4) that `twin`'s warp makes in one resample.

    Black where the lens shows more than the shown view.

    last: the view of the panel's last row, if rows light up one after the other. tolerance is that
    of the worst of the three colours; undecided is a pixel of which any colour is.
    """
    out = np.zeros((*panel_size[::-1], 4))
    tolerance, undecided = np.zeros(panel_size[::-1]), np.zeros(panel_size[::-1], bool)
    for channel, colour in enumerate(COLOURS):
        pixels, error = looked_at(headset, eye, panel_size, inputs.shown.fov, inputs.shown_size, colour)
        # One more product and addition than for a pixel centre, and a map at the lens's axis: 4
        # more units of the same terms.
        looking = attrs.evolve(inputs, places=Places(pixels, error, rounding=1.5))
        seen = twin(looking) if last is None else scanned_out(looking, last, twin)
        inside = ((pixels >= 0) & (pixels < np.array(inputs.shown_size))).all(axis=-1)
        close = near_edge(pixels, inputs.shown_size, error)
        for target in (channel, 3) if colour == "green" else (channel,):
            out[..., target] = np.where(inside, seen.colour[..., target], 0)
        tolerance = np.maximum(tolerance, seen.tolerance)
        undecided |= (seen.undecided & inside) | close
    return ReferencePicture(out, tolerance, undecided)


def looked_at(
    headset: Headset, eye: int, panel_size: tuple[int, int], fov: Fov, shown_size: tuple[int, int], colour: str
) -> tuple[Array, Array]:
    """(h, w, 2) the pixel of the shown view where each panel pixel sees that colour, in polar form.

    (h, w) a float32 shader's error.

    A place on the lens is a product and a sum of rounded numbers (4 units of their absolute
    values); nine Horner steps and their products are 2 * 9 + 4 units of the polynomial's absolute
    terms, and carry the place's error by its slope; the steps to pixels add 6 units of their terms.
    """
    lens = headset.lens
    scale, offset = headset.lens_from_panel(eye, panel_size)
    panel = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in panel_size)), axis=-1)
    on_lens = panel * scale + offset
    radius, angle = np.hypot(on_lens[..., 0], on_lens[..., 1]), np.arctan2(on_lens[..., 1], on_lens[..., 0])
    along = tangent_from_lens(lens, np.stack([radius, np.zeros_like(radius)], axis=-1), colour)[..., 0]
    tangent = np.stack([along * np.cos(angle), along * np.sin(angle)], axis=-1)
    left, right, down, up = fov.tangents
    low, per_tangent = np.array([left, down]), np.array(shown_size) / np.array([right - left, up - down])

    k = np.abs(lens.coefficients[colour]) * lens.tangent_per_unit
    powers = radius[..., None] ** (2 * np.arange(len(k)))
    place_error = 4 * FLOAT32_UNIT * (np.abs(panel * scale) + np.abs(offset)).max(axis=-1)
    slope = powers @ (k * (2 * np.arange(len(k)) + 1))
    tangent_error = 2 * slope * place_error + 22 * FLOAT32_UNIT * radius * (powers @ k)
    error = tangent_error[..., None] * per_tangent + 6 * FLOAT32_UNIT * (np.abs(tangent) + np.abs(low)) * per_tangent
    return (tangent - low) * per_tangent, error.max(axis=-1)
