"""What one frame costs from a process to the next: TCP on the loopback, ipc://, shared memory.

Through both ends of the feed, all in one run, in turn, with the median of many; prints the table of
docs/feed.md.
"""

from __future__ import annotations

import argparse
import itertools
import multiprocessing
import statistics
import tempfile
import threading
import time
from contextlib import closing

import attrs
import numpy as np

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import HALF, RAW, Ask, DepthCodes, FrameMessage, Wish, encode
from hmdwarp.sources.feed.shared_frames import FrameReader, SharedFrames

SIZES = ((640, 400), (1344, 1600))
WAYS = ("tcp", "ipc", "shared memory")
MOST_COPIES = 1.5
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


def give(addresses: list[str]) -> None:
    """The other process: answer each request by a frame of its size, until one says to end."""
    frames = {(size, wish): frame_of(size, wish) for size in SIZES for wish in RAW.values()}
    ended = threading.Event()

    def answer(listener: Listener) -> None:
        while not ended.is_set():
            asked = listener.next(100)
            if asked is not None and asked.ask.size == END:
                ended.set()
            elif asked is not None:
                listener.answer(asked, attrs.evolve(frames[asked.ask.size, asked.ask.wish], number=asked.ask.number))
        listener.close()

    threads = [threading.Thread(target=answer, args=(Listener(address),)) for address in addresses]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


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


def over_memcpy(size: tuple[int, int], rounds: int = 15) -> str:
    """Return a line on both copies of a frame through shared memory, over one in memory.

    Processor time, without asking and without looking at what came. All three in turn, each from
    and into memory that was last touched a round ago.
    """
    frame, shared, reader = frame_of(size), SharedFrames(), FrameReader()
    data = np.frombuffer(encode(frame), np.uint8)
    kept = data.copy()
    took: list[list[float]] = [[], [], []]
    try:
        for number in range(1, rounds + 1):
            frame = attrs.evolve(frame, number=number)
            begun = time.process_time()
            stub = shared.put(b"client", frame)
            assert stub is not None
            written = time.process_time()
            reader.read(stub)
            arrived = time.process_time()
            shared.received(b"client", number)
            read = time.process_time()
            np.copyto(kept, data)
            for times, seconds in zip(
                took, (written - begun, arrived - written, time.process_time() - read), strict=True
            ):
                times.append(seconds * 1e3)
    finally:
        shared.close()
    put, got, copy = map(statistics.median, took)
    return (
        f"a frame through shared memory, {size[0]}x{size[1]}, both eyes: {put:.1f} ms in, {got:.1f} out; "
        f"{put / copy:.2f} and {got / copy:.2f} times a copy of it in memory (aim {MOST_COPIES:g} each)"
    )


def main() -> None:
    """Measure and print."""
    wanted = argparse.ArgumentParser(description=__doc__)
    wanted.add_argument("--times", type=int, default=60)
    times = wanted.parse_args().times
    took: dict[tuple[str, str, tuple[int, int]], list[float]] = {}
    numbers = itertools.count(1)
    with tempfile.TemporaryDirectory() as folder:
        tcp, ipc = f"127.0.0.1:{PORT}", f"ipc://{folder}/frames"
        other = multiprocessing.get_context("spawn").Process(target=give, args=([tcp, ipc],))
        other.start()
        with (
            closing(Caller(tcp)) as by_tcp,
            closing(Caller(ipc, shares=False)) as by_ipc,
            closing(Caller(ipc)) as by_memory,
        ):
            callers = dict(zip(WAYS, (by_tcp, by_ipc, by_memory), strict=True))
            for turn in range(times + 5):
                for (form, wish), size, (way, caller) in itertools.product(RAW.items(), SIZES, callers.items()):
                    ask = Ask(next(numbers), 0, 0, 0, 0, size, Pose(), VIEWS, wish=wish)
                    seconds = fetched(caller, ask)
                    if turn >= 5:
                        took.setdefault((form, way, size), []).append(seconds)
            by_tcp.ask(Ask(next(numbers), 0, 0, 0, 0, END, Pose(), VIEWS))
            other.join()
    print(f"| pixels of one eye | `--raw` | {' | '.join(WAYS)} | ipc / tcp | shared memory / ipc | half / full |")
    print("| --- | --- |" + " --- |" * (len(WAYS) + 3))
    for size, form in itertools.product(SIZES, RAW):
        medians = [statistics.median(took[form, way, size]) for way in WAYS]
        over = (
            ""
            if form == "full"
            else ", ".join(
                f"{one / statistics.median(took['full', way, size]):.2f}"
                for one, way in zip(medians, WAYS, strict=True)
            )
        )
        cells = " | ".join(f"{median * 1e3:.2f} ms" for median in medians)
        ratios = f"{medians[1] / medians[0]:.2f} | {medians[2] / medians[1]:.2f}"
        print(f"| {size[0]}x{size[1]} | {form} | {cells} | {ratios} | {over} |")


if __name__ == "__main__":
    main()
