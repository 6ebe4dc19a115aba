"""Options of every run that is a set of cases."""

from __future__ import annotations

import attrs

from ..options import Declared, option


@attrs.frozen(kw_only=True)
class SweepOptions(Declared):
    """How a set of cases is run."""

    resume: bool = option(False, "Go on with the run in this folder: only cases that are missing or failed are run.")
