"""Rows of a track as text, a block at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import IO

import numpy as np

from ..track import PoseTrack

_BLOCK = 65536
_LARGEST_NS = 2**62  # what the readers accept


def clock_offset_ns(track: PoseTrack) -> int:
    """Return the offset to the track's time that restores the recording's own clock.

    0 where that does not fit into 2^62 ns.
    """
    fits = abs(track.epoch_ns + track.start_ns) < _LARGEST_NS and abs(track.epoch_ns + track.end_ns) < _LARGEST_NS
    return track.epoch_ns if fits else 0


def exact_text(values: Iterable[float], separator: str) -> str:
    """Return numbers (Python's floats) in the shortest text that reads back the same."""
    return separator.join(map(repr, values))


def write_rows(
    track: PoseTrack,
    stream: IO[str],
    separator: str,
    *,
    stamp: Callable[[int], str],
    order: str,
    decimals: tuple[int, int] | None = None,
) -> None:
    """Write time, position and quaternion of every sample.

    stamp: nanoseconds to text.
    order: xyzw or wxyz.
    decimals: of positions and quaternions; None writes the shortest text that reads back as the
    same number.
    """
    offset = clock_offset_ns(track)
    columns = ["xyzw".index(c) for c in order]
    for a in range(0, len(track), _BLOCK):
        part = slice(a, a + _BLOCK)
        position, orientation = track.position_m[part], track.orientation_xyzw[part][:, columns]
        if decimals is None:
            texts = [exact_text(p + q, separator) for p, q in zip(position.tolist(), orientation.tolist(), strict=True)]
        else:
            row = separator.join([f"%.{decimals[0]}f"] * 3 + [f"%.{decimals[1]}f"] * 4)
            # + 0.0 turns a rounded -0.0 into 0.0
            rounded = (
                (np.round(position, decimals[0]) + 0.0).tolist(),
                (np.round(orientation, decimals[1]) + 0.0).tolist(),
            )
            texts = [row % (*p, *q) for p, q in zip(*rounded, strict=True)]
        times = track.time_ns[part].tolist()
        stream.writelines(f"{stamp(t + offset)}{separator}{text}\n" for t, text in zip(times, texts, strict=True))
