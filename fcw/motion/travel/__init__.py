"""The direction of travel: the point in the picture that straight driving leads to."""
