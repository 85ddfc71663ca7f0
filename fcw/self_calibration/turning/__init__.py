"""The focal length, from how the picture goes by while the car turns."""
