"""Random draws that belong to a person and a thing, so that a session that is gone on with answers as it would have without the crash.

A counter-based generator (Philox) is set to a place that the person and the thing name; nothing depends on what was drawn before.
"""

from __future__ import annotations

import hashlib
import zlib

import numpy as np

from .model import Floats

_64 = (1 << 64) - 1


def person_of(code: str) -> int:
    """The number of the simulated person who goes by that code: the same on every machine."""
    return int.from_bytes(hashlib.sha256(code.encode()).digest()[:8], "big")


def table_of(seed: int, study: int, part: str, person: int, count: int) -> Floats:
    """`count` uniform draws in [0, 1) of a person in a part of a study; a longer table begins with the shorter one."""
    return _uniform(seed, study, part, person, 0, count)


def draw_for(seed: int, part: str, person: int, thing: str, count: int = 1) -> Floats:
    """Uniform draws for one thing of a session, by its name; they are none of the table's."""
    return _uniform(seed, 0, part, person, 1 + zlib.crc32(thing.encode()), count)


def _uniform(seed: int, study: int, part: str, person: int, thing: int, count: int) -> Floats:
    counter = np.array([0, thing, zlib.crc32(part.encode()), person & _64], np.uint64)
    return np.random.Generator(
        np.random.Philox(key=np.array([seed & _64, study & _64], np.uint64), counter=counter)
    ).random(count)
