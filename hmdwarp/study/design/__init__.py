"""The plan of a study: what is shown to whom, in which order, and what is asked."""

from .nouns import (
    BLIND,
    NOBODY,
    ORDERS,
    PARTICIPANT,
    Breaks,
    Comparison,
    Condition,
    Consent,
    Design,
    Family,
    Part,
    Sickness,
)

__all__ = [
    "BLIND",
    "NOBODY",
    "ORDERS",
    "PARTICIPANT",
    "Breaks",
    "Comparison",
    "Condition",
    "Consent",
    "Design",
    "Family",
    "Part",
    "Sickness",
]
