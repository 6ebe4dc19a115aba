"""The response time of a scene that reacts: from an input to the first picture that shows it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Any

import attrs
import numpy as np

from ..scenes import INPUT_COLUMNS, InputEvent

ANSWER_COLUMNS = (*INPUT_COLUMNS, "response_ms")


@attrs.define(eq=False)
class Answers:
    """Inputs, each with the instant when a picture first showed what came of it."""

    # When the first picture was drawn: older inputs do not count.
    since_ns: int = 0
    _last_ns: int = 0
    # Instant 0 on the clock of a file of inputs.
    epoch_ns: int = 0
    _early: list[InputEvent] = attrs.field(factory=list)
    _waiting: deque[InputEvent] = attrs.field(factory=deque)  # oldest first
    _answered: list[tuple[InputEvent, int]] = attrs.field(factory=list)

    def add(self, event: InputEvent) -> None:
        """Add an input, later than those before."""
        (self._waiting if event.time_ns >= self.since_ns else self._early).append(event)

    def see(self, shown_ns: int, shows_ns: int) -> None:
        """Take note of a picture: it shows what came of all inputs until an instant."""
        self._last_ns = shown_ns
        while self._waiting and self._waiting[0].time_ns <= shows_ns:
            self._answered.append((self._waiting.popleft(), shown_ns))

    @property
    def _ms(self) -> list[float]:
        return [(shown_ns - event.time_ns) * 1e-6 for event, shown_ns in self._answered]

    def entry(self) -> dict[str, Any]:
        """Return the `input` of summary.json: of inputs until the last picture."""
        found, waiting = self._ms, sum(event.time_ns <= self._last_ns for event in self._waiting)
        count = len(found) + waiting
        if not found:
            return {"count": count, "answered": 0}
        times = {"mean": float(np.mean(found)), "p95": float(np.percentile(found, 95)), "most": max(found)}
        return {"count": count, "answered": len(found), "response_time_ms": times}

    def note(self) -> str:
        """Return the entry as a sentence."""
        entry = self.entry()
        if "response_time_ms" not in entry:
            return f"No picture showed what came of {entry['count']} inputs."
        times = entry["response_time_ms"]
        return (
            f"Response time, from an input to the first picture drawn after it: {times['mean']:.0f} ms on average, "
            f"{times['p95']:.0f} at the 95th percentile ({entry['answered']} of {entry['count']} inputs)."
        )

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield the rows of inputs.csv, which --input takes."""
        rows: list[tuple[InputEvent, float | None]] = [(event, None) for event in self._early]
        rows += [(event, ms) for (event, _), ms in zip(self._answered, self._ms, strict=True)]
        rows += [(event, None) for event in self._waiting]
        for event, ms in rows:
            values = (event.time_ns + self.epoch_ns, event.action, event.target, *event.origin_m, *event.direction, ms)
            yield dict(zip(ANSWER_COLUMNS, values, strict=True))
