"""The literature's short name for constant angular velocity."""

import attrs

from . import predictors
from .constant_velocity import predictor

predictors.register(attrs.evolve(predictor, name="cav", alias_of=predictor.name))
