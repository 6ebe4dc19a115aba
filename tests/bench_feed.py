"""What one frame costs from a process to the next, over TCP on the loopback.

Through both ends of the feed, all in one run, in turn, with the median of many; prints the table of
docs/feed.md.
"""

from __future__ import annotations

import argparse
import itertools
import multiprocessing
import statistics
import time
from contextlib import closing

import attrs
import numpy as np

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import HALF, RAW, Ask, DepthCodes, FrameMessage, Wish

SIZES = ((640, 400), (1344, 1600))
VIEWS = (View(Pose(), Fov.symmetric(1.5, 1.5)),) * 2
# The one that ends the other process.
END = (1, 1)
PORT = 5599


def frame_of(size: tuple[int, int], wish: Wish = RAW["full"]) -> FrameMessage:
    """Both eyes with colour (8 bytes a pixel) and depth (4), as downloaded, or in half."""
    rng = np.random.default_rng(1)
    if wish == HALF:
        bytes_ = tuple(rng.integers(0, 256, (size[1], size[0], 4), np.uint8) for _ in VIEWS)
        codes = tuple(DepthCodes(rng.integers(0, 65536, size[::-1], np.uint16), 1e-4) for _ in VIEWS)
        return FrameMessage(1, 0, 0, 0, 0, 0, VIEWS, bytes_, codes)
    colours = tuple(rng.random((size[1], size[0], 4), np.float32).astype(np.float16)[::-1] for _ in VIEWS)
    depths = tuple(rng.random((size[1], size[0]), np.float32)[::-1] for _ in VIEWS)
    return FrameMessage(1, 0, 0, 0, 0, 0, VIEWS, colours, depths)


def give(address: str) -> None:
    """The other process: answer each request by a frame of its size, until one says to end."""
    frames = {(size, wish): frame_of(size, wish) for size in SIZES for wish in RAW.values()}
    with closing(Listener(address)) as listener:
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
    (arrival,) = arrived[-1:]
    # As an upload does.
    for picture in (*arrival.frame.colours, *arrival.frame.inverse_depths):
        numbers = picture.codes if isinstance(picture, DepthCodes) else picture
        np.add.reduce(np.frombuffer(numbers, np.uint16 if numbers is not picture else np.uint32))
    return time.perf_counter() - begun


def main() -> None:
    """Measure and print."""
    wanted = argparse.ArgumentParser(description=__doc__)
    wanted.add_argument("--times", type=int, default=60)
    times = wanted.parse_args().times
    took: dict[tuple[str, tuple[int, int]], list[float]] = {}
    numbers, address = itertools.count(1), f"127.0.0.1:{PORT}"
    other = multiprocessing.get_context("spawn").Process(target=give, args=(address,))
    other.start()
    with closing(Caller(address)) as caller:
        for turn in range(times + 5):
            for (form, wish), size in itertools.product(RAW.items(), SIZES):
                seconds = fetched(caller, Ask(next(numbers), 0, 0, 0, 0, size, Pose(), VIEWS, wish=wish))
                if turn >= 5:
                    took.setdefault((form, size), []).append(seconds)
        caller.ask(Ask(next(numbers), 0, 0, 0, 0, END, Pose(), VIEWS))
        other.join()
    print("| pixels of one eye | `--raw` | time | half / full |")
    print("| --- | --- | --- | --- |")
    for size, form in itertools.product(SIZES, RAW):
        median, full = (statistics.median(took[one, size]) for one in (form, "full"))
        over = "" if form == "full" else f"{median / full:.2f}"
        print(f"| {size[0]}x{size[1]} | {form} | {median * 1e3:.2f} ms | {over} |")


if __name__ == "__main__":
    main()
