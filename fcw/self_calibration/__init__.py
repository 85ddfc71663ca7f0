"""Calibrates a recorded clip from what it shows: its direction of travel, its lanes and its vehicles."""
