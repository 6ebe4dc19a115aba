from .bench_run import BenchResult as BenchResult
from .bench_run import bench as bench
from .cases import cases_of as cases_of
from .cases import combinations_of as combinations_of
from .options import BenchOptions as BenchOptions
