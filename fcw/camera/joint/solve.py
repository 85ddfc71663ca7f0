"""One fit of all that is known about a camera: points, lines, the horizon, vehicles, the height.

Least squares over pitch, focal length, principal row, yaw, roll, height and the unknowns of the evidence.
Each has a prior, so that any of the evidence may be missing; the intervals show what that costs. All places
are converted to the straight picture (`fcw.camera.straight`), where a line along the road runs to the point
straight ahead, and a point at the distance d is in the row v(d).
"""

import math
from dataclasses import replace

import numpy as np

from fcw.camera.calibration import (
    Calibration,
    Gaussian,
    GroundPoint,
    Priors,
    matrix3,
)
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.fit import JointFit, solved
from fcw.camera.joint.known import Known
from fcw.camera.joint.plates import check_plate
from fcw.camera.joint.rectangle import check_rectangle
from fcw.camera.joint.uneven import averaged_over_spacings, tells_of_spacing
from fcw.camera.joint.unknowns import AXIS, LOG_FOCAL, LOG_HEIGHT, ROLL, START, TANGENT, YAW
from fcw.camera.lens.usual import usual_lens
from fcw.camera.points import check_priors, check_reach, check_setup, check_tape_error
from fcw.camera.prior_sigmas import ROLL_SIGMA_RAD, YAW_SIGMA_RAD
from fcw.camera.solve import row_jacobian, support_distances
from fcw.camera.straight import MOST_TURN_RAD
from fcw.camera.verdicts.period import period_doubt, widened
from fcw.errors import UserError


def calibrate_jointly(known: Known) -> Calibration:
    """Calibrate from whatever is known.

    Raises:
        UserError: a value is not valid, or nothing shows where the horizon is.
    """
    evidence, image_size, priors, lens = known.evidence, known.image_size, known.priors, known.lens
    reference_offset_m, tape_error = known.reference_offset_m, known.tape_error
    check_setup(image_size, known.height_m.value, reference_offset_m, known.click_sigma_px)
    check_priors(priors)
    check_tape_error(tape_error)
    check_reach(evidence.points)
    if not (known.rough or known.tells_of_the_road):
        raise UserError(
            "nothing tells where the road lies in the picture; give points, lane lines, the horizon, a "
            "rectangle on the road, vehicles or their number plates"
        )
    for rectangle in evidence.rectangles:
        check_rectangle(rectangle, image_size)
    for plate in evidence.plates:
        check_plate(plate, image_size)
    fit = JointFit(known)
    x, covariance = solved(known)
    if tells_of_spacing(known):
        averaged = averaged_over_spacings(known)
        x, covariance = averaged.x, averaged.covariance
    camera, orientation = fit.camera(x)
    if max(abs(orientation.yaw_rad), abs(orientation.roll_rad)) >= MOST_TURN_RAD:
        yaw_deg, roll_deg = (math.degrees(turn) for turn in (orientation.yaw_rad, orientation.roll_rad))
        raise UserError(
            f"the camera would look {yaw_deg:.0f} degrees aside and be rolled by {roll_deg:.0f}: no camera "
            "that looks ahead fits what you gave; check the marks, and that columns come before rows"
        )
    shift_m = float(x[START]) if evidence.first_unknown else 0.0
    points = tuple(
        GroundPoint(point.distance_m + shift_m, point.row_px, point.column_px) for point in evidence.points
    )
    if any(point.distance_m <= 0 for point in points):
        raise UserError(
            "the nearest mark would lie behind the reference; check the period, the order of the marks and "
            "the camera's height"
        )
    support_m = support_distances(np.array([point.distance_m for point in points]))
    support = np.array(support_m)
    rows = row_jacobian(camera, support + reference_offset_m)
    # Rows by tan(a), log(f), B and, with these fixed, log(h); the fit has v0 = B + f tan(a) and its own h.
    tangent, focal_px = math.tan(camera.pitch_rad), camera.focal_y_px
    by = np.zeros((3, len(x)))
    by[:, TANGENT] = rows[:, 0] - focal_px
    by[:, LOG_FOCAL] = rows[:, 1] - focal_px * tangent
    by[:, AXIS] = 1.0
    depths_m = support + reference_offset_m + camera.pole_m
    by[:, LOG_HEIGHT] = rows[:, 1] * (1 - camera.pole_m / depths_m)
    # Of a period the tape scales all but the first distance; of taped points all of it.
    taped_px = np.zeros(3)
    if points:
        taped_px = tape_error * (support - shift_m) * camera.row_slope_at(support + reference_offset_m)
    rows_covariance = by @ fit.with_unknown_yaw(x, covariance) @ by.T + np.outer(taped_px, taped_px)
    calibration = Calibration(
        camera,
        image_size,
        points,
        float(known.click_sigma_px),
        support_m,
        matrix3((rows_covariance + rows_covariance.T) / 2),
        float(reference_offset_m),
        priors,
        (0.0,) * len(points),
        usual_lens(image_size, priors, evidence.has_distances) if lens is None else Priors(),
        float(tape_error),
        replace(
            orientation,
            # What nothing tells of is taken as level, and known no better than that.
            yaw_sigma_rad=math.sqrt(covariance[YAW, YAW]) if fit.tells_yaw else YAW_SIGMA_RAD,
            roll_sigma_rad=math.sqrt(covariance[ROLL, ROLL]) if fit.tells_roll else ROLL_SIGMA_RAD,
        ),
        fit.lens(x),
        evidence.rectangles,
        evidence.plates,
    )
    calibration = calibration.with_residuals()
    for point, residual_px in zip(points, calibration.residuals_px, strict=True):
        if not math.isfinite(residual_px):
            raise UserError(
                f"point {point}: it would lie behind the camera that fits best; check its distance, its "
                "place in the picture, and everything else you gave"
            )
    if evidence.period_sigma_m is not None:
        return calibration
    return widened(
        calibration,
        period_doubt(calibration, _height_sigma(evidence, known.height_m), evidence.first_unknown),
    )


def _height_sigma(evidence: Evidence, height_m: Gaussian) -> float:
    """Standard deviation of the height without the period: as stated, and from the width of a lane."""
    width_m = evidence.lane_width_m
    if width_m is None or len(evidence.lines) < 2:
        return height_m.sigma
    by_lane_m = width_m.sigma / width_m.value * height_m.value
    return 1 / math.hypot(1 / height_m.sigma, 1 / by_lane_m)
