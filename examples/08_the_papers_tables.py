"""The paper's equations and tables, each by the call that has it here, beside the paper's own numbers.

    python examples/08_the_papers_tables.py

Lu, Yuan and Wang, Forward Vehicle Collision Warning Based on Quick Camera Calibration. docs/theory.md
tells what is confirmed and what is corrected. Table 3 (detection) is measured by `fcw evaluate detection` and
`fcw bench`.
"""

import fcw
from fcw.camera.ground_plane import GroundPlaneCamera

SIZE, HEIGHT_M = fcw.ImageSize(1280, 720), 1.225
POINTS = [fcw.GroundPoint(4, 461), fcw.GroundPoint(5, 428), fcw.GroundPoint(7, 383)]

print("Eq. 3 solved for three points: the paper has pitch 0.1194 rad, f 1094.3 px, axis at row 363.3")
for offset_m in (0.0, 2.29):
    camera = fcw.calibrate(POINTS, SIZE, HEIGHT_M, reference_offset_m=offset_m, exact=True).camera
    print(
        f"  taped from {offset_m:.2f} m ahead of the camera: pitch {camera.pitch_rad:.4f} rad, "
        f"f {camera.focal_y_px:.1f} px, axis at row {camera.principal_row_px:.1f}"
    )

print("Eq. 3 with the paper's result: its own points, then again")
paper = GroundPlaneCamera(0.1194, 1094.313, 363.331, HEIGHT_M, 639.5)
for point in POINTS:
    print(
        f"  row {point.row_px}: {point.distance_m} m taped, {paper.distance_at(point.row_px):.2f} m by eq. 3"
    )

print("Table 1, eq. 4: the row of a distance")
for distance_m, row_px in (5, 482), (10, 325), (20, 260):
    print(f"  {distance_m} m: row {row_px} in the paper, {paper.row_at(distance_m):.0f} by eq. 4")

print("Table 2: errors grow with the distance, for a pixel is more of it")
for distance_m, error in (5, 0.0), (7, 0.0029), (9, 0.0089), (11, 0.01), (15, 0.0173), (17, 0.0182):
    pixel = paper.distance_at(paper.row_at(distance_m) - 1) / distance_m - 1
    print(f"  {distance_m} m: {error:.2%} off in the paper; one pixel is {pixel:.2%}")
