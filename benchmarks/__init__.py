"""What the package costs: measured in one run, kept piece by piece, written as pages.

A section is a file in `sections`, found by being there. It measures through a `Bench`, which keeps every piece as soon
as it is measured, and returns figures, tables and plots, which `report` writes. Nothing here is needed by a run.
"""
