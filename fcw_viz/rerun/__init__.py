"""The drive log for the rerun viewer, and the viewer itself."""
