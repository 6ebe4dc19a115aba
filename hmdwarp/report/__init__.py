"""The results of a run: summary.json, frames.csv, pictures, a video, an HTML page, a table.

The pages of a bench and of a study are in report.bench and report.study.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
