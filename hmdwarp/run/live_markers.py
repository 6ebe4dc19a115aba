"""Markers of a live run: what other recorders want to know, at the instants of its pictures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .markers import Markers, Say, check_received


class LiveMarkers:
    """Send the markers of a live run.

    What happens between two pictures is stamped with the instant at which the second is seen: from
    there on it shows.
    """

    def __init__(self, markers: Markers, say: Say = lambda text: None) -> None:
        """Send to `markers`. say: called with a sentence where no program receives them."""
        self._markers, self._say = markers, say
        self._pending: list[tuple[str, dict[str, Any]]] = []
        self._last_ns: int | None = None  # when the last picture is seen
        self._pictures = 0
        self._settings_known = False  # to a program that receives the markers

    def picture(self, shown_ns: int, settings: Mapping[str, object]) -> None:
        """Add a picture: when it is seen, and the value of each control."""
        if self._last_ns is None:
            check_received(self._markers, self._say)
            self._markers.send("run_start", shown_ns, **settings)
            self._settings_known = self._markers.are_received
        elif not self._settings_known and self._markers.are_received:
            self._markers.send("settings", shown_ns, pictures=self._pictures, **settings)
            self._settings_known = True
        for event, data in self._pending:
            self._markers.send(event, shown_ns, **data)
        self._pending.clear()
        self._last_ns = shown_ns
        self._pictures += 1

    def missed(self, count: int) -> None:
        """Add refreshes that passed without a new picture."""
        if count and self._last_ns is not None:
            self._pending.append(("missed", {"count": count}))

    def changed(self, what: Mapping[str, list[object]], reason: str) -> None:
        """Add a change of settings: [before, after] by name. reason: "" for a change by hand."""
        if what and self._last_ns is not None:
            after = {name: value for name, (_, value) in what.items()}
            self._pending.append(("change", {**after, "reason": reason or "by hand"}))

    def on_display_lost(self, why: str) -> None:
        """Add the loss of the display, at the last picture before it."""
        if self._last_ns is not None:
            self._markers.send("display_lost", self._last_ns, why=why)

    def came_back(self) -> None:
        """Add the return of the display, at the first picture after it."""
        if self._last_ns is not None:
            self._pending.append(("display_back", {}))

    def end(self) -> None:
        """Add the end, at the last picture."""
        if self._last_ns is not None:
            self._markers.send("run_end", self._last_ns, pictures=self._pictures)
