"""Vehicles followed from frame to frame: identity, distance, closing speed, and which one is the lead."""
