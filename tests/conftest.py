"""Settings shared by all tests. Exact problems and short runs are those of `verification`, beside the package."""

import os

from hypothesis import settings

# Tables are as wide as the terminal says; tests are not run in any terminal, whatever the environment they came from.
os.environ.pop("COLUMNS", None)

# Kernels compile at their first call, which no deadline of a property test should see; examples are the same
# every time, so that a failure on one machine is a failure on all.
settings.register_profile("suite", deadline=None, derandomize=True, print_blob=False)
settings.load_profile("suite")
