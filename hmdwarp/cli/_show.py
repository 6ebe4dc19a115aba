"""Plain layouts that read well in 80 columns, with more room or less."""

from __future__ import annotations

import logging
import shutil
import textwrap
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from itertools import chain
from typing import TYPE_CHECKING, Any

import typer

from ..run.requirements import Requirements
from ._options import Said, print_results

if TYPE_CHECKING:
    from rich.console import Console

LINE_EVERY_S = 10.0  # of progress where there is no terminal
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
    steps_s: list[tuple[float, int, int]] = []  # when the first one was done and the last, with done and total

    def progress(done: int, total: int) -> None:
        bar.update(task, completed=done, total=total or None)
        if done:
            steps_s[1:] = [(time.monotonic(), done, total)]

    with bar, _lines(screen, lambda: progress_line(what, steps_s)) if bar.disable and not quiet else nullcontext():
        task = bar.add_task(what, total=None)
        yield progress, screen


def progress_line(what: str, steps_s: Sequence[tuple[float, int, int]]) -> str:
    """Return how far a run is, by its first step, which would mislead by itself, and its last."""
    if not steps_s:
        return f"{what}: still preparing"
    (began_s, first, _), (now_s, done, total) = steps_s[0], steps_s[-1]
    line = f"{what}: {done}" + (f" of {total}" if total else "")
    if done == total:
        return f"{line}; the last pictures are measured, then the results are written"
    if first < done < total:
        whole = max(1, round((now_s - began_s) / (done - first) * (total - done)))
        line += f", about {f'{whole} s' if whole < 120 else f'{round(whole / 60)} min'} to go"
    return line


@contextmanager
def _lines(screen: Console, line: Callable[[], str]) -> Iterator[None]:
    """Print a line every LINE_EVERY_S until the block ends."""
    over = threading.Event()

    def run() -> None:
        while not over.wait(LINE_EVERY_S):
            with suppress(OSError):  # the reader is gone
                screen.print(line(), soft_wrap=True)

    thread = threading.Thread(target=run, name="progress", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
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
