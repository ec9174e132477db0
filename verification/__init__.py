"""Exact problems with known answers, beside the package: run by `python -m verification` and by the tests.

Families of problems are the modules here that define PROBLEMS; `exact` holds solutions made without the package.
"""
