"""Runs cases on the machines of a Dask cluster; each file that they need crosses once."""

from __future__ import annotations

import asyncio
import concurrent.futures
import logging
import os
import pickle
import re
import threading
import uuid
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import attrs

from ...errors import HmdwarpError, InputError, MachineError
from ...options.declared import HOW
from ...options.identity import files_at, hash_of_files, is_place, whole_program_hash
from ...resources import import_extra
from .options import LOCAL
from .sweep_case import Failure, Result, Say, SweepCase, Work, groups_of, run_group

RUN_AGAIN = 2  # times that a case is run again because its worker died
CONNECT_S = 30.0
Outcome = tuple[SweepCase, Result | Failure]
_one_at_a_time = threading.Lock()


def run_on_cluster(
    work: Work, cases: Sequence[SweepCase], cluster: str, say: Say, *, in_turn: bool = False
) -> Iterator[Outcome]:
    """Yield each case with its result or failure as it comes back.

    cluster: as --cluster. in_turn: one group after the other, each on the worker that ran the one
    before it, for as long as that lives. Errors: InputError for files too large to cross;
    MachineError for a cluster that cannot be reached, that is lost, or whose workers have another
    program.
    """
    distributed: Any = import_extra("distributed", "dask.distributed", "cluster")
    for name in [*logging.root.manager.loggerDict]:
        if name.partition(".")[0] == "distributed":
            log = logging.getLogger(name)
            log.handlers, log.propagate = [logging.NullHandler()], False
    with _connected(distributed, cluster, say) as client:
        for name, found in client.run(_program, on_error="return").items():
            if found != whole_program_hash():
                raise MachineError(_other_program(name))
        sender, waiting = _Sender(client, work), deque(groups_of(cases))
        # Groups sent and not back: one for each worker here, as what waits on a worker counts as
        # run there when that dies of another. A scheduler elsewhere gets all: it may start workers.
        local = re.fullmatch(LOCAL, cluster)
        ahead = 1 if in_turn else int(local[1]) if local else len(waiting)
        completed = distributed.as_completed(
            [sender.send(waiting.popleft()) for _ in range(min(ahead, len(waiting)))], loop=client.loop
        )
        try:
            for future in completed:
                if future.status in ("pending", "lost"):  # its worker died with the result: it is run again
                    completed.add(future)
                    continue
                yield from _outcomes(distributed, future, sender.sent.pop(future), cluster)
                if waiting:
                    # In turn: a task runs where what it depends on lies.
                    before = future if in_turn and future.status == "finished" else None
                    completed.add(sender.send(waiting.popleft(), before))
                future.release()
        except (OSError, asyncio.CancelledError, concurrent.futures.CancelledError) as error:
            raise _lost(cluster) from error
        finally:
            with suppress(Exception):  # of a scheduler that is gone
                client.cancel(list(sender.sent))


class _Sender:
    """Sends groups of cases with the files that they need, each file once."""

    def __init__(self, client: Any, work: Work) -> None:
        self._client, self._work, self._token = client, work, uuid.uuid4().hex[:8]
        self._files: dict[str, Any] = {}
        # What is under way.
        self.sent: dict[Any, list[SweepCase]] = {}

    def send(self, group: list[SweepCase], before: Any = None) -> Any:
        """Return the future of a group. Errors: InputError for files too large to cross."""
        places: dict[str, Path] = {}
        ready = [attrs.evolve(case, what=packed(case.what, places.__setitem__)) for case in group]
        for found, place in places.items():
            if found not in self._files:
                # As a task, not as data placed on a worker: it outlives any worker.
                self._files[found] = self._client.submit(bytes, bytes_of(place), key=f"hmdwarp-file-{found}")
        files, key = {found: self._files[found] for found in places}, f"hmdwarp-{group[0].identity}-{self._token}"
        task = (run_here, self._work, ready, whole_program_hash(), files, before)
        future = self._client.submit(*task, key=key, pure=False)
        self.sent[future] = group
        return future


def run_here(
    work: Work, cases: Sequence[SweepCase], program: str, files: dict[str, bytes], before: object = None
) -> list[tuple[str, Result | Failure]]:
    """Run a group of cases on a worker; return what became of each by its identity.

    before: of the group that had to run first.

    Errors: MachineError where this is another program than that of who sent it.
    """
    from distributed import get_worker

    if whole_program_hash() != program:
        raise MachineError(_other_program(get_worker().name))
    folder = Path(get_worker().local_directory) / "hmdwarp-files"
    folder.mkdir(exist_ok=True)
    folders = {found: unpack(content, folder / found) for found, content in files.items()}
    here = [attrs.evolve(case, what=unpacked(case.what, folders)) for case in cases]
    with _one_at_a_time, work.opened() as runner:  # a worker may have several threads
        return [(case.identity, outcome) for case, outcome in run_group(runner, here, lambda share: None)]


def _outcomes(distributed: Any, future: Any, group: Sequence[SweepCase], cluster: str) -> Iterator[Outcome]:
    if future.status == "cancelled":
        raise _lost(cluster)
    if future.status == "finished":
        by_identity = dict(future.result())
        yield from ((case, by_identity[case.identity]) for case in group)
        return
    error = future.exception()
    if isinstance(error, distributed.scheduler.KilledWorker):
        why = f"its worker died, and {RUN_AGAIN} more that ran it again: too little memory, or a driver that crashes"
        error = MachineError(why)
    elif not isinstance(error, HmdwarpError):
        error = MachineError(f"a worker could not run it ({type(error).__name__}: {error})")
    yield from ((case, Failure.of(case.name, error)) for case in group)


def _lost(cluster: str) -> MachineError:
    return MachineError(
        f"--cluster {cluster}: the scheduler is gone; what was done is kept: start it, and run this again with --resume"
    )


@contextmanager
def _connected(distributed: Any, cluster: str, say: Say) -> Iterator[Any]:
    """Connect to the scheduler at an address, or start one with workers on this machine."""
    import dask

    local = re.fullmatch(LOCAL, cluster)
    with dask.config.set({"distributed.scheduler.allowed-failures": RUN_AGAIN}):
        if local:
            made = distributed.LocalCluster(
                n_workers=int(local[1]),
                threads_per_worker=1,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )
        else:
            made = cluster
        try:
            client = distributed.Client(made, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise MachineError(
                f"--cluster {cluster}: no Dask scheduler there ({error}): expected local:N, or the address that "
                "'dask scheduler' prints, such as tcp://10.0.0.1:8786"
            ) from error
    try:
        say(f"dashboard: {client.dashboard_link}")
        yield client
    finally:
        client.close()
        if local:
            made.close()


def _program() -> str:
    return whole_program_hash()


def _other_program(worker: str) -> str:
    return f"worker {worker} has another hmdwarp than this machine: install the same wheel on both"


MOST_BYTES = 1 << 30  # of one trace, or of a scene with its textures
_MARK = "hmdwarp-file:"


def packed(value: Any, carry: Callable[[str, Path], None]) -> Any:
    """Return options in which marks stand for files; carry(hash, place) is called for each.

    Folders stay as they are: recorded frames are read where they lie, from a file system that all
    machines share. Errors: InputError for files that are too large to cross.
    """

    def mark(text: str | Path) -> str | Path:
        if not is_place(text) or Path(text).is_dir():
            return text
        found = hash_of_files(text)
        carry(found, Path(text))
        marked = f"{_MARK}{found}/{Path(text).name}"
        return Path(marked) if isinstance(text, Path) else marked

    return _mapped(value, mark)


def unpacked(value: Any, folders: Mapping[str, Path]) -> Any:
    """Return options with the places of the files; folders: where each hash was unpacked."""

    def place(text: str | Path) -> str | Path:
        if not str(text).startswith(_MARK):
            return text
        found, _, name = str(text).removeprefix(_MARK).partition("/")
        path = folders[found] / name
        return path if isinstance(text, Path) else str(path)

    return _mapped(value, place)


def bytes_of(place: Path) -> bytes:
    """Return the files that a place stands for, as bytes that `unpack` reads.

    Errors: InputError for more than MOST_BYTES.
    """
    files = files_at(place)
    if (total := sum(each.stat().st_size for each in files)) > MOST_BYTES:
        raise InputError(
            f"{place}: {total / 1e6:.0f} MB with the files that it names, at most {MOST_BYTES / 1e6:.0f} cross to "
            "other machines: use a smaller one"
        )
    return pickle.dumps({each.relative_to(place.parent).as_posix(): each.read_bytes() for each in files})


def unpack(content: bytes, folder: Path) -> Path:
    """Write what bytes_of returned into a folder that is made, unless it is there; return it."""
    if not folder.is_dir():
        made = folder.with_name(f".{folder.name}-{uuid.uuid4().hex[:8]}")
        for name, data in pickle.loads(content).items():
            path = made / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        try:
            made.rename(folder)
        except OSError:  # another worker was first
            if not folder.is_dir():
                raise
    return folder


def _mapped(value: Any, change: Callable[[str | Path], str | Path]) -> Any:
    if attrs.has(type(value)):
        old = {each.name: getattr(value, each.name) for each in attrs.fields(type(value)) if each.name not in HOW}
        new = {name: _mapped(each, change) for name, each in old.items()}
        changed = {name: each for name, each in new.items() if each is not old[name]}
        return attrs.evolve(value, **changed) if changed else value
    if isinstance(value, tuple | list):
        mapped = [_mapped(each, change) for each in value]
        return value if all(a is b for a, b in zip(value, mapped, strict=True)) else type(value)(mapped)
    if isinstance(value, str | os.PathLike):
        return change(value)  # type: ignore[arg-type]
    return value
