"""Parameters from tracks of pellets: least squares on runs, intervals, profiles of the likelihood."""

from .observed import Observed, observed
from .parameters import Free, free_parameters
from .solution import Fit, fit

__all__ = ["Fit", "Free", "Observed", "fit", "free_parameters", "observed"]
