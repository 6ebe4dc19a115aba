"""Scales: one .toml file each, with its anchors, its direction and where it comes from."""

from ._load import load_scale, scale_names
from ._model import KINDS, QUESTIONNAIRE, RATING, SICKNESS, Item, Scale, Score
from ._scored import most_scored, scored

__all__ = [
    "KINDS",
    "QUESTIONNAIRE",
    "RATING",
    "SICKNESS",
    "Item",
    "Scale",
    "Score",
    "load_scale",
    "most_scored",
    "scale_names",
    "scored",
]
