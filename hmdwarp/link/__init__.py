"""What lies between server and client: frames enter when they are drawn and come out when they have arrived."""

from .bandwidth import Bandwidth
from .delays import DELAYS, DelayModel
from .link import Link
from .loss import GilbertElliott
from .options import LinkOptions
from .response import ResponseTime, medians
from .tally import Tally, TransitStats

__all__ = [
    "DELAYS",
    "Bandwidth",
    "DelayModel",
    "GilbertElliott",
    "Link",
    "LinkOptions",
    "TransitStats",
    "ResponseTime",
    "Tally",
    "medians",
]
