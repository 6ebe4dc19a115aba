"""Pictures of a video by their number, decoded forward and kept one at a time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...options.named_files import VIDEO, opened
from .picture_files import Size


class VideoPictures:
    """The pictures of a video file. Errors: InputError for what is no video."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._next, self._pictures = 0, iter(())  # type: int, Iterator[Any]
        # Instants of the pictures that were decoded, by which one is found again.
        self._instants: list[int | None] = []
        self._last: tuple[int, NDArray[np.uint8]] | None = None
        self.size: Size = self.picture(0).shape[1::-1]

    def picture(self, number: int) -> NDArray[np.uint8]:
        """Return (h, w, 3) sRGB of a picture, counted from 0 as it is shown; quickest in order."""
        with self._lock:
            if self._last is None or self._last[0] != number:
                self._last = number, self._decoded(number)
            return self._last[1]

    def _decoded(self, number: int) -> NDArray[np.uint8]:
        import av

        try:
            if number < self._next or self._next == 0:
                self._go_back(av, number)
            for picture in self._pictures:
                if self._next == len(self._instants):
                    self._instants.append(picture.pts)
                elif self._instants[self._next] not in (None, picture.pts):  # it cannot be sought
                    self._next, self._instants = 0, [None] * len(self._instants)
                    return self._decoded(number)
                self._next += 1
                if self._next > number:
                    return np.asarray(picture.to_ndarray(format="rgb24"))
        except (OSError, av.FFmpegError) as error:
            raise InputError(f"{self.path}: not a video that can be read ({error})") from error
        raise InputError(f"{self.path}: {self._next} pictures; expected picture {number}, counted from 0")

    def _go_back(self, av: Any, number: int) -> None:
        """Begin at a picture that was decoded before, else with the first."""
        instant = self._instants[number] if number < len(self._instants) else None
        self._next, self._pictures = (0 if instant is None else number), self._from(av, instant)

    def _from(self, av: Any, instant: int | None) -> Iterator[Any]:
        """Yield the pictures from an instant of the stream's clock on; None for all."""
        # Of this form alone: playlists, for instance, name other files.
        with opened(self.path, VIDEO) as file, av.open(file, format="mp4") as container:
            if not container.streams.video:
                raise InputError(f"{self.path}: no pictures in it: expected a video")
            stream = container.streams.video[0]
            if instant is not None:
                # A second before: pictures just after a seek may need those before it.
                container.seek(max(0, instant - round(1 / stream.time_base)), stream=stream)
            pictures = container.decode(stream)
            yield from pictures if instant is None else (shown for shown in pictures if shown.pts >= instant)
