"""A long run of server and client over a network that is cut now and then: `make test-soak`.

Nothing may grow and no session may be lost. Prints what it measured.
"""

from __future__ import annotations

import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from apparatus import options
from serving import Serving
from sources.feed.exchange import port_of
from sources.feed.relay import Relay

SIZE = (160, 200)
# Both eyes with colour (8 bytes a pixel), depth (4) and a guard band of 1.5 each way.
FRAME_BYTES = 2 * SIZE[0] * SIZE[1] * 12 * 1.5**2
# Of each sample anything from none to a dozen frames may be on its way, on either side of a sample;
# half a MiB is what the interpreter's own pools vary by.
MOST_GROWTH = 12 * FRAME_BYTES + (1 << 19)
CUT_EVERY_S = 60.0


def resident(process: int) -> int:
    """Return the bytes that a process holds in memory."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def growth(samples: list[int]) -> float:
    """Return how much larger the last quarter is than the second: the first warms up."""
    quarter = max(1, len(samples) // 4)
    return statistics.median(samples[-quarter:]) - statistics.median(samples[quarter : 2 * quarter])


def main() -> int:
    """Run it; return 0 where nothing grew and nothing was lost."""
    seconds = options(__doc__, seconds=(3600.0, "that both run")).seconds
    held: dict[str, list[int]] = {"server": [], "client": []}
    cuts = 0
    with tempfile.TemporaryDirectory() as folder, Serving() as serving, Relay(port_of(serving.address)) as relay:
        relay.delay_s, relay.jitter_s = 0.01, 0.01
        out = Path(folder) / "out"
        said = f"--source offscreen --trace look-around --size {SIZE[0]}x{SIZE[1]} --connect {relay.address} --quiet"
        client = subprocess.Popen([sys.executable, "-m", "hmdwarp", "live", *said.split(), "--out", str(out)])
        serving.line("here")
        begun = next_cut = time.monotonic()
        while time.monotonic() - begun < seconds:
            time.sleep(min(1.0, seconds / 200))
            if client.poll() is not None or serving.process.poll() is not None:
                print("one of them has ended")
                return 1
            held["server"].append(resident(serving.process.pid))
            held["client"].append(resident(client.pid))
            if time.monotonic() - next_cut > CUT_EVERY_S:
                next_cut, cuts = time.monotonic(), cuts + 1
                relay.cut()
        client.send_signal(signal.SIGTERM)  # a shell may have started this deaf to SIGINT
        client.wait()
        summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    live, feed = summary["live"], summary["link"]["feed"]
    shown, jumps = summary["link"]["frames"]["shown"], feed["clock"]["jumps"]
    print(f"{seconds:g} s, link cut {cuts} times: {live['refreshes']} refreshes, {shown} frames shown")
    print(
        f"frames stopped {feed['lost']} times, {feed['malformed']} messages malformed, the clock jumped {jumps} times"
    )
    grown = {name: growth(samples) for name, samples in held.items()}
    for name, samples in held.items():
        print(f"{name}: {max(samples) / 2**20:.0f} MiB at most, grown by {grown[name] / 2**20:+.1f} MiB")
    whole = not (feed["lost"] or feed["malformed"] or feed["clock"]["jumps"]) and live["refreshes"] > 0
    return 0 if whole and max(grown.values()) < MOST_GROWTH else 1


if __name__ == "__main__":
    sys.exit(main())
