"""Many small cases as one test."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable


def together(names: str, cases: Iterable[object]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Run a test for each case as pytest's `parametrize` does, but as one test.

    For cases of less than a millisecond, because pytest adds four to each test. A failure names its
    case.
    """
    given, chosen = [name.strip() for name in names.split(",")], list(cases)

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def run(**fixtures: object) -> None:
            assert chosen, "no cases"
            for case in chosen:
                try:
                    test(**dict(zip(given, case if len(given) > 1 else (case,), strict=True)), **fixtures)
                except Exception as error:
                    error.add_note(f"case {case}")
                    raise

        there = inspect.signature(test)
        run.__signature__ = there.replace(parameters=[p for n, p in there.parameters.items() if n not in given])
        return run

    return decorate
