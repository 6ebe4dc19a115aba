"""Pages, and slow connections at both doors, beside an honest client: part of `make test-soak`.

Nobody may be shut out, and what the others held is free soon after they left. Prints its figures.
"""

from __future__ import annotations

import asyncio
import sys
import time
import urllib.request
from http.cookiejar import CookieJar

from apparatus import options
from serving import Serving
from web.crowd import Crowd, held_by

SLOW, PAGES = 400, 12
MOST_WAIT_S, BACK_S, GROWN_MIB = 5.0, 10.0, 64


def main() -> int:
    """Run it; return 0 where the honest client was served and nothing stayed."""
    seconds = options(__doc__, seconds=(600.0, "that the crowd is there")).seconds
    with Serving("--web", "127.0.0.1:*") as serving:
        serving.door, jar = serving.line("for a browser").split()[-1], CookieJar()
        urllib.request.build_opener(urllib.request.HTTPCookieProcessor(jar)).open(serving.door).close()
        cookie, process = "; ".join(f"{one.name}={one.value}" for one in jar), serving.process.pid
        asyncio.run(Crowd(serving, cookie).all(3.0, 0, 1))
        alone = Crowd(serving, cookie)
        asyncio.run(alone.all(5.0, 0, 0))
        before_mib, before = held_by(process)
        crowd = Crowd(serving, cookie)
        asyncio.run(crowd.all(seconds, SLOW, PAGES))
        left_s, after, after_mib = time.monotonic(), before + 1, before_mib
        while after > before and time.monotonic() - left_s < BACK_S:
            time.sleep(0.1)
            after_mib, after = held_by(process)
        back_s = time.monotonic() - left_s
    print(
        f"{seconds:g} s beside {SLOW} unfinished requests at both doors and {PAGES} bad pages: {crowd.frames} frames, "
        f"the longest wait {crowd.longest_s:.2f} s ({alone.longest_s:.2f} s alone)"
    )
    print(
        f"{back_s:.1f} s after they left: {after} descriptors of {before} before, {after_mib} MiB of {before_mib}, "
        f"the log {sum(map(len, serving._said)) / 1024 / seconds:.1f} kB a second"
    )
    return int(crowd.longest_s > MOST_WAIT_S or after > before or after_mib > before_mib + GROWN_MIB)


if __name__ == "__main__":
    sys.exit(main())
