"""Pictures of a trace and of a headset: Matplotlib draws them."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..headsets import COLOURS, Headset, HeadsetEye
from ..poses import PoseTrack, quaternions
from .charts import drawing, empty_figure, png_of

_SIZE_IN, _DPI = (12.0, 7.5), 100
_MOST_POINTS = 4000
_ARROWS = 40
_GAZE, _CROWN, _LINE = "#c2410c", "#0b63c5", "#2b3440"


def trace_plot_png(track: PoseTrack, axes_said: str) -> bytes:
    """Draw path, height, angles, speeds and view sphere as PNG. axes_said: in the title."""
    at = np.unique(np.linspace(0, len(track) - 1, min(len(track), _MOST_POINTS)).astype(int))
    seconds = (track.time_ns[at] - track.time_ns[0]) * 1e-9
    place, q = track.position_m[at], track.orientation_xyzw[at]
    gaze, crown, right = (quaternions.rotate(q, np.array([v], float)) for v in ((0, 0, -1), (0, 1, 0), (1, 0, 0)))
    with drawing((track.name, axes_said, len(track))):
        figure = empty_figure(*_SIZE_IN, layout="constrained")
        figure.suptitle(f"{track.name}\nfile's axes: {axes_said}", fontsize=10, x=0.01, ha="left")
        grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.25))
        # From above, -z up on the page, with arrows where the head looks.
        axes = figure.add_subplot(grid[:2, 0])
        axes.plot(place[:, 0], -place[:, 2], color=_LINE, lw=1)
        some = np.unique(np.linspace(0, len(place) - 1, _ARROWS).astype(int))
        from_, to = (place[some, 0], -place[some, 2]), (gaze[some, 0], -gaze[some, 2])
        axes.quiver(*from_, *to, color=_GAZE, width=0.004, scale=20, zorder=3)
        axes.plot(*(place[0, [0, 2]] * (1, -1)), "o", color=_LINE, ms=5)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(title="from above: way, and where the head looks (dot: start)", xlabel="x [m]", ylabel="-z [m]")
        # Where gaze and crown point: the crown of an upright head stays at the top.
        axes = figure.add_subplot(grid[2, 0], projection="mollweide")
        for vectors, colour, label in ((gaze, _GAZE, "gaze"), (crown, _CROWN, "crown")):
            azimuth, elevation = np.arctan2(vectors[:, 0], -vectors[:, 2]), np.arcsin(np.clip(vectors[:, 1], -1, 1))
            axes.plot(azimuth, elevation, ".", ms=2, color=colour, label=label)
        axes.grid(True, lw=0.3)
        axes.set_title("view sphere: upright heads have the crown on top")
        axes.tick_params(labelsize=6)
        axes.legend(loc="lower right", markerscale=4, fontsize=7)
        over_time = [figure.add_subplot(grid[row, 1]) for row in range(3)]
        yaw = np.degrees(np.unwrap(np.arctan2(-gaze[:, 0], -gaze[:, 2])))
        pitch = np.degrees(np.arcsin(np.clip(gaze[:, 1], -1, 1)))
        roll = np.degrees(np.arctan2(-right[:, 1], crown[:, 1]))
        for values, colour, label in ((yaw, _LINE, "yaw"), (pitch, _GAZE, "pitch"), (roll, _CROWN, "roll")):
            over_time[0].plot(seconds, values, color=colour, lw=1, label=label)
        over_time[0].set_ylabel("angle [deg]")
        over_time[0].legend(loc="upper right", ncols=3, fontsize=7)
        over_time[1].plot(seconds, place[:, 1], color=_LINE, lw=1)
        over_time[1].set_ylabel("height [m]")
        # Between samples; nothing is drawn over gaps and jumps.
        steps_s = np.diff(track.time_ns) * 1e-9
        whole = ~track.broken & (steps_s > 0)
        some = np.flatnonzero(whole)[:: max(1, int(whole.sum()) // _MOST_POINTS)]
        angle = quaternions.angle_between(track.orientation_xyzw[some], track.orientation_xyzw[some + 1])
        way = np.linalg.norm(track.position_m[some + 1] - track.position_m[some], axis=1)
        since = (track.time_ns[some] - track.time_ns[0]) * 1e-9
        speeds = over_time[2].twinx()
        over_time[2].plot(since, np.degrees(angle) / steps_s[some], color=_LINE, lw=0.7)
        speeds.plot(since, way / steps_s[some], color=_GAZE, lw=0.7)
        over_time[2].set_ylabel("turning [deg/s]")
        speeds.set_ylabel("moving [m/s]", color=_GAZE)
        for axes in over_time:
            steps = np.diff(track.time_ns)
            for i in np.flatnonzero(steps > track.max_gap_ns)[:200]:
                start = (track.time_ns[i] - track.time_ns[0]) * 1e-9
                axes.axvspan(start, start + steps[i] * 1e-9, color="#c3ccd6", lw=0)
            axes.set_xlim(0, max(float(seconds[-1]), 1e-9))
        over_time[2].set_xlabel("time [s], gaps shaded")
        return png_of(figure, _DPI)


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
            for polygon in eye.hidden:
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
