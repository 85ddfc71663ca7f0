"""Which boxes are believed to be vehicles."""
