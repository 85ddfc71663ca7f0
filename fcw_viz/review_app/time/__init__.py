"""The time of a drive: its line, its plots, and playing it."""
