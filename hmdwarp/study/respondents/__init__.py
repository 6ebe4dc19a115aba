"""Respondents: simulated participants, who answer in rehearsals, in tests and in power analyses."""

from ._base import NoRespondent, Respondent
from .cohort import Cohort, Population
from .model_files import load_model, model_from_text, model_names
from .random_draws import draw_for, person_of, table_of
from .response_model import Floats, Model, RatingModel, SicknessModel, normal, of_share, on_scale
from .simulated import Simulated

__all__ = [
    "Cohort",
    "Floats",
    "Model",
    "NoRespondent",
    "Population",
    "RatingModel",
    "Respondent",
    "SicknessModel",
    "Simulated",
    "draw_for",
    "load_model",
    "model_from_text",
    "model_names",
    "normal",
    "of_share",
    "on_scale",
    "person_of",
    "table_of",
]
