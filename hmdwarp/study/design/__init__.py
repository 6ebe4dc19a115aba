"""The plan of a study: what is shown to whom, in which order, and what is asked."""

from .nouns import (
    BLIND,
    BOTH,
    FIXED,
    NOBODY,
    ORDERS,
    PARTICIPANT,
    RANDOM,
    WILLIAMS,
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
    "BOTH",
    "FIXED",
    "NOBODY",
    "ORDERS",
    "PARTICIPANT",
    "RANDOM",
    "WILLIAMS",
    "Breaks",
    "Comparison",
    "Condition",
    "Consent",
    "Design",
    "Family",
    "Part",
    "Sickness",
]
