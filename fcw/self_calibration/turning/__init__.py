"""The lens from how the picture moves while the car turns."""
