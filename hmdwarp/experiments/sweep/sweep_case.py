"""One case of a set: what is run, kept and run again by itself, and how a group of them is run."""

from __future__ import annotations

import itertools
import platform
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any, Protocol

import attrs

from ...errors import InputError
from .identity import identity_of
from .kept import Failure, Result

Say = Callable[[str], None]
# Takes the share of a case that is done, from 0 to 1.
Step = Callable[[float], None]


@attrs.frozen
class SweepCase:
    """One case: what is run, kept and run again by itself."""

    # For people, such as "walk, 200 ms".
    name: str
    # What its Work runs: options and plain values, which cross to other machines by pickle.
    what: Any = attrs.field(repr=False)
    identity: str
    # Cases that follow each other with the same group run on one machine, one after the other, so
    # that their times can be compared.
    group: str = ""
    # Its share of the progress.
    steps: int = 1

    @classmethod
    def of(cls, kind: str, name: str, what: Any, also: Sequence[str] = (), **about: Any) -> SweepCase:
        """Return a case with its identity.

        also: parts of the program that it depends on, as program_hash. Errors: InputError for a
        file that cannot be read.
        """
        try:
            return cls(name, what, identity_of(kind, what, also), **about)
        except OSError as error:
            raise InputError(f"{error.filename}: cannot read ({error.strerror}): {name} is made with it") from error


# Runs a case and returns its result.
Runner = Callable[[SweepCase, Step], Result]


class Work(Protocol):
    """How the cases of a command are run. It crosses to other machines by pickle."""

    def opened(self) -> AbstractContextManager[Runner]:
        """Open what cases share, such as measuring processes."""
        ...


@attrs.frozen
class Separate:
    """A Work whose cases share nothing."""

    run: Runner

    def opened(self) -> AbstractContextManager[Runner]:
        """Open nothing."""
        return nullcontext(self.run)


def run_group(runner: Runner, cases: Sequence[SweepCase], step: Step) -> Iterator[tuple[SweepCase, Result | Failure]]:
    """Run cases of one group; yield each as it is done, those that failed with the reason."""
    for case in cases:
        try:
            outcome: Result | Failure = attrs.evolve(runner(case, step), where=platform.node())
        except Exception as error:
            outcome = Failure.of(case.name, error)
        yield case, outcome


def groups_of(cases: Sequence[SweepCase]) -> list[list[SweepCase]]:
    """Return cases that follow each other in one group together; each without a group by itself."""
    return [list(group) for _, group in itertools.groupby(cases, key=lambda case: case.group or case.identity)]
