"""H.264 video of a run, through PyAV.

The encoder depends on PyAV's own build: libopenh264 (BSD licence), else libx264 (GPL-2.0-or-later:
it is in PyAV's own wheels, hmdwarp neither contains nor links it), else a graphics card's. What a
distribution of hmdwarp together with PyAV must observe follows from the one that PyAV brings.
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

_BY_CARDS = ("h264_nvenc", "h264_qsv", "h264_amf", "h264_videotoolbox", "h264_vaapi", "h264_v4l2m2m")
ENCODERS = ("libopenh264", "libx264", *_BY_CARDS)
_OPTIONS = {
    "libx264": {"crf": "18", "preset": "veryfast"},  # 18: no difference to be seen at normal distance
    "libopenh264": {"rc_mode": "quality", "qmin": "10", "qmax": "24"},
    "h264_nvenc": {"rc": "constqp", "qp": "18"},
}
_BT709, _LIMITED = 1, 1  # the same number in FFmpeg's colour space, primaries and transfer enumerations; range "tv"


def available_encoders() -> list[str]:
    """Return the H.264 encoders of this PyAV, the preferred first; a card's may refuse to open."""
    av = pyav()

    def can_encode(name: str) -> bool:
        try:
            av.Codec(name, "w")
        except (ValueError, av.FFmpegError):  # it decodes only
            return False
        return True

    return [name for name in ENCODERS if name in av.codecs_available and can_encode(name)]


class VideoWriter:
    """A writer of sRGB pictures to an H.264 mp4 that players and browsers show in true colours.

        with VideoWriter(path, (w, h), 90) as video:
            video.add(picture)

    size: (w, h) of the pictures; odd sides are padded by repeating the last row or column. rate:
    pictures per second. The file is BT.709, limited range, 4:2:0, and says so in its tags: colours
    of single pixels blur. It gets its name by close(); abort(), an exception in the block, or
    close() before the first picture leaves nothing.

    Errors: MachineError if PyAV has no H.264 encoder that opens, or the disk is full; InputError
    for a place that cannot be written, a size below 16 or a rate beyond 0..1000; HmdwarpError for a
    picture of another size.
    """

    def __init__(self, path: str | os.PathLike[str], size: tuple[int, int], rate: float) -> None:
        av = self._av = pyav()
        self.path, self.size = Path(path), size
        if min(size) < 16 or not 0 < rate <= 1000:
            found = f"video of {size[0]}x{size[1]} at {rate:g} pictures per second"
            raise InputError(f"{found}: expected at least 16x16 and a rate above 0, at most 1000")
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
            self._stream = self._first_that_opens(Fraction(rate).limit_denominator(1001))
        except BaseException:
            self.abort()
            raise
        self.encoder: str = self._stream.codec_context.codec.name

    def _first_that_opens(self, rate: Fraction) -> Any:
        av, tried = self._av, []
        for name in available_encoders():
            # A refused codec context stays in its container, so each encoder is first tried on its
            # own.
            trial = av.CodecContext.create(name, "w")
            _set_up(trial, self.size, rate, name)
            try:
                trial.open()
            except (OSError, av.FFmpegError, ValueError) as error:
                tried.append(f"{name} ({error})")
                continue
            stream = self._container.add_stream(name, rate=rate)
            _set_up(stream.codec_context, self.size, rate, name)
            return stream
        refused = f"none of its H.264 encoders opens: {', '.join(tried)}"
        what = refused if tried else "it was built without an H.264 encoder"
        raise MachineError(
            f"PyAV {av.__version__} cannot write {self.path.name}: {what}; install PyAV from its wheel (pip install av)"
        )

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


def _set_up(context: Any, size: tuple[int, int], rate: Fraction, name: str) -> None:
    context.width, context.height = size[0] + size[0] % 2, size[1] + size[1] % 2
    context.pix_fmt = "yuv420p"
    context.framerate, context.time_base = rate, 1 / rate
    context.options = dict(_OPTIONS.get(name, {}))
    context.color_range = _LIMITED
    context.colorspace = context.color_primaries = context.color_trc = _BT709


def _video_error(error: Exception, path: Path) -> HmdwarpError:
    if isinstance(error, OSError) and error.errno is not None:
        return write_error(error, path)
    return MachineError(f"{path}: the video encoder failed ({error})")
