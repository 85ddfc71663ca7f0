"""What the four corners of a rectangle on the ground show about a camera.

The two pairs of parallel sides meet on the horizon, and the sides are at right angles. This gives the horizon
row, the roll and the focal length (Criminisi, Reid and Zisserman 2000, "Single view metrology"; Zhang 2000,
"A flexible new technique for camera calibration", with one picture of one plane). The ratio of two known
sides is a fourth fact, and a known side gives the height. The closed solution is only the start: the place,
the heading and the sides of the rectangle are fitted together with the camera, with residuals in the picture,
where the errors of the clicks are.
"""

import math
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import GroundRectangle
from fcw.camera.ground_plane import FloatArray
from fcw.camera.lens.model import Lens
from fcw.camera.points import OUTSIDE_LIMIT
from fcw.camera.straight import Straightening
from fcw.errors import UserError
from fcw.frame import ImageSize

RECTANGLE_FACTS = 3
"""Number of facts about a camera, even if the sides are unknown: horizon row, roll and focal length."""
RECTANGLE_MEANS = (15.0, 0.0, 0.0, math.log(4.0), math.log(4.0))
RECTANGLE_SIGMAS = (30.0, 30.0, 1e3, 1.5, 1.5)
"""Standard deviations of its middle ahead and to the left in metres, of the heading of its first side to the
left in radians, and of the logarithms of its sides; so large that they have no influence."""
RECTANGLE_STEPS = (1e-4, 1e-4, 1e-5, 1e-5, 1e-5)
ALONG_SIGMA_RAD = math.radians(1.0)
"""Standard deviation of the angle between paint along the road and the direction of travel."""
CORNERS = 4
SMALLEST_TURN = 0.02
"""Least sine of the angle at a corner in the picture; a flatter corner is hardly visible."""
SHORTEST_SIDE_PX = 5.0
SHORTEST_SIDE_M, LONGEST_SIDE_M = 0.3, 100.0
LEAST_BELOW_PX = 3.0
"""A corner that the first camera of a fit has in the sky is placed so far below the horizon."""
FOCAL_PARTS = (0.3, 5.0)
"""The closed solution is used as a start if its focal length is within these parts of the usual one."""


def check_rectangle(rectangle: GroundRectangle, image_size: ImageSize) -> None:
    """Check that the corners can be those of a rectangle on the ground, and that the sides are valid.

    Raises:
        UserError: they are not; the message names the corner or side and what to do.
    """
    corners = np.array(rectangle.corners_px, float)
    if corners.shape != (CORNERS, 2) or not np.isfinite(corners).all():
        raise UserError(f"rectangle: {len(rectangle.corners_px)} corners, expected {CORNERS}, column and row")
    size = np.array((image_size.width, image_size.height))
    for column_px, row_px in corners[((corners < -OUTSIDE_LIMIT * size) | (corners > 2 * size)).any(axis=1)]:
        raise UserError(
            f"rectangle: the corner at column {column_px:g}, row {row_px:g} is far outside the picture of "
            f"{image_size}; click its corners in the picture"
        )
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    if lengths.min() < SHORTEST_SIDE_PX:
        raise UserError(
            f"rectangle: a side is {lengths.min():.1f} px long in the picture, too short to tell anything; "
            "click a larger or nearer one"
        )
    before = np.roll(sides, 1, axis=0)
    turns = (before[:, 0] * sides[:, 1] - before[:, 1] * sides[:, 0]) / lengths / np.roll(lengths, 1)
    if not (np.all(turns > SMALLEST_TURN) or np.all(turns < -SMALLEST_TURN)):
        raise UserError(
            "rectangle: its corners do not go round it, or three of them lie on one line; give the four "
            "corners in turn, each the neighbour of the one before"
        )
    for side in rectangle.sides_m:
        if side is not None and not (SHORTEST_SIDE_M <= side.value <= LONGEST_SIDE_M and side.sigma > 0):
            raise UserError(
                f"rectangle: side {side.value:g} ± {side.sigma:g} m: expected {SHORTEST_SIDE_M:g} to "
                f"{LONGEST_SIDE_M:g} m, and an error above 0"
            )


def going_round(corners_px: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """The four corners in order around the rectangle: the first, then the second if it is its neighbour."""
    middle = np.mean(corners_px, axis=0)
    first, second = corners_px[0], corners_px[1]
    turn = sorted(corners_px, key=lambda place: math.atan2(place[1] - middle[1], place[0] - middle[0]))
    start = turn.index(first)
    turn = turn[start:] + turn[:start]
    return tuple(turn if turn[1] == second else (turn[0], *reversed(turn[1:])))


def corners_m(rectangle: GroundRectangle, place: FloatArray) -> FloatArray:
    """(4, 2) distances from the camera and lateral positions of the corners, in the order of the clicks."""
    forward_m, left_m, heading_rad, log_first, log_second = place
    first_m, second_m = math.exp(min(log_first, 10.0)), math.exp(min(log_second, 10.0))
    along = np.array((math.cos(heading_rad), math.sin(heading_rad))) * first_m / 2
    across = np.array((-math.sin(heading_rad), math.cos(heading_rad))) * second_m / 2 * _side(rectangle)
    middle = np.array((forward_m, left_m))
    return middle + np.array((-along - across, along - across, along + across, -along + across))


@dataclass(frozen=True, slots=True)
class RectangleFit:
    """How well a rectangle at some place agrees with what was clicked.

    Attributes:
        click_px: standard deviation of a clicked column or row.
        corner_error: standard deviation of each corner on the ground, as a part of the sides, because paint
            is laid by hand and its edge is clicked.
    """

    click_px: float
    corner_error: float

    def residuals(
        self, rectangle: GroundRectangle, place: FloatArray, way: Straightening, log_tape: float
    ) -> FloatArray:
        """(M,) misfits in sigmas: the columns and rows of its corners, its sides, its heading.

        Args:
            rectangle: what was clicked and stated.
            place: its five unknowns.
            way: converts between the straight picture and the one that was clicked in.
            log_tape: logarithm of the factor by which the tape measures too long.
        """
        camera, ground = way.camera, corners_m(rectangle, place)
        straight = np.column_stack(
            (camera.column_at(ground[:, 1], ground[:, 0]), camera.row_at(ground[:, 0]))
        )
        off_px = np.array(rectangle.corners_px) - way.to_picture(straight)
        depths_m = np.maximum(ground[:, 0] + camera.pole_m, 0.2)
        sigma_m = self.corner_error * math.exp((min(place[3], 10.0) + min(place[4], 10.0)) / 2)
        columns_px = np.hypot(self.click_px, sigma_m * camera.focal_y_px / depths_m)
        rows_px = np.hypot(self.click_px, sigma_m * camera.row_scale_m_px / depths_m**2)
        found = [off_px[:, 0] / columns_px, off_px[:, 1] / rows_px]
        for side, log_length in zip(rectangle.sides_m, place[3:], strict=True):
            if side is not None:
                off = log_length - math.log(side.value) - log_tape
                found.append(np.array([off * side.value / side.sigma]))
        if rectangle.along:
            found.append(np.array([math.sin(2 * place[2]) / 2 / ALONG_SIGMA_RAD]))
        return np.concatenate(found)


def placed(rectangle: GroundRectangle, way: Straightening) -> tuple[float, float, float, float, float]:
    """Its five unknowns as a camera sees it, approximately."""
    camera = way.camera
    places = way.to_straight(np.array(rectangle.corners_px, float))
    rows_px = np.maximum(places[:, 1], camera.horizon_row_px + LEAST_BELOW_PX)
    ground = np.column_stack((camera.distance_at(rows_px), camera.lateral_at(places[:, 0], rows_px)))
    first = (ground[1] - ground[0] + ground[2] - ground[3]) / 2
    second = (ground[2] - ground[1] + ground[3] - ground[0]) / 2
    middle = ground.mean(axis=0)
    lengths = np.maximum(np.linalg.norm((first, second), axis=1), SHORTEST_SIDE_M)
    heading_rad = math.atan2(first[1], first[0])
    return float(middle[0]), float(middle[1]), heading_rad, *np.log(lengths).tolist()


def seen_from(
    rectangle: GroundRectangle, lens: Lens | None, axis_px: tuple[float, float], focal_px: float
) -> list[tuple[float, float, float]]:
    """Tangent of the pitch, logarithm of the focal length and roll from the corners alone.

    Args:
        rectangle: the rectangle as it was clicked.
        lens: lens of the camera, if it is known.
        axis_px: column and row of the optical axis.
        focal_px: the usual focal length.

    Returns:
        A solution with the usual focal length, and one with the focal length that makes the corners right
        angles, if there is one; nothing if the sides do not meet.
    """
    rays = (np.array(rectangle.corners_px, float) - axis_px) / focal_px
    if lens is not None:
        rays = lens.undistorted(np.array(rectangle.corners_px, float))
    a, b, c, d = np.column_stack((rays, np.ones(CORNERS)))
    first = np.cross(np.cross(a, b), np.cross(d, c))
    second = np.cross(np.cross(b, c), np.cross(a, d))
    across, down, rest = np.cross(first, second)
    if abs(down) < abs(across) or down == 0:
        return []
    roll_rad = math.atan(across / down)
    horizon = -rest / math.hypot(across, down) * math.copysign(1.0, down)
    if not horizon < rays[:, 1].max():
        return []
    views = [(-horizon, math.log(focal_px), roll_rad)]
    scale = first[2] * second[2]
    square = -(first[0] * second[0] + first[1] * second[1]) / scale if scale else 0.0
    if lens is None and FOCAL_PARTS[0] ** 2 < square < FOCAL_PARTS[1] ** 2:
        part = math.sqrt(square)
        views.append((-horizon / part, math.log(focal_px * part), roll_rad))
    return views


def _side(rectangle: GroundRectangle) -> float:
    """1 if, going along the first side, the second one turns off to the left, else -1."""
    a, b, c, _ = np.array(rectangle.corners_px)
    first, second = b - a, c - b
    return 1.0 if first[0] * second[1] - first[1] * second[0] < 0 else -1.0
