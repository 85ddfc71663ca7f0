"""Where straight driving leads to."""
