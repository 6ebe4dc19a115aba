"""What one frame costs from a process to the next, over TCP on the loopback.

Through both ends of the feed, all in one run, in turn, with the median of many; prints the table of
docs/feed.md.
"""

from __future__ import annotations

import itertools
import multiprocessing
import statistics
import time
from contextlib import closing

import attrs
import numpy as np
from apparatus import options, print_table

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import HALF, RAW, Ask, DepthCodes, FrameMessage, Wish

SIZES, WARM = ((640, 400), (1344, 1600)), 5
VIEWS = (View(Pose(), Fov.symmetric(1.5, 1.5)),) * 2
END = (1, 1)  # the size that ends the other process
ADDRESS = "127.0.0.1:5599"


def frame_of(size: tuple[int, int], wish: Wish) -> FrameMessage:
    """Return both eyes with colour (8 bytes a pixel) and depth (4), as downloaded, or in half."""
    rng = np.random.default_rng(1)
    if wish == HALF:
        colours = tuple(rng.integers(0, 256, (size[1], size[0], 4), np.uint8) for _ in VIEWS)
        depths = tuple(DepthCodes(rng.integers(0, 65536, size[::-1], np.uint16), 1e-4) for _ in VIEWS)
    else:
        colours = tuple(rng.random((size[1], size[0], 4), np.float32).astype(np.float16)[::-1] for _ in VIEWS)
        depths = tuple(rng.random((size[1], size[0]), np.float32)[::-1] for _ in VIEWS)
    return FrameMessage(1, 0, 0, 0, 0, 0, VIEWS, colours, depths)


def give() -> None:
    """Answer each request by a frame of its size, in the other process, until one says to end."""
    frames = {(size, wish): frame_of(size, wish) for size in SIZES for wish in RAW.values()}
    with closing(Listener(ADDRESS)) as listener:
        while (asked := listener.next(100)) is None or asked.ask.size != END:
            if asked is not None:
                listener.answer(asked, attrs.evolve(frames[asked.ask.size, asked.ask.wish], number=asked.ask.number))


def fetched(caller: Caller, ask: Ask) -> float:
    """Return the seconds from a request until every byte of its frame was read once."""
    begun = time.perf_counter()
    caller.ask(ask)
    while not (arrived := caller.take()):
        # Asked again where the connection was not there yet.
        if not caller.wait_until(time.monotonic_ns() + 2_000_000_000):
            caller.ask(ask)
    frame = arrived[-1].frame
    for picture in (*frame.colours, *frame.inverse_depths):  # as an upload does
        numbers = picture.codes if isinstance(picture, DepthCodes) else picture
        np.add.reduce(np.frombuffer(numbers, np.uint16 if numbers is not picture else np.uint32))
    return time.perf_counter() - begun


def main() -> None:
    """Measure and print."""
    times = options(__doc__, times=(60, "that each frame is fetched")).times
    cases = list(itertools.product(SIZES, RAW))
    took: dict[tuple[tuple[int, int], str], list[float]] = {case: [] for case in cases}
    numbers, other = itertools.count(1), multiprocessing.get_context("spawn").Process(target=give)
    other.start()
    with closing(Caller(ADDRESS)) as caller:
        for _, (size, form) in itertools.product(range(times + WARM), cases):
            ask = Ask(next(numbers), 0, 0, 0, 0, size, Pose(), VIEWS, wish=RAW[form])
            took[size, form].append(fetched(caller, ask))
        caller.ask(Ask(next(numbers), 0, 0, 0, 0, END, Pose(), VIEWS))
        other.join()
    median = {case: statistics.median(each[WARM:]) for case, each in took.items()}
    rows = []
    for size, form in cases:
        over = "" if form == "full" else f"{median[size, form] / median[size, 'full']:.2f}"
        rows.append([f"{size[0]}x{size[1]}", form, f"{median[size, form] * 1e3:.2f} ms", over])
    print_table(("pixels of one eye", "`--raw`", "time", "half / full"), rows, texts=4)


if __name__ == "__main__":
    main()
