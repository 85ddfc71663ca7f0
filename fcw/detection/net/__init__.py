"""The detector of two small convolutional nets: one glances at the picture, the other looks closer.

The first sees the whole picture and, of what is far, bands along the horizon at finer scales. Where these lie
and how high they are follows from the calibration: a vehicle that looks small stands far away, and so near
the horizon. The second judges each vehicle that the first proposes, and says where exactly it stands.
"""
