"""What somebody said of a camera, how it is kept, and what follows from it."""
