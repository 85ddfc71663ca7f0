"""Many drives at once: which, with which calibration, on which workers, and what came of each.

A drive that is done has a `batch.json` in its folder, written last. It says by content, calibration, model
and options what was run: a batch that was stopped, or is run again with more drives, does only what is left.
"""
