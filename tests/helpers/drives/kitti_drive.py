"""A drive in the folders of KITTI tracking, made of equations."""

import math
from pathlib import Path

FOCAL_PX, U0, V0, HEIGHT_M, LENGTH_M = 720.0, 611.5, 184.5, 1.65, 4.0
SPEED_MPS = 10.0


def kitti_drive_at_a_standing_car(folder: Path, lateral_m: float) -> Path:
    """Fill the folder: in 0000 we drive straight at 10 m/s towards a standing car, from 60 m to 5 m."""
    for name in ("label_02", "calib", "poses"):
        (folder / name).mkdir()
    (folder / "calib" / "0000.txt").write_text(f"P2: {FOCAL_PX} 0 {U0} 0 0 {FOCAL_PX} {V0} 0 0 0 1 0\n")
    labels, poses = [], []
    for frame in range(56):
        rear_m = 60 - frame * SPEED_MPS / 10
        left, right = (U0 + FOCAL_PX * (-lateral_m + side) / rear_m for side in (-0.9, 0.9))
        top, bottom = (V0 + FOCAL_PX * (HEIGHT_M - up) / rear_m for up in (1.5, 0.0))
        labels.append(
            f"{frame} 7 Car 0 0 0 {left} {top} {right} {bottom} 1.5 1.8 {LENGTH_M} "
            f"{-lateral_m} {HEIGHT_M} {rear_m + LENGTH_M / 2} {-math.pi / 2}"
        )
        poses.append(f"1 0 0 0 0 1 0 0 0 0 1 {frame * SPEED_MPS / 10}")
    (folder / "label_02" / "0000.txt").write_text("\n".join(labels))
    (folder / "poses" / "0000.txt").write_text("\n".join(poses))
    return folder
