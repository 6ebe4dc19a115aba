from .actual import actual_of as actual_of
from .measure import measure_study as measure_study
from .measure_options import MeasureOptions as MeasureOptions
