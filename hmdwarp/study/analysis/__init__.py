"""What ratings say, and what they do not."""

from .ratings import Felt, Measure, Rating, Ratings, Sitting, Table

__all__ = ["Felt", "Measure", "Rating", "Ratings", "Sitting", "Table"]
