"""Plain layouts that read well in 80 columns, with more room or less."""

from __future__ import annotations

import logging
import shutil
import textwrap
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from itertools import chain
from typing import TYPE_CHECKING, Any

import typer

from ..run.requirements import Requirements
from ._options import Said, print_results
from ._signals import end_if_asked

if TYPE_CHECKING:
    from rich.console import Console

LINE_EVERY_S = 10.0  # of progress where there is no terminal
ESTIMATE_AFTER_S = 3.0
_WIDEST = 110  # longer lines are hard to read


def console(*, stderr: bool = False) -> Console:
    """Return a rich console whose gone reader is a BrokenPipeError, by which we leave."""
    from rich.console import Console

    class Terminal(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError

    return Terminal(stderr=stderr, highlight=False)


@contextmanager
def steps(what: str, *, quiet: bool) -> Iterator[tuple[Callable[[int, int], None], Console]]:
    """Give (progress(done, total), where else to print) of a long run.

    On a terminal a bar shows it, elsewhere a line every LINE_EVERY_S.
    """
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    # It warns where there is no home folder to keep its cache in.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    screen = console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    bar = Progress(*columns, console=screen, transient=True, disable=quiet or not screen.is_terminal)
    lines = _Lines(what)
    with bar, lines.printed(screen) if bar.disable and not quiet else nullcontext():
        task = bar.add_task(what, total=None)

        def progress(done: int, total: int) -> None:
            end_if_asked()
            bar.update(task, completed=done, total=total or None)
            lines.update(done, total, time.monotonic())

        yield progress, screen


class _Lines:
    """Progress in lines of text. The first comes as soon as the first steps allow an estimate."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._began: tuple[float, int] | None = None
        self._now: tuple[float, int, int] | None = None
        self._estimated = threading.Event()

    def update(self, done: int, total: int, now_s: float) -> None:
        if self._began is None and done:
            self._began = now_s, done  # the first step warms up caches and shaders: it would mislead
        self._now = now_s, done, total
        if self._began is not None and now_s - self._began[0] >= ESTIMATE_AFTER_S:
            self._estimated.set()

    def line(self) -> str:
        if self._began is None or self._now is None:
            return f"{self._what}: still preparing"
        (began_s, first), (now_s, done, total) = self._began, self._now
        line = f"{self._what}: {done}" + (f" of {total}" if total else "")
        if done == total:
            return f"{line}; the last pictures are measured, then the results are written"
        if first < done < total:
            whole = max(1, round((now_s - began_s) / (done - first) * (total - done)))
            line += f", about {f'{whole} s' if whole < 120 else f'{round(whole / 60)} min'} to go"
        return line

    @contextmanager
    def printed(self, screen: Console) -> Iterator[None]:
        """Print lines until the block ends."""
        over = threading.Event()

        def run() -> None:
            self._estimated.wait(LINE_EVERY_S)
            while not over.is_set():
                with suppress(OSError):  # the reader is gone
                    screen.print(self.line(), soft_wrap=True)
                over.wait(LINE_EVERY_S)

        thread = threading.Thread(target=run, name="progress", daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            self._estimated.set()
            thread.join()


def sayer(quiet: bool) -> Callable[[str], None]:
    """Return what prints a sentence on stderr, or drops it."""
    return (lambda text: None) if quiet else lambda text: typer.echo(text, err=True)


def run_experiment(
    run: Callable[..., Any],
    what: str,
    tell: Callable[[Any], None],
    *options: Any,
    said: Said,
    required: Requirements | None = None,
) -> None:
    """Run an experiment in steps of `what`, tell what was found, raise what failed."""
    if required is not None:
        required.prepare(force=options[0].force)
    with steps(what, quiet=said["quiet"]) as (progress, _):
        result = run(*options, progress, sayer(said["quiet"]))
    print_results(said, result.data, lambda: tell(result), result.report)
    result.raise_failures()
    if required is not None:
        required.end(required.judge(result.data["rows"]))


def in_columns(rows: Iterable[tuple[str, str]], indent: int = 0) -> None:
    """Names on the left, their texts wrapped next to them, line by line."""
    rows = list(rows)
    left = indent + max((len(name) for name, _ in rows), default=0) + 2
    width = max(left + 24, _width())
    for name, text in rows:
        wrapped = (textwrap.wrap(line, width - left, break_on_hyphens=False) for line in text.splitlines())
        head = " " * indent + typer.style(name, bold=True) + " " * (left - indent - len(name))
        typer.echo(head + f"\n{' ' * left}".join(chain.from_iterable(wrapped)))


def paragraph(text: str) -> None:
    """Text wrapped to the terminal."""
    typer.echo(textwrap.fill(text, max(24, _width()), break_on_hyphens=False))


def _width() -> int:
    return min(shutil.get_terminal_size((80, 24)).columns, _WIDEST)
