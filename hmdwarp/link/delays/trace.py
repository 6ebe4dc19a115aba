"""Delays measured on a real network."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import attrs

from ...errors import InputError
from ...options.documents import json_of
from ...options.named_files import DELAYS, text_in
from . import LONGEST_MS, DelayModel, delay_models

if TYPE_CHECKING:
    import numpy as np  # help does not wait for it

_MOST_LINES = 10_000_000  # 80 MB; a day of frames at 90 Hz is 7.8 million


@delay_models.register
@attrs.frozen
class DelayTrace(DelayModel):
    """The delays of a file, one for each frame, repeated when they end.

    The latency is ignored.
    """

    name = "trace"
    delays_ms: tuple[float, ...] = attrs.field(repr=lambda delays: f"<{len(delays)} delays>")
    # The file, for messages.
    path: Path

    @classmethod
    def parse(cls, argument: str) -> DelayTrace:
        """Read the file `argument`, see `read_delays`."""
        if not argument:
            raise InputError("--jitter 'trace': expected a file of delays after it (--delay-trace FILE)")
        return cls(tuple(read_delays(Path(argument))), Path(argument))

    def longest_ns(self, latency_ns: int) -> int:
        return round(max(self.delays_ms) * 1e6)

    def typical_ns(self, latency_ns: int) -> int:
        return round(math.fsum(self.delays_ms) / len(self.delays_ms) * 1e6)

    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        return (round(delay * 1e6) for delay in itertools.cycle(self.delays_ms))


def read_delays(path: Path) -> list[float]:
    """Read the delays in ms of a text file with one number a line, or of a browser's session.jsonl.

    # starts a comment; the first line may be a heading.
    Errors: InputError with file, line and value, and for several sessions.
    """
    text = text_in(path, DELAYS)
    read = _of_session if text.startswith("{") else _numbers
    delays = list(read(path, text.splitlines()))
    if not delays:
        raise InputError(f"{path}: holds no delay; expected one number of milliseconds a line")
    return delays


def _of_session(path: Path, lines: Iterable[str]) -> Iterator[float]:
    """Yield the delays in lines of JSON as `hmdwarp serve --web` writes them, of one session."""
    sessions: dict[str, None] = {}
    for number, line in enumerate(lines, start=1):
        said = json_of(line, f"{path}: line {number}")
        delays = said.get("delays_ms") if isinstance(said, dict) else None
        if isinstance(delays, list):
            sessions[str(said.get("session"))] = None
            yield from (_delay(path, number, str(delay)) for delay in delays)
    if len(sessions) > 1:
        some = ", ".join([*sessions][:8])
        raise InputError(
            f"{path}: delays of {len(sessions)} sessions ({some}): keep the lines of one, as grep does by its name"
        )


def _numbers(path: Path, lines: Iterable[str]) -> Iterator[float]:
    may_be_heading, found = True, 0
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        is_word = text[:1].isalpha() and text.lower() not in ("nan", "inf", "infinity")
        heading, may_be_heading = may_be_heading and is_word, False
        if heading:
            continue
        found += 1
        if found > _MOST_LINES:
            raise InputError(f"{path}: line {number}: expected at most {_MOST_LINES} delays")
        yield _delay(path, number, text)


def _delay(path: Path, number: int, text: str) -> float:
    try:
        value = float(text.encode("ascii"))
    except ValueError:
        value = math.nan
    if not 0 <= value <= LONGEST_MS:
        shown = text if len(text) <= 40 else text[:37] + "..."
        raise InputError(
            f"{path}: line {number}: '{shown}': expected one delay in milliseconds, from 0 to {LONGEST_MS:g}"
        )
    return value
