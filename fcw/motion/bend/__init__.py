"""How we turn, and how the bend grows."""
