from .options import BenchOptions as BenchOptions
from .run import BenchResult as BenchResult
from .run import bench as bench
