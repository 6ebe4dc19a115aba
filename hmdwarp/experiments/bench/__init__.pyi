from .bench_run import bench as bench
from .cases import cases_of as cases_of
from .cases import combinations_of as combinations_of
from .merge import merge as merge
from .options import BenchOptions as BenchOptions
from .options import MergeOptions as MergeOptions
