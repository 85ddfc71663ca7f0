"""Least squares over all unknowns of a camera."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.joint.known import CLOSED_SIGMA, NO_SLIP, Known, Slip
from fcw.camera.joint.lines import line_misfits
from fcw.camera.joint.plates import PLACES, plate_misfits
from fcw.camera.joint.rectangle import (
    RECTANGLE_MEANS,
    RECTANGLE_SIGMAS,
    RECTANGLE_STEPS,
    RectangleFit,
    placed,
)
from fcw.camera.joint.rulers import width_misfits
from fcw.camera.joint.unknowns import (
    AXIS,
    BEND,
    CAMERA_UNKNOWNS,
    LOG_FLEET,
    LOG_FOCAL,
    LOG_HEIGHT,
    LOG_TAPE,
    ROLL,
    SLIP,
    SLOPE,
    START,
    STEPS,
    TANGENT,
    YAW,
    camera_starts,
)
from fcw.camera.lens.model import Lens
from fcw.camera.lens.plumb import bows_px
from fcw.camera.lens.usual import usual_lens
from fcw.camera.prior_sigmas import (
    MARK_ERROR_PART,
    ROLL_SIGMA_RAD,
    USUAL_TANGENT,
    USUAL_TANGENT_SIGMA,
    YAW_SIGMA_RAD,
)
from fcw.camera.straight import Orientation, Straightening, straight_column
from fcw.errors import UserError

START_SIGMA_M = 20.0
"""Standard deviation of the first mark's distance if it is not known."""
FLEET_SIGMA = 0.04
"""Relative error that the widths of all vehicles share: a country's mix, a detector's margin."""
SLOPE_SIGMA_RAD = math.radians(0.25)
"""Standard deviation of the slope of the road under the vehicles of a clip against that under the own car.

However many vehicles there are, they do not show the horizon better than this.
"""
SMALLEST_DEPTH_M = 0.2
TANGENTS, LOG_FOCALS, LOG_HEIGHTS = (-1.0, 1.5), (3.0, 12.0), (-5.0, 10.0)
"""Ranges of the cameras that are tried; a fit that ends outside has failed."""
NO_BEND = Gaussian(0.0, CLOSED_SIGMA)
LARGEST_BEND = 0.6
FOCAL_SIGMA = 0.01
"""Relative error of a known focal length: focus, temperature, another copy of the lens."""


class JointFit:
    """Residuals of all evidence and priors, in sigmas, as a function of the unknowns."""

    def __init__(self, known: Known, slip: Slip = NO_SLIP) -> None:
        """Prepare the fit.

        Args:
            known: what is known.
            slip: how dashes may differ from their period.
        """
        evidence, size, height_m = known.evidence, known.image_size, known.height_m
        priors, lens, bend = known.priors, known.lens, known.bend or NO_BEND
        # Each mark also has an error of its own. Near the camera it is more rows than a click is off.
        self._mark_error, self._slip_m = MARK_ERROR_PART * known.tape_error, np.array(slip.by_mark_m)
        self._known, self._evidence, self._size, self._lens = known, evidence, size, lens
        self._offset_m, self._click_px = known.reference_offset_m, known.click_sigma_px
        self._distances_m = np.array([point.distance_m for point in evidence.points])
        self._points_px = np.array([(point.column_px, point.row_px) for point in evidence.points], float)
        self._has_middles = bool(np.isnan(self._points_px).any())
        self._ends_px = np.array([end for line in evidence.lines for end in line], float)
        self._differentiated = np.zeros(0), np.zeros(0)  # the last place, and the Jacobian there
        self._horizon = priors.horizon_row_px
        rectangles = len(evidence.rectangles)
        self._rectangle_fit = RectangleFit(self._click_px, self._mark_error)
        usual = usual_lens(size, priors, evidence.has_distances)
        view = priors.field_of_view_rad or usual.field_of_view_rad
        axis = priors.principal_row_px or usual.principal_row_px
        assert view is not None
        assert axis is not None
        self._view = view
        self._column_px = (size.width - 1) / 2 if known.axis_column_px is None else known.axis_column_px
        focal_px = size.width / 2 / math.tan(view.value / 2)
        focal_sigma, height_sigma = 10.0, max(height_m.sigma / height_m.value, CLOSED_SIGMA)
        if lens is not None:
            # The straight picture is made with this lens, so its axis and focal length are exact there. An
            # error of the real focal length affects distances as an error of the height does.
            axis, focal_px, focal_sigma = Gaussian(lens.row_px, CLOSED_SIGMA), lens.focal_y_px, CLOSED_SIGMA
            height_sigma = math.hypot(height_sigma, FOCAL_SIGMA)
            self._column_px = lens.column_px
        yaw, roll = evidence.yaw_rad, evidence.roll_rad
        turned = (yaw.value if yaw else 0.0, roll.value if roll else 0.0)
        self._means = np.array(
            (
                USUAL_TANGENT,
                math.log(focal_px),
                axis.value,
                *turned,
                math.log(height_m.value),
                8.0,
                0.0,
                bend.value,
                0.0,
                0.0,
                0.0,
                *RECTANGLE_MEANS * rectangles,
            )
        )
        self._bends = lens is None and bend is not NO_BEND
        columns = {point.column_px for point in evidence.points}
        self._marks_aside = len(columns) > 1
        self.tells_yaw = bool(evidence.lines) or evidence.travel_px is not None or yaw is not None
        self.tells_yaw = self.tells_yaw or any(rectangle.along for rectangle in evidence.rectangles)
        self.tells_roll = len(evidence.lines) > 1 or evidence.horizon is not None or self._marks_aside
        self.tells_roll = self.tells_roll or roll is not None or rectangles > 0
        self._sigmas = np.array(
            (
                USUAL_TANGENT_SIGMA,
                focal_sigma,
                axis.sigma,
                yaw.sigma if yaw else YAW_SIGMA_RAD if self.tells_yaw else CLOSED_SIGMA,
                roll.sigma if roll else ROLL_SIGMA_RAD if self.tells_roll else CLOSED_SIGMA,
                height_sigma,
                START_SIGMA_M if evidence.first_unknown else CLOSED_SIGMA,
                FLEET_SIGMA if evidence.rulers else CLOSED_SIGMA,
                bend.sigma,
                slip.sigma,
                max(known.tape_error, CLOSED_SIGMA) if rectangles else CLOSED_SIGMA,
                SLOPE_SIGMA_RAD if evidence.rulers else CLOSED_SIGMA,
                *RECTANGLE_SIGMAS * rectangles,
            )
        )
        self._steps = (*STEPS, *RECTANGLE_STEPS * rectangles)

    def camera(self, x: FloatArray) -> tuple[GroundPlaneCamera, Orientation]:
        """The straight camera, and yaw and roll of the real one without their sigmas."""
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

    def lens(self, x: FloatArray) -> Lens | None:
        """The lens as it is known, or as it comes out where its bend is open."""
        if not self._bends:
            return self._lens
        focal_px, bend = math.exp(float(x[LOG_FOCAL])), float(x[BEND])
        return Lens(
            "radtan", focal_px, focal_px, self._column_px, float(x[AXIS]), (bend, 0.0, 0.0, 0.0), self._size
        )

    def log_evidence(self, x: FloatArray, covariance: FloatArray) -> float:
        """Of all that was said, but for what does not depend on the lens (Laplace's approximation)."""
        _, log_volume = np.linalg.slogdet(covariance / np.outer(self._sigmas, self._sigmas))
        misfits = self.residuals(x)
        return float(-(misfits @ misfits) + log_volume) / 2

    def rectangle_misfits(self, x: FloatArray) -> list[float]:
        """Of each rectangle, all its residuals together, in sigmas."""
        self.residuals(x)
        return [float(np.linalg.norm(misfits)) for misfits in self._of_rectangles(x)]

    def solve(
        self, tolerance: float = 1e-12, start: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """The unknowns and their covariance; Gauss-Newton with damping from each start, the best of all.

        Args:
            tolerance: of the unknowns, the cost and its slope, all relative.
            start: where to start, if that is known.
        """
        fits = [self._descend(start, tolerance) for start in (self._starts() if start is None else [start])]
        x, _ = min(fits, key=lambda fit: fit[1])
        jacobian = self.jacobian(x)
        scale = np.linalg.norm(jacobian, axis=0)
        limits = ((TANGENT, TANGENTS), (LOG_FOCAL, LOG_FOCALS), (LOG_HEIGHT, LOG_HEIGHTS))
        found = all(least <= x[k] <= most for k, (least, most) in limits)
        if not (found and np.isfinite(scale).all() and scale.all()):
            raise UserError(
                "no camera fits everything you gave; check the marks, their distances and the camera's height"
            )
        _, singular, right = np.linalg.svd(jacobian / scale, full_matrices=False)
        root = right.T / singular / scale[:, None]
        return x, root @ root.T

    def with_unknown_yaw(self, x: FloatArray, covariance: FloatArray) -> FloatArray:
        """The covariance of a fit, with what a yaw that nothing tells of makes of marks beside each other.

        The fit takes the camera to look straight ahead; if it does not, a mark to one side is nearer to it,
        and one to the other side farther away, than their distances say (a "considered" unknown; Schmidt
        1966, "Application of state-space methods to navigation problems").
        """
        if self.tells_yaw or not self._marks_aside:
            return covariance
        step = np.zeros(len(x))
        step[YAW] = STEPS[YAW]
        by_yaw = (self.residuals(x + step) - self.residuals(x - step)) / (2 * STEPS[YAW])
        by_yaw[YAW] = 0.0
        moved = covariance @ (self.jacobian(x).T @ by_yaw) * YAW_SIGMA_RAD
        return covariance + np.outer(moved, moved)

    def _descend(self, start: FloatArray, tolerance: float) -> tuple[FloatArray, float]:
        """The minimum from a start and its cost, by MINPACK itself: `least_squares` takes longer."""
        from scipy.optimize import leastsq

        outcome = leastsq(
            self.residuals,
            start,
            Dfun=self.jacobian,
            full_output=True,
            ftol=tolerance,
            xtol=tolerance,
            gtol=tolerance,
            maxfev=400,
            diag=1 / np.maximum(self._sigmas, 1e-6),
        )
        x, found = outcome[0], outcome[2]  # pyright: ignore[reportGeneralTypeIssues] - with full_output there are more
        residuals = found["fvec"]
        return x, float(residuals @ residuals) / 2

    def _starts(self) -> list[FloatArray]:
        """Rectangles lie where the camera that it starts from sees them."""
        starts = camera_starts(self._known, self._means, self._column_px)
        for start in starts:
            way = Straightening(*self.camera(start), self.lens(start), self._size)
            start[CAMERA_UNKNOWNS:] = [
                number for rectangle in self._evidence.rectangles for number in placed(rectangle, way)
            ]
        return starts

    def jacobian(self, x: FloatArray) -> FloatArray:
        """(M, N) by central differences: the straightening has no short derivative.

        What is not open moves nothing but its own belief, so that its differences are not taken.
        """
        if np.array_equal(x, self._differentiated[0]):
            return self._differentiated[1]
        is_open = self._sigmas > CLOSED_SIGMA
        slopes = []
        for k in np.flatnonzero(is_open):
            up, down = x.copy(), x.copy()
            up[k] += self._steps[k]
            down[k] -= self._steps[k]
            slopes.append((self.residuals(up) - self.residuals(down)) / (2 * self._steps[k]))
        jacobian = np.zeros((len(slopes[0]), len(x)))
        jacobian[:, is_open] = np.transpose(slopes)
        closed = np.flatnonzero(~is_open)
        jacobian[closed, closed] = 1 / self._sigmas[closed]
        self._differentiated = x.copy(), jacobian
        return jacobian

    def residuals(self, x: FloatArray) -> FloatArray:
        """(M,) in sigmas."""
        beliefs = (x - self._means) / self._sigmas  # also where it is out of range, which leads back
        x = x.copy()
        x[TANGENT] = min(max(x[TANGENT], TANGENTS[0]), TANGENTS[1])
        x[LOG_FOCAL] = min(max(x[LOG_FOCAL], LOG_FOCALS[0]), LOG_FOCALS[1])
        x[LOG_HEIGHT] = min(max(x[LOG_HEIGHT], LOG_HEIGHTS[0]), LOG_HEIGHTS[1])
        x[BEND] = min(max(x[BEND], -LARGEST_BEND), LARGEST_BEND)
        camera, orientation = self.camera(x)
        self._way = Straightening(camera, orientation, self.lens(x), self._size)
        found = [beliefs]
        if self._lens is None:
            view_rad = 2 * math.atan2(self._size.width, 2 * camera.focal_y_px)
            found.append(np.array([(view_rad - self._view.value) / self._view.sigma]))
        if self._horizon is not None:
            found.append(np.array([(camera.horizon_row_px - self._horizon.value) / self._horizon.sigma]))
        focal_px = self._evidence.focal_px
        if focal_px is not None and self._lens is None:
            off = x[LOG_FOCAL] - math.log(focal_px.value)
            found.append(np.array([off / (focal_px.sigma / focal_px.value)]))
        scale = self._evidence.scale_px_m
        if scale is not None:
            off = x[LOG_FOCAL] + x[LOG_HEIGHT] - math.log(scale.value)
            found.append(np.array([off / (scale.sigma / scale.value)]))
        found += [
            self._of_points(x, camera),
            self._of_lines(camera),
            self._of_horizon(camera),
            self._of_edges(),
            self._of_rulers(x, camera),
            self._of_plates(camera),
            *self._of_rectangles(x),
        ]
        together = np.concatenate(found)
        if np.isfinite(together).all():
            return together
        return np.nan_to_num(together, nan=1e3, posinf=1e3, neginf=-1e3)

    def _straight(self, places: FloatArray | Sequence[tuple[float, float]]) -> FloatArray:
        return self._way.to_straight(np.asarray(places, float))

    def _of_points(self, x: FloatArray, camera: GroundPlaneCamera) -> FloatArray:
        if not self._evidence.points:
            return np.zeros(0)
        places = self._points_px
        if self._has_middles:  # a point without a column lies straight ahead
            places = np.where(np.isnan(places), camera.principal_column_px, places)
        first_m = x[START] if self._evidence.first_unknown else 0.0
        distances_m = self._distances_m + first_m + self._offset_m
        if self._slip_m.size:
            distances_m = distances_m + x[SLIP] * self._slip_m
        depths_m = np.maximum(distances_m + camera.pole_m, SMALLEST_DEPTH_M)
        below_px = camera.row_scale_m_px / depths_m
        off_px = self._straight(places)[:, 1] - (camera.horizon_row_px + below_px)
        laid_m = self._mark_error * (distances_m - self._offset_m)
        return off_px / np.hypot(self._click_px, laid_m * below_px / depths_m)

    def _of_rectangles(self, x: FloatArray) -> list[FloatArray]:
        rectangles = self._evidence.rectangles
        places = x[CAMERA_UNKNOWNS:].reshape(-1, len(RECTANGLE_MEANS))
        return [
            self._rectangle_fit.residuals(rectangle, place, self._way, float(x[LOG_TAPE]))
            for rectangle, place in zip(rectangles, places, strict=True)
        ]

    def _of_edges(self) -> FloatArray:
        """How far each straight edge bows in the straight picture (plumb lines, Brown 1971)."""
        bows = []
        for edge in self._evidence.edges:
            places = self._straight(edge)
            # A camera that has a part of it behind it is tried on the way, and no better than any.
            seen = bool(np.isfinite(places).all())
            bows.append(bows_px(places) if seen else np.full(len(places), np.nan))
        return np.concatenate([np.zeros(0), *bows]) / self._click_px

    def _of_lines(self, camera: GroundPlaneCamera) -> FloatArray:
        """Each line runs to the point straight ahead, as the travel does; the first two lie a lane apart."""
        found = np.zeros(0)
        if self._ends_px.size:
            ends = self._straight(self._ends_px)
            found = line_misfits(ends, camera, self._click_px, self._evidence.lane_width_m)
        if self._evidence.travel_px is None:
            return found
        column, row = self._evidence.travel_px
        place = self._straight([(column.value, row.value)])[0]
        travel = (
            (place[0] - camera.principal_column_px) / column.sigma,
            (place[1] - camera.horizon_row_px) / row.sigma,
        )
        return np.concatenate((found, travel))

    def _of_horizon(self, camera: GroundPlaneCamera) -> FloatArray:
        horizon = self._evidence.horizon
        if horizon is None:
            return np.zeros(0)
        return (self._straight(horizon)[:, 1] - camera.horizon_row_px) / self._click_px

    def _of_rulers(self, x: FloatArray, camera: GroundPlaneCamera) -> FloatArray:
        rulers = self._evidence.rulers
        if not rulers:
            return np.zeros(0)
        places = self._straight([(ruler.column_px, ruler.row_px) for ruler in rulers])
        usual_focal_px = math.exp(float(self._means[LOG_FOCAL]))
        fleet, slope_rad = float(x[LOG_FLEET]), float(x[SLOPE])
        return width_misfits(rulers, places, camera, fleet, slope_rad, usual_focal_px)

    def _of_plates(self, camera: GroundPlaneCamera) -> FloatArray:
        plates = self._evidence.plates
        if not plates:
            return np.zeros(0)
        places = self._straight([place for plate in plates for place in plate.places_px])
        return plate_misfits(plates, places.reshape(len(plates), PLACES, 2), camera, self._click_px)


@lru_cache(maxsize=8)
def solved(known: Known) -> tuple[FloatArray, FloatArray]:
    """The fitted unknowns and their covariance; cached, so that the same input is fitted only once."""
    x, covariance = JointFit(known).solve()
    x.setflags(write=False)
    covariance.setflags(write=False)
    return x, covariance
