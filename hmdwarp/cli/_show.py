"""Plain layouts that read well in 80 columns, with more room or less."""

from __future__ import annotations

import logging
import shutil
import textwrap
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from ._signals import end_if_asked

if TYPE_CHECKING:
    from rich.console import Console

_WIDEST = 110  # longer lines are hard to read


def console(*, stderr: bool = False) -> Console:
    """A rich console; a reader that has gone is an ordinary BrokenPipeError, which the command line knows how to leave by."""
    from rich.console import Console

    class Terminal(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError

    return Terminal(stderr=stderr, highlight=False)


@contextmanager
def steps(what: str, *, quiet: bool) -> Iterator[tuple[Callable[[int, int], None], Console]]:
    """(progress(done, total), where else to print) of a long run, with a bar where a person looks on."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    logging.getLogger("matplotlib").setLevel(
        logging.ERROR
    )  # it warns where there is no home folder to keep its cache in
    screen = console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=screen, transient=True, disable=quiet or not screen.is_terminal) as bar:
        task = bar.add_task(what, total=None)

        def progress(done: int, total: int) -> None:
            end_if_asked()
            bar.update(task, completed=done, total=total)

        yield progress, screen


def sayer(quiet: bool) -> Callable[[str], None]:
    """Return what prints a sentence on stderr, or drops it."""
    return (lambda text: None) if quiet else lambda text: typer.echo(text, err=True)


def in_columns(rows: Iterable[tuple[str, str]], indent: int = 0) -> None:
    """Names on the left, their texts wrapped beside them, line by line."""
    rows = list(rows)
    left = indent + max((len(name) for name, _ in rows), default=0) + 2
    width = max(left + 24, _width())
    for name, text in rows:
        lines = [
            part for line in text.splitlines() for part in textwrap.wrap(line, width - left, break_on_hyphens=False)
        ] or [""]
        head = " " * indent + typer.style(name, bold=True) + " " * (left - indent - len(name))
        typer.echo(head + lines[0])
        for line in lines[1:]:
            typer.echo(" " * left + line)


def paragraph(text: str) -> None:
    """Text wrapped to the terminal."""
    typer.echo(textwrap.fill(text, max(24, _width()), break_on_hyphens=False))


def _width() -> int:
    return min(shutil.get_terminal_size((80, 24)).columns, _WIDEST)
