"""The picture of a headset: Matplotlib draws it."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..headsets import COLOURS, Headset, HeadsetEye
from .charts import drawing, empty_figure, png_of

_DPI = 100
_HEADSET_IN, _ALONE_IN = (11.0, 9.5), (9.0, 6.0)
_EYES = (("left eye", "#0b63c5"), ("right eye", "#c2410c"))
_LIGHT = dict(zip(COLOURS, ("#d11d1d", "#14833b", "#2146d0"), strict=True))
_LINES, _POINTS = 17, 65  # of the lens's grid
_AROUND = 1.15  # of the view, around its grid

Array = NDArray[np.float64]


def headset_plot_png(headset: Headset) -> bytes:
    """Draw both views in angles of the head, with overlap and hidden area, and the lens, as PNG."""
    with drawing((headset.name,)):
        figure = empty_figure(*(_HEADSET_IN if headset.lens is not None else _ALONE_IN), layout="constrained")
        lens = "" if headset.lens is not None else "; no lens"
        about = f"{headset.across_deg:.1f} degrees across, {headset.overlap_deg:.1f} of them with both eyes{lens}"
        figure.suptitle(f"{headset.summary}\n{about}", fontsize=10, x=0.01, ha="left")
        grid = figure.add_gridspec(2 if headset.lens is not None else 1, 2)
        axes = figure.add_subplot(grid[0, :])
        for eye, (name, colour) in zip(headset.eyes, _EYES, strict=False):
            left, right, down, up = eye.fov.tangents.tolist()
            edge = np.array([(left, down), (right, down), (right, up), (left, up), (left, down)])
            axes.fill(*_angles(eye, edge).T, color=colour, alpha=0.18, lw=0)
            axes.plot(*_angles(eye, edge).T, color=colour, lw=1.5, label=name)
            for polygon in eye.hidden.polygons if eye.hidden is not None else ():
                axes.fill(
                    *_angles(eye, np.array([*polygon, polygon[0]])).T, color=colour, alpha=0.35, lw=0, hatch="///"
                )
            axes.plot(*_angles(eye, np.zeros((1, 2))).T, "+", color=colour, ms=10)
        axes.set_aspect("equal")
        axes.grid(alpha=0.3)
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), fontsize=8)
        title = "both views, infinitely far; + where an eye's view looks, hatched what is hidden"
        axes.set(title=title, xlabel="to the right [degrees]", ylabel="up [degrees]")
        across, along = np.linspace(0, 1, _LINES), np.linspace(0, 1, _POINTS)
        for number, eye in enumerate(headset.eyes if headset.lens is not None else ()):
            # A square grid of the panel as each colour of it is seen, as far as the view reaches.
            axes = figure.add_subplot(grid[1, number])
            for (colour, shade), line in product(_LIGHT.items(), across):
                beside = np.full_like(along, line)
                for places in (np.stack([beside, along], 1), np.stack([along, beside], 1)):
                    axes.plot(*headset.through_lens(number, places, colour).T, color=shade, lw=0.7, alpha=0.8)
            left, right, down, up = eye.fov.tangents.tolist()
            edge = np.array([(left, down), (right, down), (right, up), (left, up), (left, down)])
            axes.plot(*edge.T, color="#11161d", lw=1.5)
            title = f"{_EYES[number][0]}: the panel through the lens, by colour; black: the view"
            axes.set(title=title, xlabel="tangent to the right", ylabel="tangent up")
            axes.set(xlim=(_AROUND * left, _AROUND * right), ylim=(_AROUND * down, _AROUND * up))
            axes.set_aspect("equal")
        return png_of(figure, _DPI)


def _angles(eye: HeadsetEye, corners: Array) -> Array:
    """Return (n, 2) azimuth and elevation in the head of a line through tangents (m, 2)."""
    share = np.linspace(0, 1, _POINTS)[:, None]
    parts = [a + share * (b - a) for a, b in zip(corners, corners[1:], strict=False)] or [corners]
    tangents = np.concatenate(parts)
    x, y, z = eye.head_from_eye.rotation_matrix @ np.column_stack([tangents, -np.ones(len(tangents))]).T
    return np.asarray(np.degrees(np.stack([np.arctan2(x, -z), np.arctan2(y, np.hypot(x, z))], axis=1)))
