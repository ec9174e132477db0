"""Studies made of runs: the undeformed cable, its calibration."""
