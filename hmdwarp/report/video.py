"""H.264 video of a run, through PyAV.

The encoder depends on PyAV's own build: libopenh264 (BSD licence), else libx264 (GPL-2.0-or-later:
it is in PyAV's own wheels, hmdwarp neither contains nor links it). What a distribution of hmdwarp
together with PyAV must observe follows from the one that PyAV brings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import HmdwarpError, InputError, MachineError, pyav
from .files import write_error

# Either is in PyAV's wheels; 18: no difference to be seen at normal distance.
ENCODERS = {
    "libopenh264": {"rc_mode": "quality", "qmin": "10", "qmax": "24"},
    "libx264": {"crf": "18", "preset": "veryfast"},
}
_BT709, _LIMITED = 1, 1  # the same number in FFmpeg's colour space, primaries and transfer enumerations; range "tv"


@contextmanager
def open_video(path: Path, size: tuple[int, int], rate: float) -> Iterator[Callable[[NDArray[np.uint8]], None]]:
    """Write sRGB pictures to an H.264 mp4 that players and browsers show in true colours.

        with open_video(out.path("replay.mp4"), (w, h), 90) as add:
            add(picture)

    path: in an OutputFolder, which leaves nothing of it after a failure. size: (w, h) of the
    pictures; odd sides are padded by repeating the last row or column. rate: pictures per second.
    The file is BT.709, limited range, 4:2:0, and says so in its tags: single pixels' colours blur.
    Errors: MachineError if PyAV has no H.264 encoder, or the disk is full; InputError for a place
    that cannot be written, a size below 16 or a rate beyond 0..1000; HmdwarpError for a picture of
    another size.
    """
    av, (width, height) = pyav(), size
    if min(size) < 16 or not 0 < rate <= 1000:
        found = f"video of {width}x{height} at {rate:g} pictures per second"
        raise InputError(f"{found}: expected at least 16x16 and a rate above 0, at most 1000")
    name = next((name for name in ENCODERS if name in av.codecs_available), None)
    if name is None:
        what = "cannot write a video: it was built without libopenh264 and libx264"
        raise MachineError(f"PyAV {av.__version__} {what}; install PyAV from its wheel (pip install av)")

    with _failing(path, av):
        container = av.open(str(path), "w", format="mp4", options={"movflags": "faststart"})
    try:
        with _failing(path, av):
            frames_s = Fraction(rate).limit_denominator(1001)
            stream = container.add_stream(name, rate=frames_s)
            context = stream.codec_context
            context.width, context.height = width + width % 2, height + height % 2
            context.pix_fmt, context.options = "yuv420p", dict(ENCODERS[name])
            context.framerate, context.time_base = frames_s, 1 / frames_s
            context.color_range = _LIMITED
            context.colorspace = context.color_primaries = context.color_trc = _BT709
            context.open()
        from av.video.reformatter import ColorRange, Colorspace

        spaces = {"src_colorspace": Colorspace.ITU709, "dst_colorspace": Colorspace.ITU709}
        ranges = {"src_color_range": ColorRange.JPEG, "dst_color_range": ColorRange.MPEG}
        count = 0

        def encode(frame: Any) -> None:
            with _failing(path, av):
                for packet in stream.encode(frame):
                    container.mux(packet)

        def add(picture: NDArray[np.uint8]) -> None:
            nonlocal count
            if picture.shape != (height, width, 3) or picture.dtype != np.uint8:
                raise HmdwarpError(
                    f"a {picture.dtype} picture of shape {picture.shape} for a video of {(height, width, 3)} uint8"
                )
            even = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
            given = av.VideoFrame.from_ndarray(np.ascontiguousarray(even), format="rgb24")
            frame = given.reformat(format="yuv420p", **spaces, **ranges)
            frame.pts, frame.time_base = count, context.time_base
            encode(frame)
            count += 1

        yield add
        encode(None)
    except BaseException:
        with suppress(OSError, av.FFmpegError):
            container.close()
        raise
    with _failing(path, av):
        container.close()


@contextmanager
def _failing(path: Path, av: Any) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError, av.FFmpegError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise write_error(error, path) from error
        raise MachineError(f"{path}: the video encoder failed ({error})") from error
