"""Vehicles, painted."""
