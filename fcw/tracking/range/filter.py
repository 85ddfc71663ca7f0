"""One extended Kalman filter for the distances of all vehicles and for the camera that sees them.

Errors of the calibration and the pitch of our body are common to all vehicles and all frames. As noise of
each measurement they would be averaged away, which is wrong. So they are part of the state, as the map is in
simultaneous localisation and mapping (Smith, Self & Cheeseman 1990). The camera's state is

    B, log K, C   the row map v = B + K / (D + C), see `fcw.camera.ground_plane`
    p             slow pitch due to load and slopes, in rows (px)
    q             fast pitch of the body on its springs, in rows (px), about the pitch measured by own motion
    b             log factor by which all boxes are too wide, due to the detector or because vehicles are
                  wider here; constant

and each vehicle's, in modified polar coordinates (Aidala & Hammel 1983; here size stands for angle), is

    l = log D     D: distance from the camera, m
    r = V / D     V: closing speed; r is one over the time to contact (Dagan et al. 2004)
    s = A / D     A: rate at which the closing speed grows, apart from our own known acceleration
    o = log W     W: width of its rear, m; constant, so that the vehicle becomes its own ruler
    t = log H     H: its height, m; constant, too
    e             log factor by which its box is wider because it turns
    u             how much lower it stands than the flat road, in rows (px)
    z             logarithm of D + C at the moment when its looks were stored

Measured are the row of the lower edge, that of the upper edge if the detector measures heights, and the log
width. With tan(a) = C / h, and O the overhang of its kind, by which its tyres stand ahead of its rear:

    v_bottom = B + K / (D + O + C) + p + q + u
    v_top    = B + K / (D + C) (1 - H / h) + p + q + u
    log w    = log(K cos(a) / h) - log(D + C) + log(W + side) + e + b

If it is followed by its looks, their growth is measured too, which needs neither its size nor the horizon:

    log g    = z - log(D + C)
"""

import math
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration, Gaussian
from fcw.motion.state import STRAIGHT, Mount, OwnPath
from fcw.tracking.association import WHOLE, Edges
from fcw.tracking.box_measurement import (
    ASPECT,
    BUMP,
    CAMERA,
    DISTANCE,
    FAST,
    GROWTH,
    HEIGHT,
    HORIZON,
    LOOKS,
    POLE,
    RATE,
    SCALE,
    SLOW,
    SMALLEST_DEPTH_M,
    VEHICLE,
    WIDER,
    WIDTH,
    BoxGeometry,
    Sighting,
    View,
)
from fcw.tracking.range.body_pitch import BodyPitch
from fcw.tracking.range.boxed_part import BoxedPart, judge_widths
from fcw.tracking.range.model import RangeModel
from fcw.tracking.range.state import RangeState
from fcw.tracking.range.update import NOTHING, kalman_update, take_measurements
from fcw.tracking.ranging import BoxNoise

EVERY_EDGE: Mapping[int, Edges] = MappingProxyType({})
STRONGEST_SHRINK = 0.2
"""One prediction step leaves at least this fraction of the distance, so that it stays positive."""
DIFFUSE_LOG_SIGMA = 1.0
"""1-sigma of the log distance before the first box: a factor of three either way."""
KIND_INTERVAL = 5
"""The kind of each vehicle is judged again after this many frames."""


class RangeFilter:
    """Estimates distances, closing speeds and sizes of vehicles, which are numbered from 0 as they are added.

    Args:
        calibration: calibration for the image size of the boxes.
        box_noise: errors of the boxes.
        model: prior knowledge of vehicles, camera and road.
    """

    def __init__(self, calibration: Calibration, box_noise: BoxNoise, model: RangeModel) -> None:
        self._calibrated = camera = calibration.camera
        self._model, self._box_noise, self._focal_px = model, box_noise, camera.focal_y_px
        self._geometry = BoxGeometry(camera, calibration.image_size, box_noise, model)
        self._prior = self._geometry.prior
        self._kinds: list[int] = []
        self._views: list[View] = []
        self._parts: list[BoxedPart] = []
        self._frame, self._body = 0, BodyPitch(model)

        scale = camera.row_scale_m_px
        depths_m = np.array(calibration.support_distances_m) + calibration.reference_offset_m + camera.pole_m
        rows_by_camera = np.column_stack((np.ones(3), scale / depths_m, -scale / depths_m**2))
        camera_by_rows = np.linalg.inv(rows_by_camera)
        self._x = np.array([camera.horizon_row_px, math.log(scale), camera.pole_m, 0.0, 0.0, 0.0])
        self._p = np.zeros((CAMERA, CAMERA))
        self._p[:SLOW, :SLOW] = camera_by_rows @ np.array(calibration.covariance) @ camera_by_rows.T
        self._p[SLOW, SLOW] = (self._focal_px * model.slow_pitch_sigma_rad) ** 2
        self._p[FAST, FAST] = (self._focal_px * model.fast_pitch_sigma_rad) ** 2
        self._p[WIDER, WIDER] = model.fleet_width_sigma**2 + box_noise.width_bias_sigma**2
        self.calibration_sigma_rad = math.sqrt(self._p[HORIZON, HORIZON]) / self._focal_px
        self._p[HORIZON, HORIZON] += (self._focal_px * model.calibration_pitch_sigma_rad) ** 2
        # Of the row map, boxes only update the horizon. K and C follow as far as the calibration ties them to
        # it.
        self._learns = np.eye(CAMERA)
        by_horizon = self._p[:, HORIZON] / max(self._p[HORIZON, HORIZON], 1e-12)
        for place in (SCALE, POLE):
            self._learns[place, place], self._learns[place, HORIZON] = 0.0, by_horizon[place]

    @property
    def count(self) -> int:
        """Number of vehicles."""
        return len(self._kinds)

    @property
    def focal_px(self) -> float:
        """Estimated focal length; it follows the horizon if the calibration ties the two together."""
        return math.exp(float(self._x[SCALE])) / math.hypot(self._geometry.height_m, float(self._x[POLE]))

    @property
    def pitch_rad(self) -> float:
        """How much lower the camera looks now than when it was calibrated, slopes and springs included."""
        horizon_px = float(self._x[HORIZON] + self._x[SLOW] + self._x[FAST])
        return (self._calibrated.horizon_row_px - horizon_px) / self._focal_px

    @property
    def mount(self) -> Mount:
        """Estimated orientation of the mount from vehicles and own motion, without slopes and springs."""
        off_rad = (self._calibrated.horizon_row_px - float(self._x[HORIZON])) / self._focal_px
        return Mount(
            pitch_rad=self._calibrated.pitch_rad + off_rad,
            pitch_sigma_rad=math.sqrt(max(float(self._p[HORIZON, HORIZON]), 0.0)) / self._focal_px,
        )

    def add(self, box: Box, ego_speed_mps: float | None, edges: Edges = WHOLE) -> bool:
        """Add a vehicle; returns False if its box gives no distance.

        Args:
            box: its first box.
            ego_speed_mps: own speed; None when unknown.
            edges: which edges of the box are the vehicle's own.
        """
        first = self._geometry.first_sight(box, self._x, self._p)
        if first is None:
            return False
        kind, distance_m = first
        model, n = self._model, len(self._x)
        closing_mps, closing_sigma_mps = 0.0, model.closing_sigma_mps
        if ego_speed_mps is not None:
            closing_mps = ego_speed_mps / 2
            closing_sigma_mps = ego_speed_mps / 2 + model.closing_margin_mps
        sizes, sigmas = self._prior.log_sizes[kind], self._prior.sigmas[kind]
        view = self._geometry.view(box, kind, distance_m, math.exp(sizes[0]), self.focal_px)
        self._x = np.concatenate(
            (self._x, (math.log(distance_m), closing_mps / distance_m, 0.0, *sizes, 0.0, 0.0, 0.0))
        )
        covariance = np.zeros((n + VEHICLE, n + VEHICLE))
        covariance[:n, :n] = self._p
        covariance.flat[n * (n + VEHICLE + 1) :: n + VEHICLE + 1] = np.square(
            (
                DIFFUSE_LOG_SIGMA,
                closing_sigma_mps / distance_m,
                model.acceleration_sigma_mps2 / distance_m,
                *sigmas,
                view.aspect_sigma,
                view.bump_sigma_px,
                DIFFUSE_LOG_SIGMA,
            )
        )
        # What is unknown is K / D, its place in the picture. No box of any vehicle tells K alone.
        at = n + DISTANCE
        covariance[at, :n] = covariance[:n, at] = self._p[SCALE]
        covariance[at, at] += self._p[SCALE, SCALE]
        self._p = covariance
        self._kinds.append(kind)
        self._views.append(view)
        self._parts.append(BoxedPart())
        self.update([(self.count - 1, box)], math.inf, {self.count - 1: edges})
        return True

    def keep(self, slots: Sequence[int]) -> None:
        """Keep only these vehicles; they are renumbered in the order given."""
        chosen = CAMERA + VEHICLE * np.array(slots, int)[:, None] + np.arange(VEHICLE)
        index = np.concatenate((np.arange(CAMERA), chosen.ravel()))
        self._x, self._p = self._x[index], self._p[np.ix_(index, index)]
        self._kinds = [self._kinds[slot] for slot in slots]
        self._views = [self._views[slot] for slot in slots]
        self._parts = [self._parts[slot] for slot in slots]

    def predict(
        self,
        dt_s: float,
        own_gain_mps: float = 0.0,
        path: OwnPath = STRAIGHT,
        own_gain_sigma_mps: float = 0.0,
        body_pitch_rad: Gaussian | None = None,
    ) -> list[float]:
        """Move on by dt.

        Args:
            dt_s: since the frame before.
            own_gain_mps: change of our speed in that time, by which every closing speed grows.
            path: our own path, with which vehicles align.
            own_gain_sigma_mps: 1-sigma of `own_gain_mps` if the camera measured it, in which case it scales
                with the calibration; 0 if the speed was given.
            body_pitch_rad: measured pitch of the body, positive nose down; None if it is not measured.

        Returns:
            For each vehicle, the factor by which it grew in the picture.
        """
        model, x, n, focal_px = self._model, self._x, len(self._x), self._focal_px
        self._geometry.path = path
        told_before_rad = self._body.update(dt_s, own_gain_mps, body_pitch_rad)
        at: NDArray[np.int64] = np.arange(CAMERA, n, VEHICLE)
        keep, added = np.ones(n), np.zeros(n)
        for places, sigma, correlation_s in (  # first-order Markov processes about zero
            (SLOW, focal_px * model.slow_pitch_sigma_rad, model.slow_pitch_correlation_s),
            (FAST, focal_px * self._body.sigma_rad, model.fast_pitch_correlation_s),
            (at + ASPECT, np.array([v.aspect_sigma for v in self._views]), model.aspect_correlation_s),
            (at + BUMP, np.array([v.bump_sigma_px for v in self._views]), model.bump_correlation_s),
        ):
            keep[places] = math.exp(-dt_s / correlation_s)
            added[places] = np.square(sigma) * (1 - math.exp(-2 * dt_s / correlation_s))
        x *= keep
        x[FAST] += focal_px * (keep[FAST] * told_before_rad - self._body.told_rad)  # the rest fades
        moved = np.diag(keep)
        rate, growth = x[at + RATE], x[at + GROWTH]
        lasting = math.exp(-dt_s / model.acceleration_correlation_s)
        shrink = np.maximum(1 - rate * dt_s - growth * dt_s**2 / 2, STRONGEST_SHRINK)
        x[at + DISTANCE] += np.log(shrink)
        x[at + RATE] = new_rate = (rate + growth * dt_s) / shrink
        x[at + GROWTH] = new_growth = growth * lasting / shrink
        # The Jacobian: shrink itself falls by dt for each unit of r and by dt^2 / 2 for each of s.
        by_rate, by_growth = -dt_s / shrink, -(dt_s**2) / 2 / shrink
        moved[at + DISTANCE, at + RATE] = by_rate
        moved[at + DISTANCE, at + GROWTH] = by_growth
        moved[at + RATE, at + RATE] = 1 / shrink - new_rate * by_rate
        moved[at + RATE, at + GROWTH] = dt_s / shrink - new_rate * by_growth
        moved[at + GROWTH, at + RATE] = -new_growth * by_rate
        moved[at + GROWTH, at + GROWTH] = lasting / shrink - new_growth * by_growth
        believed = math.exp(float(x[SCALE])) / self._calibrated.row_scale_m_px if own_gain_sigma_mps else 1.0
        gained = believed * own_gain_mps * np.exp(-x[at + DISTANCE])
        x[at + RATE] += gained
        if own_gain_sigma_mps:
            moved[at + RATE, SCALE] += gained
        lasting_mps = model.lasting_gain_error * own_gain_sigma_mps
        added[at + RATE] = (lasting_mps * np.exp(-x[at + DISTANCE])) ** 2
        moved[at + RATE, at + RATE] -= gained * by_rate
        moved[at + RATE, at + GROWTH] -= gained * by_growth
        moved[at + RATE, at + DISTANCE] = -gained
        added[at + GROWTH] = (
            model.acceleration_sigma_mps2**2 * (1 - lasting**2) * np.exp(-2 * x[at + DISTANCE])
        )
        added[HORIZON] = (focal_px * model.mount_drift_rad_per_sqrt_s) ** 2 * dt_s
        added[at + WIDTH] = added[at + HEIGHT] = model.size_drift_per_sqrt_s**2 * dt_s
        self._p = moved @ self._p @ moved.T
        self._p.flat[:: n + 1] += added
        return (1 / shrink).tolist()

    def take_mount(self, pitch_rad: float, sigma_rad: float, dt_s: float) -> None:
        """Update with the mount's pitch estimated by own motion.

        It hardly changes from frame to frame, so it counts as one measurement per `model.mount_lasts_s`.

        Args:
            pitch_rad: angle of the optical axis below the road.
            sigma_rad: 1-sigma of the pitch.
            dt_s: time since the previous frame.
        """
        if dt_s <= 0:
            return
        row_px = self._calibrated.horizon_row_px - self._focal_px * (pitch_rad - self._calibrated.pitch_rad)
        sigma_rad = math.hypot(sigma_rad, self._model.mount_sigma_rad)
        variance = (self._focal_px * sigma_rad) ** 2 * max(self._model.mount_lasts_s / dt_s, 1.0)
        told = np.eye(1, len(self._x), HORIZON), np.array([row_px - self._x[HORIZON]]), np.array([variance])
        self._x, self._p = kalman_update(self._x, self._p, *told, self._learns)

    def update(
        self,
        boxes: Sequence[tuple[int, Box]],
        dt_s: float,
        edges: Mapping[int, Edges] = EVERY_EDGE,
        doubtful: Collection[int] = (),
    ) -> None:
        """Update with the boxes of one frame.

        Args:
            boxes: pairs of a vehicle's index and its box.
            dt_s: time since the previous frame; infinite for the first box of a vehicle.
            edges: by index, which edges of a box are the vehicle's own, if only a part of it was boxed.
            doubtful: indices of objects that may be no vehicles; they do not update the camera's state.
        """
        sightings = [
            Sighting(n, self._kinds[n], box, edges.get(n, WHOLE), n in doubtful, self._parts[n].log_part)
            for n, box in boxes
        ]
        seen = self._geometry.measure(sightings, self._x, self._p, dt_s)
        slots, white = [slot for slot, _ in boxes], self._box_noise.white(dt_s)
        seen = judge_widths(seen, self._x, self._p, white, slots, self._parts)
        for slot, view in zip(slots, seen.views, strict=True):
            self._views[slot] = view
        self._x, self._p = take_measurements(self._x, self._p, seen, self._learns)
        self._frame += 1
        for slot in range(self._frame % KIND_INTERVAL, self.count, KIND_INTERVAL):
            self._judge_kind(slot)

    def begin_growth(self, slot: int) -> None:
        """Begin to measure the growth of a vehicle's looks, which were just stored anew.

        The state of the old looks is replaced by the logarithm of the present D + C.
        """
        at = CAMERA + VEHICLE * slot
        looks = at + LOOKS
        depth_m, by_distance = self._depth(slot)
        self._x[looks] = math.log(depth_m)
        # A copy of log(D + C), so it is fully correlated with D and C.
        row = by_distance * self._p[at + DISTANCE] + (1 - by_distance) * self._p[SCALE]
        self._p[looks] = self._p[:, looks] = row
        self._p[looks, looks] = by_distance * row[at + DISTANCE] + (1 - by_distance) * row[SCALE]

    def take_growths(self, growths: Sequence[tuple[int, float, float]], dt_s: float) -> None:
        """Update with the growth of vehicles' looks since they were stored.

        Args:
            growths: index of the vehicle, logarithm of the growth, and its 1-sigma.
            dt_s: time since the previous frame.
        """
        if not growths:
            return
        white = max(1.0, 2 * self._model.looks_correlation_s / dt_s)
        rows, (residuals, variances) = np.zeros((len(growths), len(self._x))), np.zeros((2, len(growths)))
        for row, (slot, log_growth, sigma) in enumerate(growths):
            at = CAMERA + VEHICLE * slot
            depth_m, by_distance = self._depth(slot)
            rows[row, [at + LOOKS, at + DISTANCE, SCALE]] = 1.0, -by_distance, by_distance - 1
            residuals[row] = log_growth - (self._x[at + LOOKS] - math.log(depth_m))
            variances[row] = sigma**2 * white
        self._x, self._p = kalman_update(self._x, self._p, rows, residuals, variances, NOTHING)

    def _depth(self, slot: int) -> tuple[float, float]:
        """D + C of a vehicle, and the derivative of its logarithm by log D; that by log K is 1 minus this.

        C is taken to grow with K, as in `Measurements.rows`; otherwise wrong growths would change the scale.
        """
        distance_m = math.exp(self._x[CAMERA + VEHICLE * slot + DISTANCE])
        depth_m = max(distance_m + float(self._x[POLE]), SMALLEST_DEPTH_M)
        return depth_m, distance_m / depth_m

    def boxed_part(self, slot: int) -> BoxedPart:
        """Which part of a vehicle's width is boxed."""
        return self._parts[slot]

    def kind(self, slot: int) -> int:
        """Index of the likeliest kind of a vehicle."""
        return self._kinds[slot]

    def ruler(self, slot: int, box: Box) -> tuple[float, float, float, float] | None:
        """The horizon implied by the usual width of a vehicle; see `BoxGeometry.ruler`."""
        distance_m = math.exp(self._x[CAMERA + VEHICLE * slot + DISTANCE])
        return self._geometry.ruler(Sighting(slot, self._kinds[slot], box), distance_m)

    def state(self, slot: int) -> RangeState:
        """The estimated state of a vehicle."""
        at = CAMERA + VEHICLE * slot
        index = [SCALE, *range(at, at + 3)]
        width_m = math.exp(float(self._x[at + WIDTH] + self._x[WIDER]) + self._parts[slot].log_part)
        kind, prior = self._kinds[slot], self._prior
        length_m, overhang_m = prior.lengths_m[kind], prior.overhangs_m[kind]
        return RangeState.of(
            self._x[at : at + 3], self._p[np.ix_(index, index)], width_m, length_m, overhang_m, self._model
        )

    def _judge_kind(self, slot: int) -> None:
        """Replace the prior of a vehicle's size if it turns out to be of another kind."""
        at = CAMERA + VEHICLE * slot + WIDTH
        mean_width, mean_height = self._x[at : at + 2].tolist()
        (ww, wh), (_, hh) = self._p[at : at + 2, at : at + 2].tolist()
        swap = self._prior.likelier(self._kinds[slot], (mean_width, mean_height), ((ww, wh), (wh, hh)))
        if swap is None:
            return
        self._kinds[slot] = swap.kind
        for place, precision, information in zip((at, at + 1), swap.precision, swap.information, strict=True):
            # Information filter, one component at a time: P'^-1 = P^-1 + precision e e'.
            column = self._p[:, place].copy()
            divisor = 1 + precision * column[place]
            self._x = self._x + column * ((information - precision * self._x[place]) / divisor)
            self._p = self._p - np.outer(column, column) * (precision / divisor)
