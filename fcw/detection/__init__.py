"""Detectors: vehicles seen from behind, found in one picture."""
