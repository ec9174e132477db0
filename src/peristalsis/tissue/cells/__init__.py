"""Cell models, one a file."""
