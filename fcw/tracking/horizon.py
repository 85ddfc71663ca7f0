"""Detects from the vehicles in sight whether the camera's mount has moved."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fcw.camera.ground_plane import FloatArray


class RulerReading(NamedTuple):
    """The horizon implied by a vehicle in sight, with its width as the ruler.

    Attributes:
        vehicle: its track id and the index of its kind. If it turns out to be of another kind, it is another
            ruler.
        pitch_rad: how much lower than calibrated the camera looks if the vehicle has the median width of its
            kind.
        below_rad: angle of its lower edge below the horizon. If the vehicle is wider than the median by some
            fraction, the pitch is wrong by that fraction of this angle.
        width_sigma: 1-sigma of the logarithm of its width.
        noise_rad: 1-sigma of this reading due to the noise of its box.
    """

    vehicle: tuple[int, int]
    pitch_rad: float
    below_rad: float
    width_sigma: float
    noise_rad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MountWatchSettings:
    """When a moved mount is reported.

    Attributes:
        step_s: readings over this time are averaged to one measurement.
        onset_step_s: the mount may have moved at any multiple of this time.
        onsets: how many of the latest such moments are considered, in addition to the start of the drive.
        jump_sigma_rad: 1-sigma of a move of the mount.
        evidence: log odds from which the mount is reported to have moved. In ten simulated hours without a
            move, none was reported; in one of 24 drives it was reported before the move.
        said_rad: a change larger than this is reported.
        withdrawn_rad: a report is withdrawn once the change is smaller than this.
        drift_rad_per_sqrt_s: random walk of the mount, due to temperature and load.
        slow_pitch_rad: 1-sigma of the pitch due to load and slopes, common to all vehicles.
        slow_pitch_s: correlation time of that pitch.
        fast_pitch_rad: 1-sigma of the pitch of our body, averaged over a step, common to all vehicles.
        bump_rad: 1-sigma of the unevenness of the road below one vehicle, averaged over a step; larger than
            measured, because it is correlated from step to step.
        turned: 1-sigma of how much a vehicle's turning changes its width, as a fraction of it.
    """

    step_s: float = 1.0
    onset_step_s: float = 10.0
    onsets: int = 18
    jump_sigma_rad: float = math.radians(0.5)
    evidence: float = 9.0
    said_rad: float = math.radians(0.25)
    withdrawn_rad: float = math.radians(0.15)
    drift_rad_per_sqrt_s: float = math.radians(0.002)
    slow_pitch_rad: float = math.radians(0.07)
    slow_pitch_s: float = 20.0
    fast_pitch_rad: float = math.radians(0.16)
    bump_rad: float = math.radians(0.25)
    turned: float = 0.03


MOUNT, SLOW, FAST, COMMON = 0, 1, 2, 3
"""Indices into the state of a hypothesis; the log widths of the vehicles in sight follow."""


class MountWatch:
    """Tells whether the camera looks elsewhere than it did when it was calibrated.

    A vehicle of unknown width tells little about the horizon, but it shows at once when the horizon jumps,
    because its width does not change. So there is one hypothesis for every moment of the last minutes, "the
    mount jumped then", and one for "it did not". Each is a Kalman filter of the mount's pitch, the road's
    pitch and the widths of the vehicles in sight. The likelihoods of their innovations decide (Willsky &
    Jones 1976, "A generalized likelihood ratio approach to the detection and estimation of jumps in linear
    systems"). At a given rate of false alarms, this detects a jump of unknown size as soon as possible (Page
    1954; Lorden 1971). A jump at the start means that the calibration is wrong.

    Args:
        calibration_sigma_rad: 1-sigma of the horizon by the calibration.
        settings: see `MountWatchSettings`.
    """

    def __init__(self, calibration_sigma_rad: float, settings: MountWatchSettings | None = None) -> None:
        self._settings = settings or MountWatchSettings()
        self._vehicles: list[tuple[int, int]] = []
        self._x = np.zeros((1, COMMON))
        self._p = np.zeros((1, COMMON, COMMON))
        self._p[0, MOUNT, MOUNT] = calibration_sigma_rad**2
        self._p[0, SLOW, SLOW] = self._settings.slow_pitch_rad**2
        self._log_likelihood = np.zeros(1)
        self._suppose_jump()
        self._sums: dict[tuple[int, int], FloatArray] = {}
        self._step_s = self._since_onset_s = 0.0
        self._moved = False
        self._reference_rad: float | None = None
        self.deviation_rad = 0.0

    @property
    def moved(self) -> bool:
        """Whether the camera looks elsewhere than it did."""
        return self._moved

    def update(self, readings: Sequence[RulerReading], dt_s: float) -> None:
        """Update with the vehicles of a frame. A frame without any is skipped, and its time does not count.

        Args:
            readings: readings of the vehicles in sight.
            dt_s: time since the previous frame.
        """
        if not readings:
            return
        for reading in readings:
            sums = self._sums.setdefault(reading.vehicle, np.zeros(5))
            sums += (1.0, reading.pitch_rad, reading.below_rad, reading.width_sigma, reading.noise_rad**2)
        self._step_s += dt_s
        if self._step_s >= self._settings.step_s:
            self._take_step()
            self._decide()
            self._sums, self._step_s = {}, 0.0

    @property
    def note(self) -> str | None:
        """The note, or None if there is nothing to tell."""
        if not self._moved:
            return None
        direction = "down" if self.deviation_rad > 0 else "up"
        return (
            f"the camera looks {math.degrees(abs(self.deviation_rad)):.1f} degrees farther {direction} than "
            "when it was calibrated: the mount has moved, or the calibration is wrong; distances are "
            "computed for where it looks now; calibrate again"
        )

    def _take_step(self) -> None:
        settings, step_s = self._settings, self._step_s
        self._follow_vehicles()
        lasting = math.exp(-step_s / settings.slow_pitch_s)
        self._p[:, MOUNT, MOUNT] += settings.drift_rad_per_sqrt_s**2 * step_s
        for place, keep, sigma in (
            (SLOW, lasting, settings.slow_pitch_rad),
            (FAST, 0.0, settings.fast_pitch_rad),
        ):
            self._x[:, place] *= keep
            self._p[:, place, :] *= keep
            self._p[:, :, place] *= keep
            self._p[:, place, place] += sigma**2 * (1 - keep**2)
        self._since_onset_s += step_s
        if self._since_onset_s >= settings.onset_step_s:
            self._suppose_jump()
        for vehicle, sums in self._sums.items():
            _, pitch_rad, below_rad, _, noise_variance = sums / sums[0]
            by_state = np.zeros(self._x.shape[1])
            by_state[:COMMON] = 1.0
            by_state[COMMON + self._vehicles.index(vehicle)] = below_rad
            variance = settings.bump_rad**2 + (settings.turned * below_rad) ** 2 + noise_variance / sums[0]
            spread = self._p @ by_state
            expected = spread @ by_state + variance
            innovation = pitch_rad - self._x @ by_state
            self._log_likelihood -= (innovation**2 / expected + np.log(expected)) / 2
            gain = spread / expected[:, None]
            self._x += gain * innovation[:, None]
            self._p -= gain[:, :, None] * spread[:, None, :]

    def _follow_vehicles(self) -> None:
        """Remove the widths of vehicles out of sight from the state, and add those of new ones."""
        kept = [place for place, vehicle in enumerate(self._vehicles) if vehicle in self._sums]
        index = [*range(COMMON), *(COMMON + place for place in kept)]
        self._vehicles = [self._vehicles[place] for place in kept]
        new = [vehicle for vehicle in self._sums if vehicle not in self._vehicles]
        hypotheses, size = len(self._x), len(index)
        x = np.zeros((hypotheses, size + len(new)))
        p = np.zeros((hypotheses, size + len(new), size + len(new)))
        x[:, :size] = self._x[:, index]
        p[:, :size, :size] = self._p[:, index][:, :, index]
        for place, vehicle in enumerate(new, size):
            p[:, place, place] = (self._sums[vehicle][3] / self._sums[vehicle][0]) ** 2
        self._vehicles += new
        self._x, self._p = x, p

    def _suppose_jump(self) -> None:
        """Add the hypothesis that the mount jumps now, and drop the oldest one except that of the start."""
        self._since_onset_s = 0.0
        jumped = self._p[:1].copy()
        jumped[0, MOUNT, MOUNT] += self._settings.jump_sigma_rad**2
        self._x = np.concatenate((self._x, self._x[:1]))
        self._p = np.concatenate((self._p, jumped))
        self._log_likelihood = np.append(self._log_likelihood, self._log_likelihood[0])
        if len(self._x) > 2 + self._settings.onsets:
            self._keep([0, 1, *range(3, len(self._x))])

    def _keep(self, hypotheses: list[int]) -> None:
        self._x, self._p = self._x[hypotheses], self._p[hypotheses]
        self._log_likelihood = self._log_likelihood[hypotheses]

    def _decide(self) -> None:
        self._log_likelihood -= self._log_likelihood[0]
        best = int(np.argmax(self._log_likelihood))
        if self._log_likelihood[best] <= self._settings.evidence:
            if self._reference_rad is not None:
                self._judge(float(self._x[0, MOUNT]))
            return
        if self._reference_rad is None:
            # Changes count from where the camera looked earlier in this drive, if it jumped in mid-drive: the
            # calibration itself may be off by as much as a jump.
            self._reference_rad = float(self._x[0, MOUNT]) if best > 1 else 0.0
        self._keep([best])
        self._log_likelihood[:] = 0.0
        self._suppose_jump()
        self._judge(float(self._x[0, MOUNT]))

    def _judge(self, pitch_rad: float) -> None:
        assert self._reference_rad is not None
        self.deviation_rad = pitch_rad - self._reference_rad
        settings = self._settings
        self._moved = abs(self.deviation_rad) > (settings.withdrawn_rad if self._moved else settings.said_rad)
