"""Runs many drives: finds them and their calibrations, spreads them over workers, and records the results.

A finished drive has a `batch.json` in its folder, which is written last. It identifies what was run by
content, calibration, model and options, so that a batch that was stopped, or is run again with more drives,
does only what is left.
"""
