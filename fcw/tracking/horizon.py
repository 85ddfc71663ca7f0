"""The camera's own part of ranging: whether the mount has moved."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fcw.camera.ground_plane import FloatArray


class RulerReading(NamedTuple):
    """Where a vehicle in sight puts the horizon, when its width is the ruler.

    Attributes:
        vehicle: numbers of its track and of its kind: if it turns out to be of another kind, it is another
            ruler.
        pitch_rad: how much lower than calibrated the camera looks if the vehicle is as wide as its kind is in
            the median.
        below_rad: how far its lower edge is below the horizon: a vehicle wider by a part shows a pitch higher
            by that part of this.
        width_sigma: 1-sigma of the logarithm of its width.
        noise_rad: 1-sigma of this reading by the noise of its box.
    """

    vehicle: tuple[int, int]
    pitch_rad: float
    below_rad: float
    width_sigma: float
    noise_rad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MountWatchSettings:
    """When a moved mount is said.

    Attributes:
        step_s: readings of this time make one measurement.
        onset_step_s: a move of the mount may begin at each multiple of this time.
        onsets: the number of such moments, the latest ones, that are held possible beside the start of the
            drive.
        jump_sigma_rad: 1-sigma of a move of the mount.
        evidence: logarithm of the odds from which the mount is said to have moved. In ten simulated hours
            without a turn nothing was said; in one of 24 drives it was said before the turn.
        said_rad: a change larger than this is said.
        withdrawn_rad: it is said until the change is back to less than this.
        drift_rad_per_sqrt_s: random walk of the mount, by warmth and load.
        slow_pitch_rad: 1-sigma of the pitch by load and slopes, common to all vehicles.
        slow_pitch_s: correlation time of that pitch.
        fast_pitch_rad: 1-sigma of the pitch of the body in the mean of a step, common to all.
        bump_rad: 1-sigma of the road below one vehicle, in the mean of a step; larger than it is, because it
            lasts longer.
        turned: 1-sigma of how far a vehicle turns, as a part of its width.
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
"""Places in the state of a hypothesis; the widths of the vehicles in sight follow."""


class MountWatch:
    """Tells whether the camera looks elsewhere than it did when it was calibrated.

    A vehicle whose width is not known says little of the horizon, but it says at once when the horizon
    jumps: its width stays. So every moment of the last minutes is a hypothesis, "the mount jumped then",
    besides "it did not": each a Kalman filter of the mount's pitch, the road's, and the widths of the
    vehicles in sight. The likelihoods of their innovations decide (Willsky & Jones 1976, "A generalized
    likelihood ratio approach to the detection and estimation of jumps in linear systems"), which is the
    soonest a jump of unknown size can be told at a given rate of false alarms (Page 1954; Lorden 1971).
    A jump at the start is a wrong calibration.

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
        """Whether the camera looks elsewhere."""
        return self._moved

    def update(self, readings: Sequence[RulerReading], dt_s: float) -> None:
        """Take the vehicles of a frame; a frame without any says nothing and takes no time.

        Args:
            readings: of the vehicles in sight.
            dt_s: since the frame before.
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
        """What to tell, or None."""
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
        """Forget the widths of vehicles out of sight, and begin with those of new ones."""
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
        """One more hypothesis, that the mount jumps now; the oldest one after the start's is given up."""
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
            # Against where it was, as far as this drive had shown it: the clicks err by as much as a jump.
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
