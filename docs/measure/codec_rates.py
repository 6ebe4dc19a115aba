"""Video codecs at one coded PSNR: bytes, and processor time, in shares of H.264's.

A table for docs/results-link.md: the room as two recordings see it, each codec at several
qualities, interpolated between the two beside the PSNR that H.264 has at its own.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from apparatus import options, print_table

from hmdwarp import Fov, View
from hmdwarp.base import srgb8_from_linear
from hmdwarp.gpu import Gpu, download
from hmdwarp.link.codec import ColourDecoder, ColourEncoder, codecs
from hmdwarp.poses import load_trace
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

SIZE, RATE_HZ = (640, 400), 30
VIEW = Fov.symmetric(*np.radians((96, 69.6)))
STARTS_S = {"walk": 1.0, "look-around": 2.0}
STEPS = (-6, 0, 6, 12)  # of a codec's own quality


def pictures(server: Server, recording: str, count: int) -> list[np.ndarray]:
    """Return (h, w, 3) sRGB of a moment of a recording."""
    track, found = load_trace(recording).track, []
    for k in range(count):
        now = track.start_ns + round((STARTS_S[recording] + k / RATE_HZ) * 1e9)
        frame = server.draw_frame((View(track.at(now).pose, VIEW),), now, SIZE)
        found.append(srgb8_from_linear(download(frame.eyes[0].colour)[..., :3]))
        server.recycle(frame)
    return found


def measured(name: str, crf: int, shown: Sequence[np.ndarray]) -> list[float]:
    """Return PSNR, log of the bytes, seconds of encoding and of decoding; without the key frame."""
    codec = codecs.get(name)
    encoder, decoder = ColourEncoder(codec, SIZE, RATE_HZ, crf, None), ColourDecoder(codec, SIZE)
    rows = []
    for k, picture in enumerate(shown):
        begun = time.process_time()  # of all threads
        data, key = encoder.encode(picture, k == 0)
        coded = time.process_time()
        decoder.begin(k, key)
        off = decoder.decode(data, k).astype(float) - picture
        rows.append((np.mean(off**2), len(data), coded - begun, time.process_time() - coded))
    square, size, encoding, decoding = np.mean(rows[1:], axis=0)
    return [10 * np.log10(255**2 / square), np.log(size), encoding, decoding]


def at_equal_psnr(shown: Sequence[np.ndarray]) -> dict[str, list[float]]:
    """Return bytes and times of each codec where its PSNR is that of H.264 at its own quality."""
    found, aim = {}, measured("h264", codecs.get("h264").crf, shown)[0]
    for codec in codecs:
        if not codec.is_none:
            table = np.array([measured(codec.name, codec.crf + step, shown) for step in STEPS])[::-1]
            _, size, encoding, decoding = (np.interp(aim, table[:, 0], column) for column in table.T)
            found[codec.name] = [float(np.exp(size)), encoding, decoding]
    return found


def main() -> None:
    """Print the table."""
    count = options(__doc__, pictures=(20, "of each recording")).pictures
    with Gpu() as gpu:
        server = Server(gpu, load_scene("room"), samples=4)
        each = [at_equal_psnr(pictures(server, recording, count)) for recording in STARTS_S]
        server.close()
    rows = []
    for name in each[0]:
        shares = np.exp(np.mean([np.log(np.divide(of[name], of["h264"])) for of in each], axis=0))
        rows.append([name, *(f"{share:.2f}" for share in shares)])
    print_table(("codec", "bytes", "encoding", "decoding"), rows)


if __name__ == "__main__":
    main()
