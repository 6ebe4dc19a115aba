"""A receiver of markers: a real inlet in a process of its own.

LSL may look for streams on this machine only, and among those of one test.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager

import needs
import pytest

CONFIGURATION = """
[lab]
SessionID = {session}
[multicast]
ResolveScope = machine
[ports]
IPv6 = disable
[log]
level = -3
"""
# Says that it is connected, then each marker with its stamp, and its description, until the stream
# says that it has ended.
INLET = """
import json, sys, pylsl
found = pylsl.resolve_byprop("name", sys.argv[1], timeout=600)
inlet = pylsl.StreamInlet(found[0], recover=False)
inlet.open_stream()
description = inlet.info().as_xml()
offset = inlet.time_correction()
print(json.dumps({"xml": description, "type": found[0].type(), "offset_s": offset}), flush=True)
while True:
    (text,), stamp = inlet.pull_sample()
    print(json.dumps({"stamp": stamp, **json.loads(text)}), flush=True)
    if json.loads(text)["event"] == sys.argv[2]:
        break
"""


def _why_not() -> str | None:
    try:
        import pylsl  # noqa: F401
    except ImportError:
        return needs.missing("pylsl", "pip install '.[lsl]'")
    except RuntimeError:
        return needs.missing("liblsl", "conda install -c conda-forge liblsl")
    return None


HERE = _why_not()
with_lsl = pytest.mark.skipif(HERE is not None, reason=HERE or "")


class Receiver:
    """An inlet in a process."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    def connected(self) -> dict[str, object]:
        """Wait until the stream is found, and return what it says of itself."""
        return self._next()

    def markers(self) -> list[dict[str, object]]:
        """Wait for the last event, and return all markers."""
        rest = [json.loads(line) for line in self._process.stdout]
        assert self._process.wait() == 0
        return rest

    def _next(self) -> dict[str, object]:
        line = self._process.stdout.readline()
        assert line, self._process.wait()
        return json.loads(line)


_SESSION = uuid.uuid4().hex


@pytest.fixture
def lsl_on_this_machine(tmp_path_factory) -> None:
    """Streams are found on this machine only, by the tests of one process.

    LSL reads its configuration once in a process.
    """
    file = tmp_path_factory.mktemp("lsl") / "lsl.cfg"
    file.write_text(CONFIGURATION.format(session=_SESSION), encoding="utf-8")
    os.environ["LSLAPICFG"] = str(file)


@contextmanager
def receiving(name: str, last: str) -> Iterator[Receiver]:
    """Start a receiver of a stream by its name and the last event in it."""
    process = subprocess.Popen([sys.executable, "-c", INLET, name, last], stdout=subprocess.PIPE, text=True)
    try:
        yield Receiver(process)
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
