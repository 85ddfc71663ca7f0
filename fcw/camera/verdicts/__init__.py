"""What is probably wrong with the input of a calibration, and the words for it."""
