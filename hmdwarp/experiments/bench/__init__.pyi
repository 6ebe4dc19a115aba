from .bench_run import Rows as Rows
from .bench_run import bench as bench
from .bench_run import merge as merge
from .bench_run import read as read
from .compare_run import compare as compare
from .options import BenchOptions as BenchOptions
from .options import CompareOptions as CompareOptions
from .options import MergeOptions as MergeOptions
