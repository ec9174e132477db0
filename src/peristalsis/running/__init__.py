"""The loop over steps, what watches it, and what starts it."""
