"""Analysis of ratings: tests, intervals, order effects, copied rows, published figures."""

from .analyse import analyse, write_analysis
from .claims import Claim, Claims, checked, load_claims
from .comparisons import Resampling, compared, families_for
from .copied_rows import copied_rows
from .from_csv import SourceOptions, from_csv
from .from_store import from_contents
from .order_effects import order_effects
from .ratings import Rating, Ratings, ScaleInfo, SessionSummary, SurveyAnswer, Table
from .sources import claims_for, ratings_from

__all__ = [
    "Claim",
    "Claims",
    "Rating",
    "Ratings",
    "Resampling",
    "ScaleInfo",
    "SessionSummary",
    "SourceOptions",
    "SurveyAnswer",
    "Table",
    "analyse",
    "checked",
    "claims_for",
    "compared",
    "copied_rows",
    "families_for",
    "from_contents",
    "from_csv",
    "load_claims",
    "order_effects",
    "ratings_from",
    "write_analysis",
]
