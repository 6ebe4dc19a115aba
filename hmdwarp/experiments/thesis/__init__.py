"""The experiments of the thesis that this project began with, run again and judged."""
