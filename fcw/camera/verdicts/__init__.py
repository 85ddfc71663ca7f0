"""What is likely wrong with what was said of a camera, and how it is told."""
