"""Cells one at a time: what a description says, runs of one cell, files of other programs in and out."""
