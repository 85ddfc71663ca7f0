"""Calibrate from three points of the road, and ask how far away a row is, with its interval.

    python examples/02_calibrate_and_ask.py

The points are the white marks on the shipped drive's road: 6, 15 and 30 m ahead of the bumper, which is 1.6 m
ahead of the camera.
"""

import fcw

marks = (6, 500.2), (15, 408.0), (30, 371.1)
points = [fcw.GroundPoint(distance_m, row_px) for distance_m, row_px in marks]
calibration = fcw.calibrate(points, fcw.ImageSize(1280, 720), height_m=1.3, reference_offset_m=1.6)

print(f"horizon at row {calibration.horizon_row_px:.1f}")
for row_px in (600, 450, 400, 370, 350):
    low_m, high_m = calibration.distance_interval(row_px)
    distance_m = calibration.distance_at(row_px)
    print(f"row {row_px}: {distance_m:.1f} m, in two of three cases {low_m:.1f} to {high_m:.1f} m")
