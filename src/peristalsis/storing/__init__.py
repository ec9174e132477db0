"""How runs survive on disk, and how it is verified that they did."""
