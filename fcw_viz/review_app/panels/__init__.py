"""The panels of the review page."""
