"""Claims of a source scored: rules on measured numbers, the runs that they need, verdicts, and the report.

A new source is a new folder in this room with ``SOURCE = Source(...)`` in its `source.py`, or a file of yours that
calls `sources.register`; nothing else has to be told.
"""
