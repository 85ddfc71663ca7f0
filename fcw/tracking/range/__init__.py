"""The joint filter of all distances and the camera: its model, its state and its arithmetic."""
