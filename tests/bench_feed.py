"""What one frame costs from a process to the next: TCP on the loopback, ipc://, shared memory.

All in one run, in turn, with the median of many; prints the table of docs/feed.md.
"""

from __future__ import annotations

import argparse
import multiprocessing
import statistics
import tempfile
import time
from multiprocessing.shared_memory import SharedMemory

import numpy as np
import zmq

# Colour (8 bytes) and depth (4) of both eyes.
SIZES = ((640, 400), (1344, 1600))
WAYS = ("tcp", "ipc", "shared memory")
END = b"end"


def frame_bytes(size: tuple[int, int]) -> int:
    """Bytes of a frame."""
    return 2 * size[0] * size[1] * 12


def give(addresses: dict[str, str], block: str, most: int) -> None:
    """The other process: answer each request by a frame, the way it asks for."""
    context = zmq.Context()
    poller, sockets = zmq.Poller(), {}
    for way, address in addresses.items():
        sockets[way] = context.socket(zmq.ROUTER)
        sockets[way].setsockopt(zmq.LINGER, 0)
        sockets[way].bind(address)
        poller.register(sockets[way], zmq.POLLIN)
    shared = SharedMemory(block)
    frame = np.random.default_rng(1).integers(0, 255, most, np.uint8)
    while True:
        for socket, _ in poller.poll():
            who, ask = socket.recv_multipart()
            if ask == END:
                shared.close()
                for one in sockets.values():
                    one.close(0)
                context.term()
                return
            count = int(ask)
            if socket is sockets["shared memory"]:
                np.frombuffer(shared.buf, np.uint8, count)[:] = frame[:count]
                socket.send_multipart([who, b"there"])
            else:
                # As the server does: one message of bytes, which the library sends without a copy.
                socket.send_multipart([who, frame[:count].tobytes()], copy=False)


def main() -> None:
    """Measure and print."""
    wanted = argparse.ArgumentParser(description=__doc__)
    wanted.add_argument("--times", type=int, default=60)
    times = wanted.parse_args().times
    most = max(map(frame_bytes, SIZES))
    folder = tempfile.TemporaryDirectory()
    addresses = {"tcp": "tcp://127.0.0.1:5599", "ipc": f"ipc://{folder.name}/frames"}
    addresses["shared memory"] = f"ipc://{folder.name}/told"
    shared = SharedMemory(create=True, size=most)
    other = multiprocessing.get_context("spawn").Process(target=give, args=(addresses, shared.name, most))
    other.start()
    context = zmq.Context()
    sockets = {}
    for way, address in addresses.items():
        sockets[way] = context.socket(zmq.DEALER)
        sockets[way].setsockopt(zmq.LINGER, 0)
        sockets[way].connect(address)
    took: dict[tuple[str, tuple[int, int]], list[float]] = {}
    for number in range(times + 5):
        for size in SIZES:
            for way in WAYS:
                count = frame_bytes(size)
                begun = time.perf_counter()
                sockets[way].send(str(count).encode())
                answer = sockets[way].recv()
                # The client reads every byte once, as an upload does.
                data = np.frombuffer(shared.buf if way == "shared memory" else answer, np.uint8, count)
                np.add.reduce(data[: count - count % 8].view(np.uint64))
                if number >= 5:
                    took.setdefault((way, size), []).append(time.perf_counter() - begun)
                del data
    sockets["tcp"].send(END)
    other.join()
    for one in sockets.values():
        one.close(0)
    context.term()
    shared.close()
    shared.unlink()
    folder.cleanup()
    print(f"| pixels of one eye | {' | '.join(WAYS)} | ipc / tcp | shared memory / ipc |")
    print("| --- |" + " --- |" * (len(WAYS) + 2))
    for size in SIZES:
        tcp, ipc, memory = (statistics.median(took[way, size]) for way in WAYS)
        cells = " | ".join(f"{one * 1e3:.2f} ms" for one in (tcp, ipc, memory))
        print(f"| {size[0]}x{size[1]} | {cells} | {ipc / tcp:.2f} | {memory / ipc:.2f} |")


if __name__ == "__main__":
    main()
