"""The unknowns of the joint fit: their indices, and where the iteration may start."""

import math
from contextlib import suppress

from fcw.camera.ground_plane import FloatArray
from fcw.camera.joint.known import Known
from fcw.camera.joint.plates import horizons_by_plates
from fcw.camera.joint.rectangle import seen_from
from fcw.camera.joint.rulers import horizons_by_widths
from fcw.camera.vanishing import vanishing_row
from fcw.errors import UserError

TANGENT, LOG_FOCAL, AXIS, YAW, ROLL, LOG_HEIGHT, START, LOG_FLEET, BEND, SLIP, LOG_TAPE, SLOPE = range(12)
"""Indices in every fit; after them come the unknowns of each rectangle (`fcw.camera.joint.rectangle`)."""
CAMERA_UNKNOWNS = 12
STEPS = (1e-5, 1e-5, 1e-2, 1e-5, 1e-5, 1e-5, 1e-3, 1e-5, 1e-4, 1e-5, 1e-5, 1e-5)
"""Step of each unknown for the numerical derivatives."""
START_FIRST_M = (5.0, 9.0, 18.0)
"""Distances of the first dash at which a fit starts: far dashes look like near ones through another lens."""


def camera_starts(known: Known, means: FloatArray, column_px: float) -> list[FloatArray]:
    """Starts at the means of all priors, with the horizon from the evidence and several first dashes.

    Args:
        known: what is known.
        means: means of the priors.
        column_px: principal column of the camera.
    """
    evidence, start = known.evidence, means.copy()
    horizon, lines = known.priors.horizon_row_px, evidence.lines
    if horizon is not None:
        start[TANGENT] = (start[AXIS] - horizon.value) / math.exp(start[LOG_FOCAL])
    elif len(lines) > 1:
        with suppress(UserError):
            meeting = vanishing_row(lines[0], lines[1], known.click_sigma_px)
            start[TANGENT] = (start[AXIS] - meeting.value) / math.exp(start[LOG_FOCAL])
    starts = []
    for rectangle in evidence.rectangles:
        axis_px = (column_px, float(start[AXIS]))
        for view in seen_from(rectangle, known.lens, axis_px, math.exp(start[LOG_FOCAL])):
            there = start.copy()
            there[[TANGENT, LOG_FOCAL, ROLL]] = view
            starts.append(there)
    starts = starts or [start]
    height_m, focal_px = math.exp(start[LOG_HEIGHT]), math.exp(start[LOG_FOCAL])
    if evidence.rulers:
        # A vehicle above the horizon of the start would not pull that horizon up.
        for row_px in horizons_by_widths(evidence.rulers, height_m, focal_px):
            starts.append(start.copy())
            starts[-1][TANGENT] = (start[AXIS] - row_px) / focal_px
    for row_px, by_plates_m in horizons_by_plates(evidence.plates, height_m, focal_px):
        starts.append(start.copy())
        starts[-1][TANGENT] = (start[AXIS] - row_px) / focal_px
        starts[-1][LOG_HEIGHT] = math.log(by_plates_m)
    if not evidence.first_unknown:
        return starts
    dashed = []
    for first_m in START_FIRST_M:
        for start in starts:
            there = start.copy()
            there[START] = first_m
            dashed.append(there)
    return dashed
