from .compare_run import compare as compare
from .compare_run import start_bytes as start_bytes
from .compare_run import unfit as unfit
from .options import CompareOptions as CompareOptions
