"""Forward collision warning from one dash camera: the science and the pipeline.

Conventions, kept everywhere in this package:

- Pixels: u right, v down; the centre of the top-left pixel is (0, 0). Boxes are x, y, w, h; the
  ground contact row of a vehicle is the bottom edge of its box.
- Vehicle axes after ISO 8855: x forward, y left, z up. Metres, seconds, radians.
- Distance is along the ground from the reference of the calibration: the camera, or the front
  bumper where the calibration states a reference offset.
- Time is in nanoseconds from the source's own clock, never a frame count.
"""

__version__ = "0.1.0"
