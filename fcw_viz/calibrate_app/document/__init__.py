"""What the user said about a camera, how it is stored, and the solution that follows from it."""
