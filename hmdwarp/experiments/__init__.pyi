from . import bench as bench
