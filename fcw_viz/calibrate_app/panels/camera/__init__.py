"""What is said of the camera: height, lens, horizon."""
