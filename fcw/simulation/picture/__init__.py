"""The world as the camera sees it."""
