"""The figures, one per module; each module defines ``FIGURE``."""
