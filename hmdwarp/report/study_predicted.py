"""The section of a study's page on what predicts the ratings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def prediction_of(data: Mapping[str, Any] | None) -> Mapping[str, Any] | None:
    """What the template shows; None where nothing was measured."""
    return None if data is None else data
