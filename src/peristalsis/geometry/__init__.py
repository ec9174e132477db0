"""The wall surface: grids in (z, theta) and the measure of what it encloses."""
