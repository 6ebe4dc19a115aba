"""Which measure of the pictures predicts their ratings best, and how certain that is."""

from .measure_results import LEAST_PEOPLE as LEAST_PEOPLE
from .measure_results import MEASURES as MEASURES
from .measure_results import MeasureResult as MeasureResult
from .measure_results import Prediction as Prediction
from .measure_results import predict as predict
from .prediction_text import pooled as pooled
from .prediction_text import prediction_data as prediction_data
from .prediction_text import sentences as sentences
