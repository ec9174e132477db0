"""Exact problems with their sources, independent solutions, and short runs that many tests look at."""
