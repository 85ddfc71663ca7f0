"""Training the detector on labelled pictures."""
