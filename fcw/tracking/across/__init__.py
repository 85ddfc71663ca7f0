"""Lateral position and lateral speed of a vehicle, also from its bearing."""
