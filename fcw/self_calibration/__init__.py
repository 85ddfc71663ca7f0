"""Calibration of a recorded clip from what it shows: the way it leads, and the vehicles on it."""
