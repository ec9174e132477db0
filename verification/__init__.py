"""Verification: exact problems with known answers, run by `peristalsis verify` and by the tests.

Families of problems are the modules here that define PROBLEMS; `exact` holds solutions made without the package.
"""
