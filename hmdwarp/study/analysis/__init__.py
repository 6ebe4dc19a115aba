"""What ratings say, and what they do not."""

from .comparisons import Resampling
from .from_csv import Given, from_csv
from .ratings import Felt, Measure, Rating, Ratings, Sitting, Table

__all__ = ["Felt", "Given", "Measure", "Rating", "Ratings", "Resampling", "Sitting", "Table", "from_csv"]
