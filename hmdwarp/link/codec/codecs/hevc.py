"""H.265 by x265.

Settings as for H.264. superfast took 22 ms for a 1280x800 picture on two cores, 15 kB at crf 22;
ultrafast 15 ms, 20 kB. A key frame of 2048x2048 takes a core 2.6 s with superfast, at crf 0 4.1;
with ultrafast 0.6 and 1.2, so that is what large pictures have. frame-threads=1: with more, a
picture would be encoded only after later ones. repeat-headers: a decoder can start at any key
frame. log-level none: x265 writes to stderr directly, past every logger. info=0: no text with the
settings in each stream.
"""

from . import Codec, codecs

_X265 = "log-level=none:frame-threads=1:pools=2:repeat-headers=1:scenecut=0:open-gop=0:info=0"
_OPTIONS = {"preset": "superfast", "tune": "zerolatency", "forced-idr": "1", "x265-params": _X265}

codecs.register(
    Codec(
        "hevc",
        "H.265 by x265, superfast, zero latency",
        "libx265",
        "hevc",
        crf=22,
        threads=1,
        options=_OPTIONS,
        large={"preset": "ultrafast"},
    )
)
