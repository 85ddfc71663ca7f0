"""What a detector is worth on labelled pictures."""
