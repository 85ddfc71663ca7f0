"""Training the net: vehicles and background as it will meet them, varied far beyond the pictures at hand."""
