"""A calibration of the camera from the orientation of the mount that a drive has learned.

A drive shows where the camera looks: the row of the horizon and the yaw. It shows the roll only as well as
kerbs and verges allow, which is hardly ever enough to use it, and nothing of the lens. In a calibration, all
of them are
correlated: a better known horizon improves the focal length if both came from the same clicks. So the
    horizon's row is one more measurement (Kalman 1960). If it contradicts the calibration, the mount was
    moved: the old horizon is dropped, and the lens stays as it was.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, Priors, matrix3
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.prior_sigmas import ROLL_SIGMA_RAD, YAW_SIGMA_RAD
from fcw.camera.solve import row_jacobian
from fcw.camera.straight import Orientation, real_column, straight_column, turn
from fcw.errors import UserError
from fcw.motion.settings import MotionSettings
from fcw.motion.state import Mount
from fcw.motion.travel.looks import CONTRADICTED_SIGMAS

LEAST_SIGMA_RAD = math.radians(0.1)
"""Least 1-sigma of an angle from a drive, as the road ahead is not exactly parallel to the direction of
travel."""
MOVED_SIGMAS = 3.0
"""An angle that differs by more than this contradicts the calibration."""
TOLD_PART = 0.5
"""A drive gives an angle if its sigma at the end is below this fraction of its sigma at the start."""
HORIZON, FOCAL, AXIS = range(3)
"""Indices of the fused quantities: row of the horizon, log focal length, and row of the axis."""


@dataclass(frozen=True, slots=True)
class Learned:
    """A calibration as a drive corrected it.

    Attributes:
        calibration: for the pictures as the camera takes them.
        moved: whether the drive contradicts the pitch of the old calibration, which was then dropped.
    """

    calibration: Calibration
    moved: bool


def calibration_of_mount(calibration: Calibration, mount: Mount, name: str) -> Learned:
    """The calibration updated with the mount. Its clicks belong to another orientation, and are dropped.

    Args:
        calibration: the calibration of the drive's straightened pictures, from its log.
        mount: the mount of the straightened camera, as estimated at the drive's end.
        name: name of the drive, for messages.

    Raises:
        UserError: the log does not say how its pictures were straightened, or the drive shows too little.
    """
    undone, settings = calibration.undone, MotionSettings()
    if undone is None:
        raise UserError(
            f"{name}: this log, of an older version, does not say whether its pictures were straightened, "
            "so no calibration of the camera can be made from it; run the drive again with `fcw run`"
        )
    camera = calibration.camera
    pitch = _told(
        mount.pitch_rad, mount.pitch_sigma_rad, camera.pitch_rad, settings.calibration_pitch_sigma_rad
    )
    if pitch is None:
        raise UserError(
            f"{name}: the drive tells too little about the camera's pitch (known to "
            f"{math.degrees(mount.pitch_sigma_rad):.2f} degrees at its end, and to "
            f"{math.degrees(settings.calibration_pitch_sigma_rad):.2f} at its start: the car stands, or the "
            "drive is dark or short); keep the calibration that you have, or take a longer drive by day"
        )
    straight, covariance, moved = _with_horizon(calibration, pitch)
    before = undone.orientation
    yaw = _fused(
        Gaussian(0.0, before.yaw_sigma_rad or YAW_SIGMA_RAD),
        _told(mount.yaw_rad, mount.yaw_sigma_rad, 0.0, settings.calibration_yaw_sigma_rad),
    )
    roll = _fused(
        Gaussian(0.0, before.roll_sigma_rad or ROLL_SIGMA_RAD),
        _told(mount.roll_rad, mount.roll_sigma_rad, 0.0, settings.calibration_roll_sigma_rad),
    )
    pitch_rad, yaw_rad, roll_rad = _turned(
        camera.pitch_rad, before, straight.pitch_rad, yaw.value, roll.value
    )
    orientation = Orientation(yaw_rad, roll_rad, yaw.sigma, roll.sigma)
    real = replace(straight, pitch_rad=pitch_rad, principal_column_px=real_column(camera, before))
    learned = replace(
        calibration,
        camera=replace(real, principal_column_px=straight_column(real, orientation)),
        points=(),
        residuals_px=(),
        rectangles=(),
        plates=(),
        covariance=matrix3(covariance),
        priors=Priors(),
        orientation=orientation,
        lens=undone.lens,
        undone=None,
    )
    return Learned(learned, moved)


def _told(believed_rad: float, sigma_rad: float, began_rad: float, began_sigma_rad: float) -> Gaussian | None:
    """An angle from the drive alone; None if the drive shows too little.

    The estimate at the end includes the prior at the start, which is no measurement. It is removed again,
    unless the drive contradicted it so much that nothing of it is left.
    """
    if sigma_rad > TOLD_PART * began_sigma_rad:
        return None
    if abs(believed_rad - began_rad) > CONTRADICTED_SIGMAS * began_sigma_rad:
        return Gaussian(believed_rad, math.hypot(sigma_rad, LEAST_SIGMA_RAD))
    precision, began = max(sigma_rad, LEAST_SIGMA_RAD / 10) ** -2, began_sigma_rad**-2
    told_rad = (precision * believed_rad - began * began_rad) / (precision - began)
    return Gaussian(told_rad, math.hypot((precision - began) ** -0.5, LEAST_SIGMA_RAD))


def _moved(apart: float, first_sigma: float, second_sigma: float) -> bool:
    return abs(apart) > MOVED_SIGMAS * math.hypot(first_sigma, second_sigma)


def _fused(before: Gaussian, told: Gaussian | None) -> Gaussian:
    """Two measurements of one angle combined; if they contradict each other, that of the drive."""
    if told is None:
        return before
    if _moved(told.value - before.value, before.sigma, told.sigma):
        return told
    precisions = before.sigma**-2, told.sigma**-2
    value = (precisions[0] * before.value + precisions[1] * told.value) / sum(precisions)
    return Gaussian(value, sum(precisions) ** -0.5)


def _with_horizon(calibration: Calibration, pitch: Gaussian) -> tuple[GroundPlaneCamera, FloatArray, bool]:
    """The straightened camera with the new pitch, covariance of its support rows, and whether it moved."""
    camera = calibration.camera
    support_m = np.array(calibration.support_distances_m) + calibration.reference_offset_m
    by_rows = _by_unknowns(camera) @ np.linalg.inv(row_jacobian(camera, support_m))
    covariance = by_rows @ np.array(calibration.covariance) @ by_rows.T
    tangent = math.tan(pitch.value)
    told_px = camera.principal_row_px - camera.focal_y_px * tangent
    sigma_px = camera.focal_y_px * (1 + tangent**2) * pitch.sigma
    apart_px = told_px - camera.horizon_row_px
    moved = _moved(apart_px, math.sqrt(covariance[HORIZON, HORIZON]), sigma_px)
    if moved:
        shift = np.array((apart_px, 0.0, 0.0))
        covariance[HORIZON, :] = covariance[:, HORIZON] = 0.0
        covariance[HORIZON, HORIZON] = sigma_px**2
    else:
        gain = covariance[:, HORIZON] / (covariance[HORIZON, HORIZON] + sigma_px**2)
        shift = gain * apart_px
        covariance = covariance - np.outer(gain, covariance[HORIZON])
    focal_px = camera.focal_y_px * math.exp(shift[FOCAL])
    axis_px = camera.principal_row_px + float(shift[AXIS])
    pitch_rad = math.atan((axis_px - camera.horizon_row_px - float(shift[HORIZON])) / focal_px)
    after = replace(camera, pitch_rad=pitch_rad, focal_y_px=focal_px, principal_row_px=axis_px)
    rows = row_jacobian(after, support_m) @ np.linalg.inv(_by_unknowns(after))
    covariance = rows @ covariance @ rows.T
    return after, (covariance + covariance.T) / 2, moved


def _by_unknowns(camera: GroundPlaneCamera) -> FloatArray:
    """(3, 3) derivatives of the fused quantities by the unknowns of `row_jacobian`."""
    tangent, focal_px = math.tan(camera.pitch_rad), camera.focal_y_px
    return np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [focal_px, focal_px * tangent, 1.0]])


def _turned(
    calibrated_rad: float, before: Orientation, pitch_rad: float, yaw_rad: float, roll_rad: float
) -> tuple[float, float, float]:
    """Pitch, yaw and roll of the real camera.

    Args:
        calibrated_rad: pitch of the real camera when its pictures were straightened.
        before: its yaw and roll then.
        pitch_rad: present pitch of the straightened camera.
        yaw_rad: present yaw of the straightened camera.
        roll_rad: present roll of the straightened camera.
    """
    straight = turn(pitch_rad, Orientation(yaw_rad, roll_rad)) @ turn(calibrated_rad, before)
    sine, cosine = math.sin(pitch_rad), math.cos(pitch_rad)
    level = np.array([[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]]) @ straight
    return (
        math.asin(level[1, 2]),
        math.atan2(-level[0, 2], level[2, 2]),
        math.atan2(level[1, 0], level[1, 1]),
    )
