"""Settings of Hypothesis for every property test: the same in CI, under `make test` and by hand.

Without a profile Hypothesis chooses by the environment: 200 ms for an example on a desk, no limit where CI is set.
"""

from hypothesis import HealthCheck, settings

# How long a machine takes says nothing about the property, and that a strategy is slow is no fault in the product.
settings.register_profile(
    "hmdwarp",
    derandomize=True,  # the same examples in every run
    database=None,
    deadline=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("hmdwarp")

# For a test whose fixture may serve all its examples (a folder, a context): what a test names replaces the profile's list.
ONE_FIXTURE_FOR_ALL = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
