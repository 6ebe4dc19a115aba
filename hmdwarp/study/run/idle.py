"""Where nothing is drawn."""

from __future__ import annotations

import attrs

from ...run.live import LiveOptions


@attrs.frozen
class Idle:
    """What live.driver.Driver wants of a stage while a watch shows no pictures: between trials there is no pipeline at all."""

    options: LiveOptions
