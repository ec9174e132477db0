"""Settings shared by all tests. Exact problems and short runs are those of `verification`, beside the package."""

from hypothesis import settings

# Kernels compile at their first call, which no deadline of a property test should see; examples are the same
# every time, so that a failure on one machine is a failure on all.
settings.register_profile("suite", deadline=None, derandomize=True, print_blob=False)
settings.load_profile("suite")
