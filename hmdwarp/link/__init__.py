"""The network between server and client: frames enter when drawn and come out on arrival."""

from .delays import DelayModel as DelayModel
from .delays import delay_models as delay_models
from .link import Bandwidth as Bandwidth
from .link import GilbertElliott as GilbertElliott
from .link import Link as Link
from .link import Pacer as Pacer
from .link import ResponseTime as ResponseTime
from .link import Tally as Tally
from .link import TransitStats as TransitStats
from .link import figures_of_parts as figures_of_parts
from .options import CHANGES as CHANGES
from .options import SUM as SUM
from .options import LinkOptions as LinkOptions
