"""Known answers: solutions written without the package, and short runs that many problems look at."""

from __future__ import annotations
