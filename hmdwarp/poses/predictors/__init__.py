"""Predictors of the head pose from known motion: one file each."""

from ._base import Predictor, hold, predictors

__all__ = ["Predictor", "hold", "predictors"]
