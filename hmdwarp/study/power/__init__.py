"""How many people a planned effect needs: simulation of the whole study and its analysis."""

from .planned_effects import planned_model, with_effect
from .proportions import Proportion, people_for, proportion_of
from .simulation import Power, PowerAt, differences, power_of, significant
from .summary import COLUMNS, name_of, power_data, power_rows, sentences

__all__ = [
    "COLUMNS",
    "Power",
    "PowerAt",
    "Proportion",
    "differences",
    "name_of",
    "people_for",
    "planned_model",
    "power_data",
    "power_of",
    "power_rows",
    "proportion_of",
    "sentences",
    "significant",
    "with_effect",
]
