"""The detector of two small convolutional nets: one glances at the picture, the other looks closer.

The first net sees the whole picture and, at finer scales, bands along the horizon for far vehicles. Position
and height of the bands follow from the calibration, because a vehicle that looks small is far away, and so
near the horizon. The second net judges each vehicle that the first proposes, and refines its box.
"""
