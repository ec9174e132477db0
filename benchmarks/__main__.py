"""`python -m benchmarks` is the command line of this folder."""

from __future__ import annotations

import sys

from .command import main

if __name__ == "__main__":
    sys.exit(main())
