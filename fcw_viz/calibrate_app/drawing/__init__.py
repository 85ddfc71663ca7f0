"""What is drawn over the picture, and the figures beside it."""
