"""One fit of all that is known of a camera: points, lines of the road, the horizon, vehicles, the height.

Least squares over pitch, focal length, axis row, yaw, roll, height and what else the evidence leaves open,
each with a belief of its own; so any of it may be missing, and the intervals say what that costs. All places
are taken to the straight picture (`fcw.camera.straight`), where a line along the road runs to the point
straight ahead, and a point at the distance d lies in the row v(d).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import (
    Calibration,
    Gaussian,
    GroundPoint,
    Priors,
    matrix3,
)
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.lens.model import Lens
from fcw.camera.lens.usual import usual_lens
from fcw.camera.points import check_priors, check_setup, check_tape_error
from fcw.camera.prior_sigmas import ROLL_SIGMA_RAD, TAPE_ERROR
from fcw.camera.solve import row_jacobian, support_distances
from fcw.camera.straight import Orientation, Straightening, straight_column
from fcw.camera.vanishing import Segment
from fcw.errors import UserError
from fcw.frame import ImageSize

USUAL_PITCH = Gaussian(0.05, 0.12)
YAW_SIGMA_RAD = math.radians(5.0)
START_SIGMA_M = 20.0
"""Of the first of marks whose first distance is not known."""
FLEET_SIGMA = 0.04
"""Of the widths of all vehicles together, as a part of them: a country's mix, a detector's margin."""
SMALLEST_DEPTH_M = 0.2
LENGTH_M = 4.2
"""Of a vehicle, for how much of its side it shows."""
SIDE_SIGMA = 0.5
"""Of the side that is shown, as a part of it: vehicles are turned, and boxes end where they will."""
HUBER_SIGMAS = 2.0
TANGENT, LOG_FOCAL, AXIS, YAW, ROLL, LOG_HEIGHT, START, LOG_FLEET = range(8)
UNKNOWN_COUNT = 8
STEPS = np.array((1e-5, 1e-5, 1e-2, 1e-5, 1e-5, 1e-5, 1e-3, 1e-5))
FOCAL_SIGMA, AXIS_SIGMA_PX = 0.01, 3.0
"""Of a lens whose intrinsics are known, as a part and in pixels: focus, warmth, another copy of the lens."""


@dataclass(frozen=True, slots=True)
class Ruler:
    """A vehicle on the road ahead, whose width is about known.

    Attributes:
        column_px: of the middle of its lower edge.
        row_px: of its lower edge.
        width_px: of its rear.
        width_m: of its rear, as its kind has it.
        row_sigma_px: error of the lower edge.
    """

    column_px: float
    row_px: float
    width_px: float
    width_m: Gaussian
    row_sigma_px: float


@dataclass(frozen=True, slots=True)
class Evidence:
    """What is known, besides the lens and the height.

    Attributes:
        points: marks at distances from the reference; with a column they tell of the roll.
        first_unknown: whether the points' distances count from the first of them, whose own is not known:
            dashes of a known period.
        lines: straight lines of the road along the direction of travel, each by two of its points; a known
            lateral distance apart they tell of the height.
        lane_width_m: between the first two lines.
        horizon: two points of it.
        travel_px: column and row that straight driving leads to.
        rulers: vehicles.
    """

    points: tuple[GroundPoint, ...] = ()
    first_unknown: bool = False
    lines: tuple[Segment, ...] = ()
    lane_width_m: Gaussian | None = None
    horizon: Segment | None = None
    travel_px: tuple[Gaussian, Gaussian] | None = None
    rulers: tuple[Ruler, ...] = ()


def calibrate_jointly(
    evidence: Evidence,
    image_size: ImageSize,
    height_m: Gaussian,
    reference_offset_m: float = 0.0,
    click_sigma_px: float = 1.0,
    priors: Priors = Priors(),  # noqa: B008 - immutable
    lens: Lens | None = None,
    tape_error: float = TAPE_ERROR,
) -> Calibration:
    """Calibrate from whatever is known.

    Args:
        evidence: what is known of the road in the picture.
        image_size: of the picture.
        height_m: of the camera, and how well it is known.
        reference_offset_m: from the camera forward to where distances start.
        click_sigma_px: standard deviation of a clicked column or row.
        priors: what else is stated; what is not is as in every lens.
        lens: the camera's intrinsics and distortion, where they are known.
        tape_error: standard deviation of all distances together, as a part of them; of a period, too.

    Raises:
        UserError: something is not as it must be, or nothing is known of the horizon.
    """
    check_setup(image_size, height_m.value, reference_offset_m, click_sigma_px)
    check_priors(priors)
    check_tape_error(tape_error)
    known = len(evidence.points) + 2 * (len(evidence.lines) > 1) + 2 * (evidence.horizon is not None)
    known += 2 * (evidence.travel_px is not None) + len(evidence.rulers) + priors.count
    if known + 2 * (lens is not None) < 2:
        raise UserError(
            "nothing is known of where the road lies in the picture; give points, lane lines, the horizon "
            "or vehicles"
        )
    fit = _JointFit(evidence, image_size, height_m, reference_offset_m, click_sigma_px, priors, lens)
    x, covariance = fit.solve()
    camera, orientation = fit.camera(x)
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
    by = np.zeros((3, UNKNOWN_COUNT))
    by[:, TANGENT] = rows[:, 0] - focal_px
    by[:, LOG_FOCAL] = rows[:, 1] - focal_px * tangent
    by[:, AXIS] = 1.0
    depths_m = support + reference_offset_m + camera.pole_m
    by[:, LOG_HEIGHT] = rows[:, 1] * (1 - camera.pole_m / depths_m)
    # Of a period the tape scales all but the first distance; of taped points all of it.
    taped_px = np.zeros(3)
    if points:
        taped_px = tape_error * (support - shift_m) * camera.row_slope_at(support + reference_offset_m)
    rows_covariance = by @ covariance @ by.T + np.outer(taped_px, taped_px)
    calibration = Calibration(
        camera,
        image_size,
        points,
        float(click_sigma_px),
        support_m,
        matrix3((rows_covariance + rows_covariance.T) / 2),
        float(reference_offset_m),
        priors,
        (0.0,) * len(points),
        usual_lens(image_size, priors) if lens is None else Priors(),
        float(tape_error),
        replace(
            orientation,
            # What nothing tells of is taken as level, and known no better than that.
            yaw_sigma_rad=math.sqrt(covariance[YAW, YAW]) if fit.tells_yaw else YAW_SIGMA_RAD,
            roll_sigma_rad=math.sqrt(covariance[ROLL, ROLL]) if fit.tells_roll else ROLL_SIGMA_RAD,
        ),
        lens,
    )
    residuals = tuple(
        row_px - calibration.row_at(point.distance_m)
        for point, row_px in zip(points, calibration.straight_rows_px, strict=True)
    )
    return replace(calibration, residuals_px=residuals)


class _JointFit:
    """Residuals in sigmas of all evidence and beliefs over the eight unknowns."""

    def __init__(
        self,
        evidence: Evidence,
        size: ImageSize,
        height_m: Gaussian,
        offset_m: float,
        click_sigma_px: float,
        priors: Priors,
        lens: Lens | None,
    ) -> None:
        self._evidence, self._size, self._offset_m, self._lens = evidence, size, offset_m, lens
        self._click_px = click_sigma_px
        self._horizon = priors.horizon_row_px
        usual = usual_lens(size, priors)
        view = priors.field_of_view_rad or usual.field_of_view_rad
        axis = priors.principal_row_px or usual.principal_row_px
        assert view is not None
        assert axis is not None
        self._view = view
        self._focal_px: Gaussian | None = None
        self._column_px = (size.width - 1) / 2
        if lens is not None:
            self._focal_px = Gaussian(math.log(lens.focal_y_px), FOCAL_SIGMA)
            axis = Gaussian(lens.row_px, AXIS_SIGMA_PX)
            self._column_px = lens.column_px
        focal_px = size.width / 2 / math.tan(view.value / 2) if lens is None else lens.focal_y_px
        height_sigma = max(height_m.sigma / height_m.value, 1e-6)
        self._means = np.array(
            (USUAL_PITCH.value, math.log(focal_px), axis.value, 0.0, 0.0, math.log(height_m.value), 8.0, 0.0)
        )
        columns = {point.column_px for point in evidence.points}
        self.tells_yaw = bool(evidence.lines) or evidence.travel_px is not None
        self.tells_roll = len(evidence.lines) > 1 or evidence.horizon is not None or len(columns) > 1
        self._sigmas = np.array(
            (
                USUAL_PITCH.sigma,
                10.0,
                axis.sigma,
                YAW_SIGMA_RAD if self.tells_yaw else 1e-6,
                ROLL_SIGMA_RAD if self.tells_roll else 1e-6,
                height_sigma,
                START_SIGMA_M if evidence.first_unknown else 1e-6,
                FLEET_SIGMA if evidence.rulers else 1e-6,
            )
        )

    def camera(self, x: FloatArray) -> tuple[GroundPlaneCamera, Orientation]:
        """The straight camera, and how the real one is turned; without sigmas."""
        orientation = Orientation(float(x[YAW]), float(x[ROLL]))
        real = GroundPlaneCamera(
            math.atan(float(x[TANGENT])),
            math.exp(float(x[LOG_FOCAL])),
            float(x[AXIS]),
            math.exp(float(x[LOG_HEIGHT])),
            self._column_px,
        )
        column_px = straight_column(real, orientation)
        straight = GroundPlaneCamera(
            real.pitch_rad, real.focal_y_px, real.principal_row_px, real.height_m, column_px
        )
        return straight, orientation

    def solve(self) -> tuple[FloatArray, FloatArray]:
        """The unknowns and their covariance; Gauss-Newton with damping from the middle of all beliefs."""
        from scipy.optimize import least_squares

        fit = least_squares(
            self.residuals,
            self._means,
            jac=self.jacobian,  # pyright: ignore[reportArgumentType] - scipy's annotation misses callables
            method="lm",
            x_scale=np.maximum(self._sigmas, 1e-6),
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
            max_nfev=400,
        )
        jacobian = self.jacobian(fit.x)
        scale = np.linalg.norm(jacobian, axis=0)
        if not (np.isfinite(scale).all() and scale.all()):
            raise UserError(
                "no camera fits all that was said; check the marks, their distances and the camera's height"
            )
        _, singular, right = np.linalg.svd(jacobian / scale, full_matrices=False)
        root = right.T / singular / scale[:, None]
        return fit.x, root @ root.T

    def jacobian(self, x: FloatArray) -> FloatArray:
        """(M, 8) by central differences: the straightening has no short derivative."""
        columns = []
        for k, step in enumerate(STEPS):
            up, down = x.copy(), x.copy()
            up[k] += step
            down[k] -= step
            columns.append((self.residuals(up) - self.residuals(down)) / (2 * step))
        return np.column_stack(columns)

    def residuals(self, x: FloatArray) -> FloatArray:
        """(M,) in sigmas."""
        beliefs = (x - self._means) / self._sigmas  # also where it is out of range, which leads back
        x = x.copy()
        x[TANGENT] = np.clip(x[TANGENT], -1.0, 1.5)
        x[LOG_FOCAL] = np.clip(x[LOG_FOCAL], 3.0, 12.0)
        camera, orientation = self.camera(x)
        self._way = Straightening(camera, orientation, self._lens, self._size)
        found = [beliefs]
        if self._focal_px is not None:
            found.append(np.array([(x[LOG_FOCAL] - self._focal_px.value) / self._focal_px.sigma]))
        else:
            view_rad = 2 * math.atan2(self._size.width, 2 * camera.focal_y_px)
            found.append(np.array([(view_rad - self._view.value) / self._view.sigma]))
        if self._horizon is not None:
            found.append(np.array([(camera.horizon_row_px - self._horizon.value) / self._horizon.sigma]))
        found += [
            self._of_points(x, camera),
            self._of_lines(camera),
            self._of_horizon(camera),
            self._of_rulers(x, camera),
        ]
        return np.nan_to_num(np.concatenate(found), nan=1e3, posinf=1e3, neginf=-1e3)

    def _straight(self, places: Sequence[tuple[float, float]]) -> FloatArray:
        return self._way.to_straight(np.array(places, float))

    def _of_points(self, x: FloatArray, camera: GroundPlaneCamera) -> FloatArray:
        points = self._evidence.points
        if not points:
            return np.zeros(0)
        places = [
            (camera.principal_column_px if p.column_px is None else p.column_px, p.row_px) for p in points
        ]
        first_m = x[START] if self._evidence.first_unknown else 0.0
        distances_m = np.array([point.distance_m for point in points]) + first_m + self._offset_m
        expected = camera.horizon_row_px + camera.row_scale_m_px / np.maximum(
            distances_m + camera.pole_m, 0.2
        )
        return (self._straight(places)[:, 1] - expected) / self._click_px

    def _of_lines(self, camera: GroundPlaneCamera) -> FloatArray:
        """Each line runs to the point straight ahead; the first two lie a lane apart."""
        lines = self._evidence.lines
        found, sides = [], []
        for line in lines:
            near, far = sorted(self._straight(line), key=lambda place: -place[1])
            below = np.maximum(np.array([near[1], far[1]]) - camera.horizon_row_px, 0.5)
            sides_px = np.array([near[0], far[0]]) - camera.principal_column_px
            ratio = below[1] / below[0]
            # Where the far end must be, seen along the row, for the line to lead straight ahead.
            slope = sides_px[0] / below[0]
            found.append((sides_px[1] - ratio * sides_px[0]) / (self._click_px * math.hypot(1, ratio, slope)))
            cosine = math.cos(camera.pitch_rad)
            sides.append(-sides_px[0] / below[0] * camera.height_m / cosine)
        width = self._evidence.lane_width_m
        if width is not None and len(sides) > 1:
            found.append((abs(sides[0] - sides[1]) - width.value) / width.sigma)
        if self._evidence.travel_px is not None:
            column, row = self._evidence.travel_px
            place = self._straight([(column.value, row.value)])[0]
            found.append((place[0] - camera.principal_column_px) / column.sigma)
            found.append((place[1] - camera.horizon_row_px) / row.sigma)
        return np.array(found)

    def _of_horizon(self, camera: GroundPlaneCamera) -> FloatArray:
        horizon = self._evidence.horizon
        if horizon is None:
            return np.zeros(0)
        return (self._straight(horizon)[:, 1] - camera.horizon_row_px) / self._click_px

    def _of_rulers(self, x: FloatArray, camera: GroundPlaneCamera) -> FloatArray:
        """The width of each vehicle by its row, against that of its kind; wild ones count little (Huber)."""
        rulers = self._evidence.rulers
        if not rulers:
            return np.zeros(0)
        places = self._straight([(ruler.column_px, ruler.row_px) for ruler in rulers])
        below = np.maximum(places[:, 1] - camera.horizon_row_px, 1.0)
        widths_px = np.array([ruler.width_px for ruler in rulers])
        metres_per_px = camera.height_m / (below * math.cos(camera.pitch_rad))
        usual_m = np.array([ruler.width_m.value for ruler in rulers])
        # A vehicle beside our path shows its side, whose far end is a car's length farther away.
        outer_m = (np.abs(places[:, 0] - camera.principal_column_px) + widths_px / 2) * metres_per_px
        distances_m = camera.focal_y_px * metres_per_px
        sides_m = np.maximum(outer_m - usual_m, 0.0) * LENGTH_M / (distances_m + LENGTH_M)
        seen_m = np.maximum(widths_px * metres_per_px - sides_m, usual_m / 3)
        relative = np.array([ruler.width_m.sigma / ruler.width_m.value for ruler in rulers])
        row_parts = np.array([ruler.row_sigma_px for ruler in rulers]) / below
        sigmas = np.sqrt(relative**2 + row_parts**2 + (SIDE_SIGMA * sides_m / seen_m) ** 2)
        misfits = (np.log(seen_m / usual_m) - x[LOG_FLEET]) / sigmas
        sizes = np.abs(misfits)
        return np.where(
            sizes > HUBER_SIGMAS,
            np.sign(misfits) * np.sqrt(np.maximum(2 * HUBER_SIGMAS * sizes - HUBER_SIGMAS**2, 0.0)),
            misfits,
        )
