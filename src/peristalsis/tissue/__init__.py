"""Smooth-muscle sheets: cell models, conduction, and the step that joins them."""
