"""The panels of the calibration page."""
