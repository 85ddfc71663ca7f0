"""One extended Kalman filter for the distances of all vehicles and for the camera that sees them.

What is wrong with the calibration, and how the body pitches, is common to all vehicles and all frames: as
noise of each measurement it would be averaged away that should not be, so it is state, as the map is in
simultaneous localisation and mapping (Smith, Self & Cheeseman 1990). The state of the camera is

    B, log K, C   the row map v = B + K / (D + C), see `fcw.camera.ground_plane`
    p             pitch by load and slopes, px of rows, slow
    q             pitch of the body on its springs, px of rows, fast; about what own motion tells of it
    b             how much wider all boxes are, of the logarithm, by the detector or because vehicles
                  are wider here; constant

and that of each vehicle, in modified polar coordinates (Aidala & Hammel 1983; here size stands for angle)

    l = log D     D: distance from the camera, m
    r = V / D     V: closing speed; r is one over the time to contact (Dagan et al. 2004)
    s = A / D     A: rate at which the closing speed grows, our own known part of it aside
    o = log W     W: width of its rear, m; constant, so that the vehicle becomes its own ruler
    t = log H     H: its height, m, likewise
    e             how much wider its box is, of the logarithm, as it turns
    u             how much lower it stands than the flat road, px of rows
    z             log of the distance at which its looks were remembered, plus C

Measured are the rows of the lower edge and, where boxes have a height of their own, of the upper edge,
and the logarithm of the width, with tan(a) = C / h, and O the overhang of its kind, by which its tyres stand
ahead of its rear:

    v_bottom = B + K / (D + O + C) + p + q + u
    v_top    = B + K / (D + C) (1 - H / h) + p + q + u
    log w    = log(K cos(a) / h) - log(D + C) + log(W + side) + e + b

and, where it is followed by its looks, by how much they have grown, which knows no size and no horizon:

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
"""One prediction step leaves at least this part of the distance: the gap never turns negative."""
DIFFUSE_LOG_SIGMA = 1.0
"""Of the distance before the first box is taken: a factor of three either way."""
KIND_INTERVAL = 5
"""The kind of a vehicle is judged anew every so many frames."""


class RangeFilter:
    """Distances, closing speeds and sizes of vehicles, which are numbered from 0 in the order they came.

    Args:
        calibration: for the size of the pictures the boxes come from.
        box_noise: errors of the boxes.
        model: beliefs.
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
        # Of the row map boxes teach the horizon; K and C go with it as far as the calibration ties them.
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
        """Focal length as it is believed now: it goes with the horizon where three clicks tie the two."""
        return math.exp(float(self._x[SCALE])) / math.hypot(self._geometry.height_m, float(self._x[POLE]))

    @property
    def pitch_rad(self) -> float:
        """How much lower the camera looks now than it was calibrated to: the horizon stands higher."""
        horizon_px = float(self._x[HORIZON] + self._x[SLOW] + self._x[FAST])
        return (self._calibrated.horizon_row_px - horizon_px) / self._focal_px

    @property
    def mount(self) -> Mount:
        """Where the camera looks for good, as vehicles and own motion tell it: without slopes and springs."""
        off_rad = (self._calibrated.horizon_row_px - float(self._x[HORIZON])) / self._focal_px
        return Mount(
            pitch_rad=self._calibrated.pitch_rad + off_rad,
            pitch_sigma_rad=math.sqrt(max(float(self._p[HORIZON, HORIZON]), 0.0)) / self._focal_px,
        )

    def add(self, box: Box, ego_speed_mps: float | None, edges: Edges = WHOLE) -> bool:
        """Add a vehicle; False where its box gives no distance.

        Args:
            box: the first of it.
            ego_speed_mps: own speed, None when unknown.
            edges: which of the box are the vehicle's own.
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
        # Its place in the picture, K / D, is what is not known: of K alone no box of any vehicle tells.
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
        """Forget all vehicles but these, which are numbered anew in the order given."""
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
            own_gain_mps: by how much we became faster in it; every closing speed grows by as much.
            path: our own now, along which vehicles stand.
            own_gain_sigma_mps: of the gain where the camera measured it: its scale is the camera's.
            body_pitch_rad: how much lower the camera looks now than its mount does; None where untold.

        Returns:
            For each vehicle the factor by which the picture of it grew.
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
        """Take the mount's pitch as own motion believes it.

        It is the same belief frame after frame: it counts as one measurement in `model.mount_lasts_s`.

        Args:
            pitch_rad: of the axis below the road.
            sigma_rad: 1-sigma.
            dt_s: since the frame before.
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
        """Take the boxes of one frame.

        Args:
            boxes: number of the vehicle, and its box.
            dt_s: since the frame before; infinite for the first box of a vehicle.
            edges: by number, those that a box shares with the vehicle, where a part of it was boxed.
            doubtful: numbers of those that may be none: they teach nothing of the camera.
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
        """Measure the growth of a vehicle's looks from here, where they were remembered anew.

        What was known of the old looks is forgotten, and the new ones are as large as they are at this
        distance, up to the noise with which they will be compared.
        """
        at = CAMERA + VEHICLE * slot
        looks = at + LOOKS
        depth_m, by_distance = self._depth(slot)
        self._x[looks] = math.log(depth_m)
        # A copy of log(D + C): wholly correlated with what it is made of.
        row = by_distance * self._p[at + DISTANCE] + (1 - by_distance) * self._p[SCALE]
        self._p[looks] = self._p[:, looks] = row
        self._p[looks, looks] = by_distance * row[at + DISTANCE] + (1 - by_distance) * row[SCALE]

    def take_growths(self, growths: Sequence[tuple[int, float, float]], dt_s: float) -> None:
        """Take by how much the looks of vehicles have grown since they were remembered.

        Args:
            growths: number of the vehicle, logarithm of the growth, and its 1-sigma.
            dt_s: since the frame before.
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
        """D + C of a vehicle, and how its logarithm grows with log D; the rest is with log K.

        C grows with K here as in `Measurements.rows`: wrong growths would teach a scale that nobody knows.
        """
        distance_m = math.exp(self._x[CAMERA + VEHICLE * slot + DISTANCE])
        depth_m = max(distance_m + float(self._x[POLE]), SMALLEST_DEPTH_M)
        return depth_m, distance_m / depth_m

    def boxed_part(self, slot: int) -> BoxedPart:
        """How much of the width of a vehicle is boxed."""
        return self._parts[slot]

    def kind(self, slot: int) -> int:
        """Index of the kind a vehicle is believed to be of."""
        return self._kinds[slot]

    def ruler(self, slot: int, box: Box) -> tuple[float, float, float, float] | None:
        """Where the box of a vehicle puts the horizon by its usual width, see `BoxGeometry.ruler`."""
        distance_m = math.exp(self._x[CAMERA + VEHICLE * slot + DISTANCE])
        return self._geometry.ruler(Sighting(slot, self._kinds[slot], box), distance_m)

    def state(self, slot: int) -> RangeState:
        """What is believed of a vehicle now."""
        at = CAMERA + VEHICLE * slot
        index = [SCALE, *range(at, at + 3)]
        width_m = math.exp(float(self._x[at + WIDTH] + self._x[WIDER]) + self._parts[slot].log_part)
        kind, prior = self._kinds[slot], self._prior
        length_m, overhang_m = prior.lengths_m[kind], prior.overhangs_m[kind]
        return RangeState.of(
            self._x[at : at + 3], self._p[np.ix_(index, index)], width_m, length_m, overhang_m, self._model
        )

    def _judge_kind(self, slot: int) -> None:
        """Replace the prior of its sizes where a vehicle turns out to be of another kind."""
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
