"""From boxes to the range filter's measurements: residuals, variances and the Jacobian.

The equations and the state are those of `fcw.tracking.range.filter`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.motion.state import STRAIGHT, OwnPath
from fcw.tracking.association import WHOLE, Edges
from fcw.tracking.range.model import RangeModel
from fcw.tracking.ranging import BoxNoise, measures_height, measures_row, measures_width
from fcw.tracking.types import USUAL_WIDTH_M
from fcw.tracking.vehicle_sizes import SizePrior

NEAREST_START_M = 1.0
SMALLEST_DEPTH_M = 0.1
"""Keeps the equations finite for a vehicle believed to be at the camera."""

HORIZON, SCALE, POLE, SLOW, FAST, WIDER, CAMERA = 0, 1, 2, 3, 4, 5, 6
DISTANCE, RATE, GROWTH, WIDTH, HEIGHT, ASPECT, BUMP, LOOKS, VEHICLE = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""Indices into the state: first the camera's part, then one part for each vehicle."""


@dataclass(frozen=True, slots=True)
class View:
    """How we see a vehicle: sigmas of its aspect and of bumps, and how far its middle is from our path."""

    aspect_sigma: float
    bump_sigma_px: float
    lateral_m: float


class Sighting(NamedTuple):
    """A box of a vehicle.

    Attributes:
        slot: index of the vehicle in the filter.
        kind: index of its kind.
        box: its box in the picture.
        edges: which edges of the box are the vehicle's own.
        doubtful: whether it may be no vehicle.
        log_part: logarithm of the fraction of its width that is boxed; see `fcw.tracking.range.boxed_part`.
    """

    slot: int
    kind: int
    box: Box
    edges: Edges = WHOLE
    doubtful: bool = False
    log_part: float = 0.0


class Measurements(NamedTuple):
    """Measurements of M edges and widths.

    Attributes:
        rows: (M, N) Jacobian, approximate for K and C: C and the overhangs are taken to grow with K and the
            distances. Then a scene that is farther away through a longer lens looks exactly the same, which
            is nearly true. The remainder is far smaller than the error of a box that shows a side or is cut,
            and would let such boxes halve K within a second.
        residuals: (M,) measured minus expected.
        variances: (M,) of the measurements' own noise.
        common: (M,) whether the measurement also updates the camera's part of the state.
        views: view of each vehicle.
    """

    rows: FloatArray
    residuals: FloatArray
    variances: FloatArray
    common: NDArray[np.bool_]
    views: list[View]


SHARPEST_ROAD_PER_M = 1 / 80
"""A sharper bend is no road but a turn at a crossing, and vehicles ahead are not aligned with it."""
STEEPEST_SLOPE = 0.3
"""Largest slope of the road that is used. A bend is not known so far ahead that it would have turned by
more."""
TURNS_SIGMAS = 3.0
"""A vehicle turns if its box is wider for its height than before by this many sigmas, or its side
narrower."""
TURNS_FACTOR = 8.0
"""The aspect of a turning vehicle may change by this many times the excess over `TURNS_SIGMAS`. Of 1, 2, 4
and 8, with 1.5 to 3 sigmas, this pair handles a car that turns off and changes everything else least."""
ACROSS_M = 1.0
"""If a box is wider by this than the rear and the whole side of its vehicle, the vehicle stands across the
road, or the box contains more than one."""


def road_slope(path: OwnPath, distance_m: float) -> float:
    """Direction of the road at a distance, as a slope against the camera's axis. Vehicles align with it."""
    if abs(path.curvature_per_m) > SHARPEST_ROAD_PER_M:
        return path.heading_rad
    return max(-STEEPEST_SLOPE, min(path.slope_at(distance_m), STEEPEST_SLOPE))


def visible_side_m(outer_m: float, width_m: float, distance_m: float, length_m: float) -> float:
    """How much of its side a vehicle shows, as a width at the distance of its rear.

    The reference is the line on which a vehicle is seen straight from behind. The far end of the inner side
    has the same lateral distance from that line as the near end, but is farther away, and so appears closer
    to it.

    Args:
        outer_m: lateral distance of its outer side from that line.
        width_m: width of its rear.
        distance_m: its distance.
        length_m: its length.
    """
    return max(outer_m - width_m, 0.0) * length_m / (distance_m + length_m)


def outwards_m(turned_m: float, shown_m: float, width_m: float, distance_m: float, length_m: float) -> float:
    """How much farther out the middle of a vehicle is than the middle of its box, which includes its side.

    Args:
        turned_m: lateral position of the box's middle, from the line on which a vehicle is seen straight from
            behind.
        shown_m: width of the box in metres, at the vehicle's distance.
        width_m: width of the vehicle's rear.
        distance_m: distance of the vehicle.
        length_m: length of the vehicle.
    """
    side_m = visible_side_m(abs(turned_m) + shown_m / 2, width_m, distance_m, length_m)
    if shown_m < width_m + side_m + ACROSS_M:
        side_m = max(shown_m - width_m, 0.0)
    return math.copysign(min(side_m / 2, abs(turned_m)), turned_m)


class BoxGeometry:
    """How vehicles appear in the picture.

    Attributes:
        path: our own path, with which vehicles align. In a bend, a vehicle straight ahead shows its side too.

    Args:
        camera: the calibrated camera.
        image_size: size of the pictures.
        noise: noise of the boxes.
        model: model of vehicles, camera and road.
    """

    def __init__(
        self, camera: GroundPlaneCamera, image_size: ImageSize, noise: BoxNoise, model: RangeModel
    ) -> None:
        self.prior = SizePrior(model, noise.free_height, noise.at_tyres)
        self.path = STRAIGHT
        self._noise, self._model, self._image_size = noise, model, image_size
        self.height_m, self._focal_px = camera.height_m, camera.focal_y_px
        self._axis_px = camera.principal_column_px
        self._calibrated = camera

    def first_sight(self, box: Box, x: FloatArray, covariance: FloatArray) -> tuple[int, float] | None:
        """Kind and distance by one box; None if none of its width, height and row can be used."""
        noise, size = self._noise, self._image_size
        horizon_px, log_scale, pole_m, slow_px, fast_px, wider = x[:CAMERA].tolist()
        scale = math.exp(log_scale)
        focal_px = scale / math.hypot(self.height_m, pole_m)
        row = by_width = by_height = None
        pitches = [HORIZON, SLOW, FAST]
        if measures_row(box, size, noise):
            variance = float(covariance[np.ix_(pitches, pitches)].sum())
            sigma_px = math.sqrt(variance + noise.bottom_sigma_px(box) ** 2)
            row = box.bottom - horizon_px - slow_px - fast_px, sigma_px
            if measures_height(box, size, noise):
                height_sigma = math.hypot(noise.bottom_sigma_px(box), noise.edge_sigma_px(box)) / box.h
                by_height = math.log(focal_px / box.h), height_sigma
        if measures_width(box, size, noise):
            one_metre = math.log(focal_px / box.w) + wider
            by_width = one_metre, math.sqrt(noise.log_width_sigma(box) ** 2 + covariance[WIDER, WIDER])
        if by_width is None and by_height is None:
            if row is None or row[0] <= row[1]:
                return None
            kind, depth_m = 0, scale / row[0] - self.prior.overhangs_m[0]
        else:
            kind, depth_m = self.prior.first_sight(by_width, by_height, row, scale)
        return kind, max(depth_m - pole_m, NEAREST_START_M)

    def _side_m(self, box: Box, kind: int, distance_m: float, width_m: float, focal_px: float) -> float:
        """How much of its side a vehicle beside our path shows, as a width at its rear."""
        behind_m = road_slope(self.path, distance_m) * distance_m
        outer_m = max(
            abs((self._axis_px - edge_px) * distance_m / focal_px - behind_m)
            for edge_px in (box.x, box.right)
        )
        return visible_side_m(outer_m, width_m, distance_m, self.prior.lengths_m[kind])

    def view(self, box: Box, kind: int, distance_m: float, width_m: float, focal_px: float) -> View:
        """How we see a vehicle at this distance and of this width.

        Args:
            box: its box.
            kind: index of its kind.
            distance_m: its estimated distance.
            width_m: width of its rear.
            focal_px: focal length estimated together with the distance, used for its visible side. With the
                calibrated one, a smaller scale would move the vehicle towards our path, where it would show
                less of its side; the rest of its width would make the scale smaller still. The calibrated
                focal length is used for everything else, because boxes that are too wide would pull that too.
        """
        model = self._model
        side_m = self._side_m(box, kind, distance_m, width_m, focal_px)
        path_m = self.path.lateral_at(distance_m)
        outer_m = max(
            abs((self._axis_px - edge_px) * distance_m / self._focal_px - path_m)
            for edge_px in (box.x, box.right)
        )
        lateral_m = outer_m - width_m / 2
        # The bend may turn the vehicle the other way than its lateral position does. The visible sides then
        # cancel, but their uncertainties do not.
        bend_rad = road_slope(self.path, distance_m) - self.path.heading_rad
        side_part = math.hypot(side_m, bend_rad * self.prior.lengths_m[kind]) / (width_m + side_m)
        if kind > self.prior.rear_count:
            # Seen from its side, whose share of the width changes as it turns. The same is true of a vehicle
            # seen from a corner. But a van that comes half into our lane looks like that at first, and with
            # an uncertain width, warnings of it were lost.
            side_part = max(1 - USUAL_WIDTH_M / width_m, 0.0)
        return View(
            math.hypot(model.aspect_sigma, model.side_sigma * side_part),
            self._focal_px * math.hypot(model.bump_sigma_rad, model.cross_slope * lateral_m / distance_m),
            lateral_m,
        )

    def ruler(self, sighting: Sighting, distance_m: float) -> tuple[float, float, float, float] | None:
        """The horizon by a vehicle if it is as wide as its kind usually is; see `fcw.tracking.horizon`.

        Returns:
            Pitch relative to the calibration, angle of its lower edge below the horizon, sigma of its log
            width, and sigma of the pitch due to the noise of the box; None if the box is cut, or far aside.
        """
        _, kind, box, *_ = sighting
        noise, size, camera = self._noise, self._image_size, self._calibrated
        if not (measures_row(box, size, noise) and measures_width(box, size, noise)):
            return None
        width_m = math.exp(self.prior.log_sizes[kind][0])
        view = self.view(box, kind, distance_m, width_m, self._focal_px)
        if view.lateral_m > self._model.common_path_m:
            return None
        shown_m = width_m
        if kind < self.prior.rear_count and noise.shows_side:
            shown_m += self._side_m(box, kind, distance_m, width_m, self._focal_px)
        focal_px = camera.row_scale_m_px / math.hypot(self.height_m, camera.pole_m)
        below_px = camera.row_scale_m_px / (focal_px * shown_m / box.w + self.prior.overhangs_m[kind])
        noise_px = math.hypot(noise.bottom_sigma_px(box), below_px * noise.log_width_sigma(box))
        return (
            (camera.horizon_row_px + below_px - box.bottom) / self._focal_px,
            below_px / self._focal_px,
            math.hypot(self.prior.sigmas[kind][0], view.aspect_sigma),
            noise_px / self._focal_px,
        )

    def _turned(
        self, sighting: Sighting, view: View, log_usual: float, x: FloatArray, covariance: FloatArray
    ) -> View:
        """The view of a vehicle whose box is wider for its height than it was; of a side, or narrower.

        A car that turns off becomes twice as wide in two seconds. To a filter in which a vehicle keeps its
        width it would come nearer, and one that turns into our way would fall back.

        Args:
            sighting: of the vehicle.
            view: of it, as far as it was expected.
            log_usual: logarithm of how many times as wide as its rear it is expected to be.
            x: (N,) state.
            covariance: (N, N) of it.
        """
        noise, size, box = self._noise, self._image_size, sighting.box
        whole = (
            sighting.edges == WHOLE and measures_row(box, size, noise) and measures_height(box, size, noise)
        )
        if not whole:
            return view
        width, height = (CAMERA + VEHICLE * sighting.slot + place for place in (WIDTH, HEIGHT))
        sizes = covariance[width, width] + covariance[height, height] - 2 * covariance[width, height]
        log_height_sigma = math.hypot(noise.edge_sigma_px(box), noise.bottom_sigma_px(box)) / box.h
        sigma = math.hypot(
            noise.log_width_sigma(box), log_height_sigma, view.aspect_sigma, math.sqrt(max(sizes, 0.0))
        )
        wider = math.log(box.w / box.h) - float(x[width] - x[height]) - log_usual
        # A rear that becomes narrower is boxed in part: see `fcw.tracking.range.boxed_part`.
        off = wider if sighting.kind < self.prior.rear_count else abs(wider)
        beyond = max(off - TURNS_SIGMAS * sigma, 0.0)
        return replace(view, aspect_sigma=math.hypot(view.aspect_sigma, TURNS_FACTOR * beyond))

    def measure(
        self, sightings: Sequence[Sighting], x: FloatArray, covariance: FloatArray, dt_s: float
    ) -> Measurements:
        """Measurements of one frame, dt after the one before, against the (N,) state x and its covariance."""
        height_m, noise, size, model = self.height_m, self._noise, self._image_size, self._model
        white = noise.white(dt_s)
        horizon_px, log_scale, pole_m, slow_px, fast_px, wider = x[:CAMERA].tolist()
        scale = math.exp(log_scale)
        pitched_px = horizon_px + slow_px + fast_px
        log_focal = log_scale - math.log(math.hypot(height_m, pole_m))
        focal_px = math.exp(log_focal)
        rows = np.zeros((3 * len(sightings), len(x)))
        residuals: list[float] = []
        variances: list[float] = []
        common: list[bool] = []
        views: list[View] = []
        for sighting in sightings:
            slot, kind, box, edges, doubtful, log_part = sighting
            at = CAMERA + VEHICLE * slot
            log_distance, _, _, log_width, log_height, aspect, bump_px, _ = x[at : at + VEHICLE].tolist()
            distance_m, width_m = math.exp(log_distance), math.exp(log_width + log_part)
            depth_m = max(distance_m + pole_m, SMALLEST_DEPTH_M)
            below_px = scale / depth_m
            view = self.view(box, kind, distance_m, width_m, focal_px)
            views.append(view)
            before = len(residuals)
            if edges.bottom and measures_row(box, size, noise):
                row = rows[len(residuals)]
                tyres_m = depth_m + self.prior.overhangs_m[kind]
                foot_px = scale / tyres_m
                row[HORIZON] = row[SLOW] = row[FAST] = row[at + BUMP] = 1.0
                row[SCALE] = foot_px * distance_m / tyres_m
                row[at + DISTANCE] = -row[SCALE]
                residuals.append(box.bottom - pitched_px - bump_px - foot_px)
                variances.append(noise.bottom_sigma_px(box) ** 2 * white)
            if edges.top and measures_height(box, size, noise):
                ratio = math.exp(log_height) / height_m
                row = rows[len(residuals)]
                row[HORIZON] = row[SLOW] = row[FAST] = row[at + BUMP] = 1.0
                row[SCALE] = below_px * distance_m / depth_m * (1 - ratio)
                row[at + DISTANCE] = -row[SCALE]
                row[at + HEIGHT] = -below_px * ratio
                residuals.append(box.y - pitched_px - bump_px - below_px * (1 - ratio))
                variances.append(noise.edge_sigma_px(box) ** 2 * white)
            if edges.across and measures_width(box, size, noise):
                side_m = 0.0
                if kind < self.prior.rear_count and noise.shows_side:
                    side_m = self._side_m(box, kind, distance_m, width_m, focal_px)
                row = rows[len(residuals)]
                row[SCALE] = distance_m / depth_m
                row[at + DISTANCE] = -row[SCALE]
                row[WIDER] = row[at + WIDTH] = row[at + ASPECT] = 1.0
                log_usual = log_part + wider + math.log1p(side_m / width_m)
                views[-1] = self._turned(sighting, view, log_usual, x, covariance)
                expected = log_focal + math.log((width_m + side_m) / depth_m) + wider + aspect
                residuals.append(math.log(box.w) - expected)
                variances.append(noise.log_width_sigma(box) ** 2 * white)
            shows_corner = box.w >= model.corner_aspect * box.h
            farthest_m = model.corner_path_m if shows_corner else model.common_path_m
            tells = view.lateral_m <= farthest_m and not doubtful
            common += [tells] * (len(residuals) - before)
        count = len(residuals)
        return Measurements(
            rows[:count], np.array(residuals), np.array(variances), np.array(common, bool), views
        )
