"""Follows vehicles by their appearance: finds an image patch in the next picture, and how much it grew."""
