"""The ground-plane camera: row to distance and back, and its calibration with all that is known of it."""
