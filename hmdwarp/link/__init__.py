"""The network between server and client: frames enter when drawn and come out on arrival."""

from .bandwidth import Bandwidth, Pacer
from .delays import DelayModel, delay_models
from .link import Link
from .loss import GilbertElliott
from .options import CHANGES, RESOLUTION, LinkOptions
from .overload import SCALES, Overload, scaled_size
from .response import ResponseTime, StageTimes, figures_of_parts, response_figures
from .tally import Tally, TransitStats

__all__ = [
    "CHANGES",
    "RESOLUTION",
    "SCALES",
    "delay_models",
    "Bandwidth",
    "DelayModel",
    "GilbertElliott",
    "Link",
    "LinkOptions",
    "Overload",
    "scaled_size",
    "Pacer",
    "TransitStats",
    "ResponseTime",
    "StageTimes",
    "Tally",
    "figures_of_parts",
    "response_figures",
]
