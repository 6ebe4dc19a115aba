from .results import LEAST_PEOPLE as LEAST_PEOPLE
from .results import MEASURES as MEASURES
from .results import MeasureResult as MeasureResult
from .results import Prediction as Prediction
from .results import predict as predict
from .summary import prediction_data as prediction_data
from .summary import sentences as sentences
