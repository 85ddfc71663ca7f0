"""The joint filter of all distances and the camera: what it assumes, what it believes, its arithmetic."""
