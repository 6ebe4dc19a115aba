"""Which measure of the pictures predicts their ratings best, and how certain that is."""

from .predict import LEAST_PEOPLE, MEASURES, MeasureResult, Prediction, predict
from .summary import prediction_data, sentences

__all__ = [
    "LEAST_PEOPLE",
    "MEASURES",
    "MeasureResult",
    "Prediction",
    "predict",
    "prediction_data",
    "sentences",
]
