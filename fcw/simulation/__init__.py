"""Drives with exact truth, rendered."""
