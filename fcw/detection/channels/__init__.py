"""What the detectors see of a picture: aggregated channels, octave by octave and level by level."""
