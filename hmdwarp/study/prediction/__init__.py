"""Which measure of the pictures predicts their ratings best, and how certain that is."""

from .measure_results import LEAST_PEOPLE, MEASURES, MeasureResult, Prediction, predict
from .prediction_text import pooled, prediction_data, sentences

__all__ = [
    "LEAST_PEOPLE",
    "MEASURES",
    "MeasureResult",
    "Prediction",
    "pooled",
    "predict",
    "prediction_data",
    "sentences",
]
