"""H.264 video of a run, through PyAV.

The encoder depends on PyAV's own build: libopenh264 (BSD licence), else libx264 (GPL-2.0-or-later:
it is in PyAV's own wheels, hmdwarp neither contains nor links it). What a distribution of hmdwarp
together with PyAV must observe follows from the one that PyAV brings.
"""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import HmdwarpError, InputError, MachineError
from ..resources import pyav
from .files import Partial, write_error

# Either is in PyAV's wheels; 18: no difference to be seen at normal distance.
ENCODERS = {
    "libopenh264": {"rc_mode": "quality", "qmin": "10", "qmax": "24"},
    "libx264": {"crf": "18", "preset": "veryfast"},
}
_BT709, _LIMITED = 1, 1  # the same number in FFmpeg's colour space, primaries and transfer enumerations; range "tv"


def encoder_name() -> str:
    """Return the H.264 encoder of this PyAV. Errors: MachineError without one."""
    av = pyav()
    found = [name for name in ENCODERS if name in av.codecs_available]
    if not found:
        what = "cannot write a video: it was built without libopenh264 and libx264"
        raise MachineError(f"PyAV {av.__version__} {what}; install PyAV from its wheel (pip install av)")
    return found[0]


class VideoWriter:
    """A writer of sRGB pictures to an H.264 mp4 that players and browsers show in true colours.

        with VideoWriter(path, (w, h), 90) as video:
            video.add(picture)

    size: (w, h) of the pictures; odd sides are padded by repeating the last row or column. rate:
    pictures per second. The file is BT.709, limited range, 4:2:0, and says so in its tags: colours
    of single pixels blur. It gets its name by close(); abort(), an exception in the block, or
    close() before the first picture leaves nothing.

    Errors: MachineError if PyAV has no H.264 encoder, or the disk is full; InputError
    for a place that cannot be written, a size below 16 or a rate beyond 0..1000; HmdwarpError for a
    picture of another size.
    """

    def __init__(self, path: str | os.PathLike[str], size: tuple[int, int], rate: float) -> None:
        av = self._av = pyav()
        self.path, self.size = Path(path), size
        if min(size) < 16 or not 0 < rate <= 1000:
            found = f"video of {size[0]}x{size[1]} at {rate:g} pictures per second"
            raise InputError(f"{found}: expected at least 16x16 and a rate above 0, at most 1000")
        name, frames_s = encoder_name(), Fraction(rate).limit_denominator(1001)
        self.frames = 0
        self._open = True
        try:
            self._partial = Partial.of(self.path)
        except OSError as error:
            raise write_error(error, self.path) from error
        try:
            self._container = av.open(str(self._partial.path), "w", format="mp4", options={"movflags": "faststart"})
        except (OSError, av.FFmpegError) as error:
            self._partial.close()
            raise _video_error(error, self.path) from error
        try:
            self._stream = self._container.add_stream(name, rate=frames_s)
            context = self._stream.codec_context
            context.width, context.height = size[0] + size[0] % 2, size[1] + size[1] % 2
            context.pix_fmt, context.options = "yuv420p", dict(ENCODERS[name])
            context.framerate, context.time_base = frames_s, 1 / frames_s
            context.color_range = _LIMITED
            context.colorspace = context.color_primaries = context.color_trc = _BT709
            context.open()
        except BaseException as error:
            self.abort()
            if isinstance(error, OSError | ValueError | av.FFmpegError):
                raise _video_error(error, self.path) from error
            raise
        self.encoder: str = name

    def add(self, picture: NDArray[np.uint8]) -> None:
        from av.video.reformatter import ColorRange, Colorspace

        if not self._open:
            raise HmdwarpError(f"{self.path.name} is closed: pictures go in before close()")
        width, height = self.size
        if picture.shape != (height, width, 3) or picture.dtype != np.uint8:
            raise HmdwarpError(
                f"a {picture.dtype} picture of shape {picture.shape} for a video of {(height, width, 3)} uint8"
            )
        even = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        spaces = {"src_colorspace": Colorspace.ITU709, "dst_colorspace": Colorspace.ITU709}
        ranges = {"src_color_range": ColorRange.JPEG, "dst_color_range": ColorRange.MPEG}
        given = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(even), format="rgb24")
        frame = given.reformat(format="yuv420p", **spaces, **ranges)
        frame.pts = self.frames
        frame.time_base = self._stream.codec_context.time_base
        self._mux(frame)
        self.frames += 1

    def close(self) -> None:
        """Finish the file and name it; without pictures, delete it. May be called again."""
        if not self._open:
            return
        if self.frames == 0:
            self.abort()
            return
        try:
            self._mux(None)
            self._open = False
            self._container.close()
            self._partial.path.replace(self.path)
            self._partial.close()
        except BaseException as error:
            self.abort()
            if isinstance(error, OSError):
                raise _video_error(error, self.path) from error
            raise

    def abort(self) -> None:
        """Stop and delete the partial file. May be called again."""
        self._open = False
        try:
            self._container.close()
        except (OSError, self._av.FFmpegError):
            pass  # a file that is deleted next need not be finished
        finally:
            self._partial.close()

    def _mux(self, frame: Any) -> None:
        try:
            for packet in self._stream.encode(frame):
                self._container.mux(packet)
        except (OSError, self._av.FFmpegError) as error:
            self.abort()
            raise _video_error(error, self.path) from error

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()


def _video_error(error: Exception, path: Path) -> HmdwarpError:
    if isinstance(error, OSError) and error.errno is not None:
        return write_error(error, path)
    return MachineError(f"{path}: the video encoder failed ({error})")
