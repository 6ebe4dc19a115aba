"""Scales: one .toml file each, with anchors, direction and source."""

from ._load import FOLDER, load_scale, scale_names
from ._scale import KINDS, QUESTIONNAIRE, RATING, SICKNESS, Item, Scale, Score, most_scored, scored

__all__ = [
    "FOLDER",
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
