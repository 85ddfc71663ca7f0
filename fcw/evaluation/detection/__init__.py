"""Evaluates detectors on labelled pictures."""
