"""Own motion and own path from the picture: speed, yaw rate, the camera's mount, and lane lines."""
