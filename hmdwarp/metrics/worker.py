"""The measuring process: pickled jobs on standard input, pickled results on standard output.

It is an ordinary program started by MeasuringProcess, neither a fork nor a multiprocessing child.
It holds no GL context, does not import the user's main script again, does not receive the
terminal's Ctrl-C, and ends when its input ends.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import sys

from ..platforms import lower_priority

_NICENESS = 5  # measuring must not slow down the loop whose passes are being timed


def main() -> None:
    """Serve until the input ends: first the function, then what it is to be applied to."""
    # Text printed to standard output (FLIP prints errors there) must not end up among the results.
    results = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    lower_priority(_NICENESS)

    # A parent that is gone (EOFError, BrokenPipeError) needs no more results.
    with contextlib.suppress(EOFError, BrokenPipeError):
        work = pickle.load(sys.stdin.buffer)  # loads its libraries, niced
        while True:
            asked = pickle.load(sys.stdin.buffer)
            try:
                answer: object = work(asked)
            except Exception as error:
                answer = error
            results.write(_dumps(answer))
            results.flush()


def _dumps(answer: object) -> bytes:
    try:
        return pickle.dumps(answer, protocol=5)
    except Exception:  # an exception that cannot be pickled still has a text
        return pickle.dumps(RuntimeError(f"{type(answer).__name__}: {answer}"), protocol=5)
