"""Random draws that belong to a person and a thing.

A resumed session therefore answers as it would have without the crash. A counter-based generator
(Philox) is set to a position named by person and thing; no draw depends on an earlier one.
"""

from __future__ import annotations

import hashlib
import zlib

import numpy as np

from .response_model import Floats

_64 = (1 << 64) - 1


def person_of(code: str) -> int:
    """Return the number of the simulated person with that code, the same on every machine."""
    return int.from_bytes(hashlib.sha256(code.encode()).digest()[:8], "big")


def table_of(seed: int, study: int, part: str, person: int, count: int) -> Floats:
    """Return `count` uniform draws in [0, 1) of a person in a part of a study.

    A longer table begins with the shorter one.
    """
    return _uniform(seed, study, part, person, 0, count)


def draw_for(seed: int, part: str, person: int, thing: str, count: int = 1) -> Floats:
    """Return uniform draws for one named thing of a session, independent of the person's table."""
    return _uniform(seed, 0, part, person, 1 + zlib.crc32(thing.encode()), count)


def _uniform(seed: int, study: int, part: str, person: int, thing: int, count: int) -> Floats:
    counter = np.array([0, thing, zlib.crc32(part.encode()), person & _64], np.uint64)
    key = np.array([seed & _64, study & _64], np.uint64)
    return np.random.Generator(np.random.Philox(key=key, counter=counter)).random(count)
