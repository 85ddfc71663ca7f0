"""The picture of a frame, the boxes that are corrected on it, and the road from above."""
