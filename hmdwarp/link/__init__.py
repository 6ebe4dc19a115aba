"""The network between server and client: frames enter when drawn and come out on arrival."""

from .delays import DelayModel, delay_models
from .link import Bandwidth, GilbertElliott, Link, Pacer
from .options import CHANGES, RESOLUTION, SCALES, LinkOptions, Overload, scaled_size
from .response import ResponseTime, StageTimes, Tally, TransitStats, figures_of_parts, response_figures

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
