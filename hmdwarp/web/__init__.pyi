from .door import MOST_REPORT as MOST_REPORT
from .door import STEPS as STEPS
from .door import Door as Door
