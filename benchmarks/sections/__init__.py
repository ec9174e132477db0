"""The sections of the bench, one file each; found by being there."""
