"""A picture of a head trace: enough to see a head that lies on its side or walks backwards."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..poses import PoseTrack, quaternions
from .charts import drawing, empty_figure, png_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SIZE_IN, _DPI = (12.0, 7.5), 100
_MOST_POINTS = 4000
_ARROWS = 40
_GAZE, _CROWN, _LINE = "#c2410c", "#0b63c5", "#2b3440"


def trace_plot_png(track: PoseTrack, axes_said: str) -> bytes:
    """Draw path, height, angles, speeds and view sphere of a track in OpenXR axes, as PNG.

    axes_said: the axes of the file and who says so, for the title.
    """
    at = np.unique(np.linspace(0, len(track) - 1, min(len(track), _MOST_POINTS)).astype(int))
    seconds = (track.time_ns[at] - track.time_ns[0]) * 1e-9
    place, q = track.position_m[at], track.orientation_xyzw[at]
    gaze, crown, right = (quaternions.rotate(q, np.array([v], float)) for v in ((0, 0, -1), (0, 1, 0), (1, 0, 0)))
    with drawing((track.name, axes_said, len(track))):
        figure = empty_figure(*_SIZE_IN, layout="constrained")
        figure.suptitle(f"{track.name}\nfile's axes: {axes_said}", fontsize=10, x=0.01, ha="left")
        grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.25))
        _draw_path(figure.add_subplot(grid[:2, 0]), place, gaze)
        _draw_sphere(figure.add_subplot(grid[2, 0], projection="mollweide"), gaze, crown)
        over_time = [figure.add_subplot(grid[row, 1]) for row in range(3)]
        _draw_angles(over_time[0], seconds, gaze, crown, right)
        over_time[1].plot(seconds, place[:, 1], color=_LINE, lw=1)
        over_time[1].set_ylabel("height [m]")
        _draw_speeds(over_time[2], track)
        for axes in over_time:
            steps = np.diff(track.time_ns)
            for i in np.flatnonzero(steps > track.max_gap_ns)[:200]:
                start = (track.time_ns[i] - track.time_ns[0]) * 1e-9
                axes.axvspan(start, start + steps[i] * 1e-9, color="#c3ccd6", lw=0)
            axes.set_xlim(0, max(float(seconds[-1]), 1e-9))
        over_time[2].set_xlabel("time [s], gaps shaded")
        return png_of(figure, _DPI)


def _draw_path(axes: Axes, place: NDArray[Any], gaze: NDArray[Any]) -> None:
    """Draw the way from above, -z up on the page, with arrows where the head looks."""
    axes.plot(place[:, 0], -place[:, 2], color=_LINE, lw=1)
    some = np.unique(np.linspace(0, len(place) - 1, _ARROWS).astype(int))
    axes.quiver(
        place[some, 0], -place[some, 2], gaze[some, 0], -gaze[some, 2], color=_GAZE, width=0.004, scale=20, zorder=3
    )
    axes.plot(*(place[0, [0, 2]] * (1, -1)), "o", color=_LINE, ms=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(title="from above: way, and where the head looks (dot: start)", xlabel="x [m]", ylabel="-z [m]")


def _draw_sphere(axes: Axes, gaze: NDArray[Any], crown: NDArray[Any]) -> None:
    """Draw where gaze and crown point: the crown of an upright head stays at the top."""
    for vectors, colour, label in ((gaze, _GAZE, "gaze"), (crown, _CROWN, "crown")):
        azimuth, elevation = np.arctan2(vectors[:, 0], -vectors[:, 2]), np.arcsin(np.clip(vectors[:, 1], -1, 1))
        axes.plot(azimuth, elevation, ".", ms=2, color=colour, label=label)
    axes.grid(True, lw=0.3)
    axes.set_title("view sphere: upright heads have the crown on top")
    axes.tick_params(labelsize=6)
    axes.legend(loc="lower right", markerscale=4, fontsize=7)


def _draw_angles(
    axes: Axes, seconds: NDArray[Any], gaze: NDArray[Any], crown: NDArray[Any], right: NDArray[Any]
) -> None:
    yaw = np.degrees(np.unwrap(np.arctan2(-gaze[:, 0], -gaze[:, 2])))
    pitch = np.degrees(np.arcsin(np.clip(gaze[:, 1], -1, 1)))
    roll = np.degrees(np.arctan2(-right[:, 1], crown[:, 1]))
    for values, colour, label in ((yaw, _LINE, "yaw"), (pitch, _GAZE, "pitch"), (roll, _CROWN, "roll")):
        axes.plot(seconds, values, color=colour, lw=1, label=label)
    axes.set_ylabel("angle [deg]")
    axes.legend(loc="upper right", ncols=3, fontsize=7)


def _draw_speeds(axes: Axes, track: PoseTrack) -> None:
    """Draw turning and moving speeds between samples; nothing is drawn over gaps and jumps."""
    seconds = np.diff(track.time_ns) * 1e-9
    whole = ~track.broken & (seconds > 0)
    at = np.flatnonzero(whole)[:: max(1, int(whole.sum()) // _MOST_POINTS)]
    angle = quaternions.angle_between(track.orientation_xyzw[at], track.orientation_xyzw[at + 1])
    way = np.linalg.norm(track.position_m[at + 1] - track.position_m[at], axis=1)
    since = (track.time_ns[at] - track.time_ns[0]) * 1e-9
    axes.plot(since, np.degrees(angle) / seconds[at], color=_LINE, lw=0.7)
    axes.set_ylabel("turning [deg/s]")
    speeds = axes.twinx()
    speeds.plot(since, way / seconds[at], color=_GAZE, lw=0.7)
    speeds.set_ylabel("moving [m/s]", color=_GAZE)
