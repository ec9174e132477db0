"""Numerical methods that know no biology: compiled kernels, banded systems, rates, transfers."""
