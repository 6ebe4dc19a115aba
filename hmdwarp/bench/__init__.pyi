from .bench_run import BenchResult as BenchResult
from .bench_run import bench as bench
from .options import BenchOptions as BenchOptions
