"""Finds the lines of the own lane in one picture, for the user to confirm or for many pictures to agree on.

`fcw.motion.lanes` finds the lane as two parallel lines on a road whose horizon it takes as known, so that
they cannot show where the horizon is. Therefore the paint of each line is searched again near the lane that
was found, and each proposed line is a straight line through its own paint.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.vanishing import PixelPoint, Segment, vanishing_row
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.motion.lanes import FAINTEST, Lane, find_lane
from fcw.motion.settings import MotionSettings
from fcw.motion.view import RoadView
from fcw.units import MAD_TO_SIGMA

DISTANCES_M = np.geomspace(7.0, 35.0, 60)
ASIDE_M = np.arange(-0.6, 0.601, 0.02)
"""How far beside the lane that was found its paint is searched."""
SIDE_STEPS = 12
"""In steps of `ASIDE_M`, a quarter of a metre: paint is brighter than the road so far to both sides."""
FEWEST_PLACES = 8
LEAST_REACH = 1.6
"""Least ratio of the farthest to the nearest distance of a line's paint; a single dash is not a line."""
INLYING_PX = 2.0
"""Paint farther than this from the straight line does not belong to it."""
PLACES_APART = 4
"""Least number of steps of `DISTANCES_M` between the two places of paint that a line is drawn through."""
TRIED_RAD = tuple(math.radians(degrees) for degrees in (0, 1, -1, 2, -2, 3, -3, 4, -4))
"""Differences from the given pitch that are tried."""
AGREEING_HEIGHTS = 0.015
"""Lines that meet farther than this from a pitch's horizon, in picture heights, contradict the pitch."""
NONE_FOUND = "no lane lines found in this picture; go to one of a straight road, or draw them"
LOOKED_FOR_RAD = (0.0, *(math.radians(sign * deg) for deg in range(1, 11) for sign in (1, -1)))
"""The same if nothing is known about the camera."""
YAWS_TRIED_RAD = tuple(math.radians(degrees) for degrees in (5, -5, 10, -10, 15, -15))
"""Yaws that are tried, for a camera that was mounted by hand and looks aside."""
YAWED_PICTURES = 12
"""Number of pictures in which they are tried; each takes half a second."""
FEWEST_LANES = 5
LEAST_ASIDE_PART = 2 / 3
"""Least part of the pictures that must show the lane aside. With half of them, kerbs and shadows met beside a
road that was straight ahead."""
LARGEST_SCATTER_HEIGHTS = 0.025
"""Lanes that scatter more than this, in picture heights, bend, and do not show where the road leads to."""
COMMON_LANE_SIGMAS_HEIGHTS = 0.004, 0.03
"""Standard deviations of column and row that all lanes of a clip have in common: from camber and slopes, and
from kerbs, bends and bonnets that are taken for lanes.

On 16 clips of strangers, lanes met at most 16 % of the picture's height from the horizon, in the median 4 %.
To the side they agreed with the direction of travel to 1 %.
"""
EVENLY_BENT_MPS = 60.0
"""At this speed the bend of a lane is assumed to be constant, so that straight lines are found."""
STRAIGHT_PER_M = 1 / 600
"""Largest curvature of a lane whose vanishing point is on the horizon."""


def propose_lane_lines(
    image_bgr: NDArray[np.uint8], camera: GroundPlaneCamera, tried_rad: Sequence[float] = TRIED_RAD
) -> tuple[Segment, Segment]:
    """The left and the right line, each from its nearest paint to its farthest.

    Args:
        image_bgr: (height, width, 3) picture.
        camera: the camera as far as it is known; height and lens may be rough, and other pitches are tried.
        tried_rad: the differences from its pitch to try; the first one that the lines agree with is used.

    Raises:
        UserError: the picture shows no lane, or one that bends.
    """
    refused: UserError | None = None
    height, width = image_bgr.shape[:2]
    factor = max(1, width // MotionSettings().working_width_px)
    small = cv2.resize(image_bgr, (width // factor, height // factor), interpolation=cv2.INTER_AREA)
    grey, small_grey = (
        np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8) for image in (image_bgr, small)
    )
    for turn_rad in tried_rad:
        tried = replace(camera, pitch_rad=camera.pitch_rad + turn_rad)
        try:
            left, right = _propose(grey, small_grey, factor, tried)
            meeting = vanishing_row(left, right, 1.0)
        except UserError as error:
            refused = refused or error
            continue
        if abs(meeting.value - tried.horizon_row_px) < AGREEING_HEIGHTS * height:
            return left, right
    raise refused or UserError(NONE_FOUND)


def _propose(
    grey: NDArray[np.uint8], small_grey: NDArray[np.uint8], factor: int, camera: GroundPlaneCamera
) -> tuple[Segment, Segment]:
    """The lines, if the camera's pitch is about right; `factor` is the ratio of the pictures' sizes."""
    lane = find_lane(small_grey, RoadView.of(camera, factor), 0.0, 0.0, EVENLY_BENT_MPS)
    if lane is None:
        raise UserError(NONE_FOUND)
    if abs(float(lane.mean[2])) > STRAIGHT_PER_M:
        raise UserError("the lane bends here, so its lines do not show the horizon; go to a straight stretch")
    view = RoadView.of(camera, 1)
    horizon_px = camera.horizon_row_px
    left, right = (_through_paint(_paint(grey, view, lane, side), horizon_px) for side in (1.0, -1.0))
    if left is None or right is None:
        raise UserError("too little of the lane lines is seen in this picture; try another one, or draw them")
    return left, right


def _paint(grey: NDArray[np.uint8], view: RoadView, lane: Lane, side: float) -> FloatArray:
    """(N, 2) columns and rows of the brightest ridge near a line of the lane, for each distance with one."""
    offset_m, heading_rad, bend_per_m, _, lane_m = (float(value) for value in lane.mean)
    line_m = offset_m + heading_rad * DISTANCES_M + bend_per_m * DISTANCES_M**2 / 2 + side * lane_m / 2
    columns, rows = view.places(line_m[:, None] + ASIDE_M, DISTANCES_M[:, None])
    values = cv2.remap(
        grey, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0
    ).astype(float)
    middle = values[:, SIDE_STEPS:-SIDE_STEPS]
    ridge = middle - np.maximum(values[:, : -2 * SIDE_STEPS], values[:, 2 * SIDE_STEPS :])
    best = np.argmax(ridge, axis=1)
    each = np.arange(len(best))
    # Take the middle of the paint, because a wide line is equally bright across.
    bright = ridge > 0.5 * ridge[each, best][:, None]
    near = np.abs(np.arange(ridge.shape[1]) - best[:, None]) <= SIDE_STEPS
    weights = np.where(bright & near, ridge, 0.0)
    seen = ridge[each, best] > FAINTEST
    total = np.maximum(weights.sum(axis=1), 1e-9)
    inner = slice(SIDE_STEPS, -SIDE_STEPS)
    places = np.column_stack(
        ((weights * columns[:, inner]).sum(axis=1) / total, (weights * rows[:, inner]).sum(axis=1) / total)
    )
    return places[seen]


def _through_paint(places: FloatArray, horizon_px: float) -> Segment | None:
    """The straight line through most of the places, from the nearest to the farthest of them."""
    first, second = np.triu_indices(len(places), PLACES_APART)
    apart = places[first, 1] - places[second, 1] >= 4 * INLYING_PX
    (u1, v1), (u2, v2) = (places[ends[apart]].T[:, :, None] for ends in (first, second))
    off_px = (places[:, 0] - u1) - (u2 - u1) / (v2 - v1) * (places[:, 1] - v1)
    near = np.abs(off_px) < INLYING_PX
    best = near[np.argmax(near.sum(axis=1))] if len(near) else np.zeros(len(places), bool)
    if best.sum() < FEWEST_PLACES:
        return None
    columns, rows = places[best, 0], places[best, 1]
    # Distances are proportional to the inverse of rows below the horizon.
    if rows.max() - horizon_px < LEAST_REACH * (rows.min() - horizon_px):
        return None
    slope, column_at_zero = np.polyfit(rows, columns, 1)
    near_px, far_px = (
        (float(column_at_zero + slope * row_px), float(row_px)) for row_px in (rows.max(), rows.min())
    )
    return near_px, far_px


def meeting_point(left: Segment, right: Segment) -> PixelPoint:
    """Column and row where two lines meet that are not parallel."""
    first, second = (np.cross((*start, 1.0), (*end, 1.0)) for start, end in (left, right))
    column, row, scale = np.cross(first, second)
    return float(column / scale), float(row / scale)


def lanes_meet(image_bgr: NDArray[np.uint8], camera: GroundPlaneCamera) -> PixelPoint:
    """Column and row where the lines of the own lane meet, for a camera about which nothing is known.

    Arguments and errors are those of `propose_lane_lines`.
    """
    return meeting_point(*propose_lane_lines(image_bgr, camera, LOOKED_FOR_RAD))


def agreed_meeting(meetings: Sequence[PixelPoint], size: ImageSize) -> tuple[Gaussian, Gaussian] | None:
    """Column and row where the lanes of many pictures meet; None if they are few, or disagree.

    Errors from a bend are alike in all pictures, so the scatter is not divided by their number.
    """
    if len(meetings) < FEWEST_LANES:
        return None
    places = np.array(meetings)
    middle = np.median(places, axis=0)
    column_sigma, row_sigma = MAD_TO_SIGMA * np.median(np.abs(places - middle), axis=0)
    if row_sigma > LARGEST_SCATTER_HEIGHTS * size.height:
        return None
    column_least, row_least = (part * size.height for part in COMMON_LANE_SIGMAS_HEIGHTS)
    return (
        Gaussian(float(middle[0]), math.hypot(column_sigma, column_least)),
        Gaussian(float(middle[1]), math.hypot(row_sigma, row_least)),
    )


def lanes_aside(
    pictures: Sequence[NDArray[np.uint8]], camera: GroundPlaneCamera
) -> tuple[Gaussian, Gaussian] | None:
    """Where lanes meet for a camera that looks aside; None unless two thirds of the pictures show them.

    Args:
        pictures: (height, width, 3) BGR.
        camera: the camera as if it looked straight ahead.
    """
    best: list[PixelPoint] = []
    too_few = LEAST_ASIDE_PART * len(pictures)
    for yaw_rad in YAWS_TRIED_RAD:
        aside_px = camera.focal_y_px * math.tan(yaw_rad)
        turned = replace(camera, principal_column_px=camera.principal_column_px + aside_px)
        meetings: list[PixelPoint] = []
        for remaining, picture in zip(range(len(pictures), 0, -1), pictures, strict=True):
            if len(meetings) + remaining <= max(too_few, len(best)):
                break  # even with all the others there would be too few
            with suppress(UserError):
                meetings.append(lanes_meet(picture, turned))
        best = max(best, meetings, key=len)
    if len(best) <= too_few:
        return None
    height, width = pictures[0].shape[:2]
    return agreed_meeting(best, ImageSize(width, height))
