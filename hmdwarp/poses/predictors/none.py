"""No prediction: the last known pose."""

from . import Predictor, hold, predictors

predictors.register(Predictor("none", "the last known pose is held", "the baseline of every predictor", hold))
