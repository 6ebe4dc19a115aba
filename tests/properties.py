"""Settings of Hypothesis for every property test: the same in CI, under `make test` and by hand.

Without a profile Hypothesis chooses by the environment: where CI is not set, an example may take
200 ms.
"""

import os

from hypothesis import HealthCheck, Phase, settings

# A slow machine or a slow strategy says nothing about the property.
settings.register_profile(
    "hmdwarp",
    max_examples=50,  # the same in every run: more of them would find a fault once, or never
    derandomize=True,  # the same examples in every run
    database=None,
    deadline=None,
    print_blob=True,
    phases=[Phase.explicit, Phase.generate] if "QUICK_FIRST" in os.environ else tuple(Phase),
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("hmdwarp")

# For a test whose fixture may serve all its examples (a folder, a context). The list of a test
# replaces the profile's.
ONE_FIXTURE_FOR_ALL = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
