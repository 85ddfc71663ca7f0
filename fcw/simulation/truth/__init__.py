"""What is true of the world at an instant, and the files that hold it."""
