"""Two runs of one drive on one time line, and where they differ."""
