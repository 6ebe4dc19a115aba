"""One case of a set: what is run, kept and run again by itself, and how a group of them is run."""

from __future__ import annotations

import itertools
import platform
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from typing import Any, ClassVar, Protocol

import attrs

from ..errors import InputError
from .identity import identity_of
from .kept_cases import Failure, Result

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
    def of(cls, kind: str, name: str, what: Any, **about: Any) -> SweepCase:
        """Return a case with its identity. Errors: InputError for a file that cannot be read."""
        try:
            return cls(name, what, identity_of(kind, what), **about)
        except OSError as error:
            raise InputError(f"{error.filename}: cannot read ({error.strerror}): {name} is made with it") from error


# Runs cases one by one; yields each with its result.
Runner = Callable[[Sequence[SweepCase], Step], Iterator[tuple[SweepCase, Result]]]


class Work(Protocol):
    """How the cases of a command are run. It crosses to other machines by pickle."""

    # Whether the cases of a group are computed together; else one that fails leaves the others.
    together: ClassVar[bool]

    def opened(self) -> AbstractContextManager[Runner]:
        """Open what cases share, such as measuring processes."""
        ...


def run_group(
    work: Work, runner: Runner, cases: Sequence[SweepCase], step: Step
) -> Iterator[tuple[SweepCase, Result | Failure]]:
    """Run cases of one group; yield each as it is done, those that failed with the reason."""
    for chosen in [cases] if work.together else [[case] for case in cases]:
        left = {case.identity: case for case in chosen}
        try:
            for case, result in runner(chosen, step):
                del left[case.identity]
                yield case, attrs.evolve(result, where=platform.node())
        except Exception as error:
            yield from ((case, Failure.of(case.name, error)) for case in left.values())


def groups_of(cases: Sequence[SweepCase]) -> list[list[SweepCase]]:
    """Return cases that follow each other in one group together; each without a group by itself."""
    return [list(group) for _, group in itertools.groupby(cases, key=lambda case: case.group or case.identity)]
