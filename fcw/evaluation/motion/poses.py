"""Speed, yaw rate and direction of travel from the true poses of a camera (KITTI's odometry format)."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fcw.bounded.files import MalformedError, read_text
from fcw.camera.ground_plane import FloatArray
from fcw.errors import UserError

POSE_FIELDS = 12
"""Numbers of a line of KITTI's poses: the rows of a 3x4 matrix."""
SLOWEST_MPS = 2.0
"""Below this speed relative errors and the direction of travel say little."""


@dataclass(frozen=True, slots=True, eq=False)
class TrueMotion:
    """What is true at each of N pictures, over the step that ends there; the first one has the second's.

    Attributes:
        speeds_mps: (N,).
        yaw_rates_radps: (N,) positive to the left.
        pitch_rad: of the camera's axis below the direction of travel, in the mean of the drive.
        yaw_rad: of the axis to the left of the direction of travel, likewise; bends push it to and fro.
    """

    speeds_mps: FloatArray
    yaw_rates_radps: FloatArray
    pitch_rad: float
    yaw_rad: float


def read_poses(path: Path) -> FloatArray:
    """(N, 3, 4) poses, camera to the first camera (x right, y down, z forward).

    Raises:
        UserError: the file cannot be read, or is not made of lines of twelve numbers.
    """
    try:
        lines = [line.split() for line in read_text(path).splitlines() if line.strip()]
    except (OSError, MalformedError) as error:
        raise UserError(f"--poses {path}: cannot be read ({error})") from None
    rows = []
    for number, fields in enumerate(lines, 1):
        try:
            row = [float(field) for field in fields]
        except ValueError:
            row = []
        if len(row) != POSE_FIELDS or not all(map(math.isfinite, row)):
            raise UserError(
                f"--poses {path}, line {number}: expected {POSE_FIELDS} numbers, the rows of a 3x4 matrix"
            )
        rows.append(row)
    if len(rows) < 2:
        raise UserError(f"--poses {path}: {len(rows)} poses; expected one for each picture, at least two")
    return np.array(rows).reshape(-1, 3, 4)


def true_motion(poses: FloatArray, times_s: FloatArray) -> TrueMotion:
    """What poses say.

    Args:
        poses: (N, 3, 4).
        times_s: (N,) of the pictures, rising.
    """
    rotations, steps_s = poses[:, :, :3], np.diff(times_s)
    moved = np.einsum("nji,nj->ni", rotations[:-1], np.diff(poses[:, :, 3], axis=0))
    turned = np.einsum("nji,njk->nik", rotations[:-1], rotations[1:])
    speeds_mps = np.linalg.norm(moved, axis=1) / steps_s
    yaw_rates = -np.arctan2(turned[:, 0, 2], turned[:, 2, 2]) / steps_s
    travels = moved[speeds_mps > SLOWEST_MPS].sum(axis=0)
    return TrueMotion(
        np.concatenate((speeds_mps[:1], speeds_mps)),
        np.concatenate((yaw_rates[:1], yaw_rates)),
        math.atan2(-travels[1], travels[2]),
        math.atan2(travels[0], travels[2]),
    )
