"""Isolated colon on the bench: what laboratories measured of it, as claims with rules."""
