"""Agents that block or open channels, and interventions on parameters: libraries, doses, and what they come to.

A dose is data of a configuration: whatever library it was taken from, a stored run holds its numbers and sources.
"""

from .effect import acts_on, check, doubtful, factor, factors, mixed, without_target
from .library import Agent, Intervention, Library, Target, library, variants
from .reading import changes_by, from_line, named, read
from .specification import CONCENTRATION, NOT_ADVICE, Dose, amount, schema

__all__ = [
    "CONCENTRATION",
    "NOT_ADVICE",
    "Agent",
    "Dose",
    "Intervention",
    "Library",
    "Target",
    "acts_on",
    "amount",
    "changes_by",
    "check",
    "doubtful",
    "factor",
    "factors",
    "from_line",
    "library",
    "mixed",
    "named",
    "read",
    "schema",
    "variants",
    "without_target",
]
