from .compare_run import MOST_SHOWN as MOST_SHOWN
from .compare_run import compare as compare
from .compare_work import start_bytes as start_bytes
from .compare_work import unfit as unfit
from .options import CompareOptions as CompareOptions
