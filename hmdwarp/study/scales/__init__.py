"""Scales: one .toml file each, with anchors, direction and source."""

from ._load import FOLDER, load_scale, scale_names
from ._scale_model import (
    KINDS,
    QUESTIONNAIRE,
    RATING,
    SICKNESS,
    AnswerRange,
    Item,
    Scale,
    Score,
    most_scored,
    number_text,
    range_text,
    scored,
)

__all__ = [
    "FOLDER",
    "KINDS",
    "QUESTIONNAIRE",
    "RATING",
    "SICKNESS",
    "AnswerRange",
    "Item",
    "Scale",
    "Score",
    "load_scale",
    "most_scored",
    "number_text",
    "range_text",
    "scale_names",
    "scored",
]
