"""The filter of own motion: speed, yaw rate and mount, updated with the motion between pictures.

The state is

    v, a    speed, m/s, and acceleration
    r       yaw rate, rad/s, positive to the left
    m, y, o pitch, yaw and roll of the mount relative to the calibration, slow
    q, q'   pitch of the body on its springs, now and at the previous picture

The unknowns of `fcw.motion.solver` follow from it up to noise: heave and slip change the direction of travel
of every single step, the road rolls, and slopes pitch the camera in addition to the springs.
"""

import math

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray
from fcw.motion.settings import MotionSettings
from fcw.motion.solver import (
    PITCH,
    PITCH_TURN,
    ROAD_PITCH,
    ROAD_ROLL,
    ROLL_TURN,
    TRAVEL,
    UNKNOWNS,
    YAW,
    YAW_TURN,
    Solution,
)

SPEED, ACCELERATION, YAW_RATE, MOUNT_PITCH, MOUNT_YAW, MOUNT_ROLL, SPRING, SPRING_BEFORE = range(8)
STATES = 8
MOUNT = slice(MOUNT_PITCH, MOUNT_ROLL + 1)
UNKNOWN_SPEED_SIGMA_MPS = 20.0
NOD_SIGMAS = 1.5
"""A change of pitch beyond this many sigmas is a nod. Its variance is then raised until it is just this far
off. Of 1.5, 2, 2.5 and none, this has the least error of pitch on one rendered drive over bumps; nothing was
left out."""
SLOWEST_DIRECTION_MPS = 1.0
"""Least speed used for the noise of the direction of travel, which is undefined at standstill."""


class MotionFilter:
    """Estimate of own motion at the latest picture.

    Args:
        settings: see `MotionSettings`.
    """

    def __init__(self, settings: MotionSettings) -> None:
        self._settings = settings
        self.x = np.zeros(STATES)
        sigmas = (
            UNKNOWN_SPEED_SIGMA_MPS,
            settings.acceleration_sigma_mps2,
            0.2,
            settings.calibration_pitch_sigma_rad,
            settings.calibration_yaw_sigma_rad,
            settings.calibration_roll_sigma_rad,
            settings.fast_pitch_sigma_rad,
            settings.fast_pitch_sigma_rad,
        )
        self.p = np.diag(np.square(sigmas))

    def copy(self) -> "MotionFilter":
        """An independent copy."""
        other = object.__new__(MotionFilter)
        other._settings, other.x, other.p = self._settings, self.x.copy(), self.p.copy()
        return other

    def sigma(self, state: int) -> float:
        """1-sigma of an element of the state."""
        return math.sqrt(max(float(self.p[state, state]), 0.0))

    def predict(self, dt_s: float) -> None:
        """Predict the state at the next picture."""
        settings = self._settings
        moved = np.eye(STATES)
        lasting = math.exp(-dt_s / settings.acceleration_s)
        spring = math.exp(-dt_s / settings.fast_pitch_s)
        moved[SPEED, ACCELERATION] = dt_s
        moved[ACCELERATION, ACCELERATION] = lasting
        moved[SPRING_BEFORE, SPRING_BEFORE] = 0.0
        moved[SPRING_BEFORE, SPRING] = 1.0
        moved[SPRING, SPRING] = spring
        self.x = moved @ self.x
        self.p = moved @ self.p @ moved.T
        added = np.zeros(STATES)
        added[SPEED] = (settings.acceleration_sigma_mps2 * dt_s) ** 2 * dt_s
        added[ACCELERATION] = settings.acceleration_sigma_mps2**2 * (1 - lasting**2)
        added[YAW_RATE] = settings.yaw_acceleration**2 * dt_s
        added[MOUNT_PITCH : MOUNT_ROLL + 1] = settings.mount_drift_rad_per_sqrt_s**2 * dt_s
        added[SPRING] = settings.fast_pitch_sigma_rad**2 * (1 - spring**2)
        self.p.flat[:: STATES + 1] += added

    def expect(self, dt_s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mean (8,), covariance (8, 8) and Jacobian (8, 8) of the solver's unknowns for the last step."""
        settings = self._settings
        speed_mps = max(float(self.x[SPEED]), SLOWEST_DIRECTION_MPS)
        by_state = np.zeros((UNKNOWNS, STATES))
        by_state[PITCH_TURN, SPRING], by_state[PITCH_TURN, SPRING_BEFORE] = -1.0, 1.0
        by_state[YAW_TURN, YAW_RATE] = -dt_s
        by_state[TRAVEL, SPEED], by_state[TRAVEL, ACCELERATION] = dt_s, -(dt_s**2) / 2
        by_state[YAW, MOUNT_YAW] = 1.0
        # Ahead of the rear axle, the camera also moves sideways, to the left in a left turn. And over the
        # step, the mean direction of travel turns by half of the step's rotation.
        by_state[YAW, YAW_RATE] = -(settings.axle_m / speed_mps + dt_s / 2)
        by_state[PITCH, MOUNT_PITCH] = 1.0
        by_state[PITCH, SPRING_BEFORE] = 1.0
        by_state[ROAD_PITCH, MOUNT_PITCH] = by_state[ROAD_PITCH, SPRING_BEFORE] = 1.0
        by_state[ROAD_ROLL, MOUNT_ROLL] = 1.0
        noise = np.zeros(UNKNOWNS)
        noise[PITCH_TURN] = settings.slope_turn_rad
        noise[YAW_TURN] = 1e-4
        noise[ROLL_TURN] = settings.roll_turn_sigma_radps * dt_s
        noise[TRAVEL] = max(settings.travel_part * abs(float(self.x[SPEED])) * dt_s, 1e-3)
        noise[YAW] = (
            math.hypot(settings.slip_mps, settings.axle_sigma_m * float(self.x[YAW_RATE])) / speed_mps
        )
        noise[PITCH] = settings.heave_mps / speed_mps
        noise[ROAD_PITCH] = settings.road_pitch_sigma_rad
        noise[ROAD_ROLL] = settings.road_roll_sigma_rad
        covariance = by_state @ self.p @ by_state.T
        covariance.flat[:: UNKNOWNS + 1] += noise**2
        return by_state @ self.x, covariance, by_state

    def allow_nod(self, solution: Solution, mean: FloatArray, covariance: FloatArray) -> bool:
        """Allow for a larger pitch than usual on springs, as over a bump or in a hard stop.

        Returns:
            Whether the pictures show such a pitch. If so, call `expect` again, as its result has changed.
        """
        off_rad = float(solution.unknowns[PITCH_TURN] - mean[PITCH_TURN])
        unexpected = (off_rad / NOD_SIGMAS) ** 2 - float(covariance[PITCH_TURN, PITCH_TURN])
        self.p[SPRING, SPRING] += max(unexpected, 0.0)
        return unexpected > 0

    def correct(
        self, solution: Solution, mean: FloatArray, covariance: FloatArray, by_state: FloatArray
    ) -> None:
        """Update with the solver's solution, given its expectation (see `expect`).

        The solution combines expectation and points. The state is updated by conditioning the joint Gaussian
        of state and unknowns on it (Rauch, Tung & Striebel 1965).
        """
        posterior = np.linalg.inv(solution.information + np.linalg.inv(covariance))
        gain = np.linalg.solve(covariance, by_state @ self.p).T
        self.x = self.x + gain @ (solution.unknowns - mean)
        self.p = self.p + gain @ (posterior - covariance) @ gain.T
        self.p = (self.p + self.p.T) / 2

    def mount(self) -> tuple[FloatArray, FloatArray]:
        """Mean (3,) and covariance (3, 3) of pitch, yaw and roll of the mount."""
        return self.x[MOUNT].copy(), self.p[MOUNT, MOUNT].copy()

    def take_mount(self, mount: tuple[FloatArray, FloatArray]) -> None:
        """Set the mount, independent of the rest of the state."""
        self.p[MOUNT, :] = self.p[:, MOUNT] = 0.0
        self.x[MOUNT], self.p[MOUNT, MOUNT] = mount

    def take_angle(self, place: int, believed: Gaussian) -> None:
        """Set one angle of the mount, independent of the rest of the state."""
        self.p[place, :] = self.p[:, place] = 0.0
        self.x[place], self.p[place, place] = believed.value, believed.sigma**2

    def measure_angle(self, place: int, told: Gaussian) -> None:
        """Update with a measurement of one angle of the mount (Kalman 1960)."""
        gain = self.p[:, place] / (self.p[place, place] + told.sigma**2)
        self.x = self.x + gain * (told.value - self.x[place])
        self.p = self.p - np.outer(gain, self.p[place])

    def yaw_rate(self) -> tuple[float, float]:
        """Mean and variance of the yaw rate."""
        return float(self.x[YAW_RATE]), float(self.p[YAW_RATE, YAW_RATE])

    def take_yaw_rate(self, yaw_rate: tuple[float, float]) -> None:
        """Set the yaw rate, independent of the rest of the state."""
        self.p[YAW_RATE, :] = self.p[:, YAW_RATE] = 0.0
        self.x[YAW_RATE], self.p[YAW_RATE, YAW_RATE] = yaw_rate

    def forget_speed(self, speed_mps: float, sigma_mps: float) -> None:
        """Replace the speed by a hypothesis."""
        for state, value, sigma in (
            (SPEED, speed_mps, sigma_mps),
            (ACCELERATION, 0.0, self._settings.acceleration_sigma_mps2),
        ):
            self.p[state, :] = self.p[:, state] = 0.0
            self.x[state], self.p[state, state] = value, sigma**2
