from .compare_run import MOST_SHOWN as MOST_SHOWN
from .compare_run import CompareResult as CompareResult
from .compare_run import compare as compare
from .fitness import start_bytes as start_bytes
from .fitness import unfit as unfit
from .options import CompareOptions as CompareOptions
