"""How vehicles move along and across the road, and how the body shakes the camera.

Along the road: constant speed, a given acceleration up to a speed, or following by the Intelligent Driver
Model (Treiber, Hennecke, Helbing 2000, "Congested traffic states in empirical observations and microscopic
simulations"). Across: the minimum-jerk path of a lane change. The camera: body pitch as a second-order
response to braking, and the road's roughness as band-limited noise.
"""

import math
from dataclasses import dataclass

import numpy as np

from fcw.camera.ground_plane import FloatArray

MAXIMUM_ACCELERATION_MPS2 = 1.5
COMFORTABLE_BRAKING_MPS2 = 2.0
"""a and b of the Intelligent Driver Model, for ordinary driving."""
STANDING_GAP_M = 2.5
HARDEST_BRAKING_MPS2 = 8.0
"""What tyres give on a dry road."""
NOTICEABLE_BRAKING_MPS2 = -0.5
"""Down to this the engine brakes: no pedal is moved."""
PEDAL_LAG_S = 0.15
"""Time constant with which the deceleration follows the pedal."""
DIVE_RAD_PER_MPS2 = 0.0012
"""Nose dive of an ordinary car: 0.7 degrees at 1 g."""
BODY_FREQUENCY_HZ, BODY_DAMPING = 1.3, 0.35
"""Pitch resonance of a passenger car's body on its springs."""
SHAKE_PITCH_RMS_RAD = 0.0010
SHAKE_BOUNCE_RMS_M = 0.006
"""On a good main road at `SHAKE_SPEED_MPS` and above; slower is smoother."""
SHAKE_SPEED_MPS = 15.0
SHAKE_BAND_HZ = (0.6, 3.5)
SHAKE_WAVES = 24


def following_acceleration_mps2(
    speed_mps: float,
    desired_mps: float,
    headway_s: float,
    gap_m: float = math.inf,
    closing_mps: float = 0.0,
) -> float:
    """Intelligent Driver Model (Treiber et al. 2000, eqs. 3 and 4).

    Args:
        speed_mps: own speed.
        desired_mps: speed on a free road.
        headway_s: time gap kept to the vehicle ahead.
        gap_m: bumper to bumper; inf on a free road.
        closing_mps: rate at which the gap shrinks.
    """
    root = 2 * math.sqrt(MAXIMUM_ACCELERATION_MPS2 * COMFORTABLE_BRAKING_MPS2)
    wanted_m = STANDING_GAP_M + max(speed_mps * headway_s + speed_mps * closing_mps / root, 0.0)
    free = (speed_mps / desired_mps) ** 4 if desired_mps > 0 else math.inf
    acceleration = MAXIMUM_ACCELERATION_MPS2 * (1 - free - (wanted_m / max(gap_m, 0.1)) ** 2)
    return max(acceleration, -HARDEST_BRAKING_MPS2)


def seeking_acceleration_mps2(speed_mps: float, target_mps: float, rate_mps2: float) -> float:
    """A constant acceleration towards a speed, gentle over the last bit so that it is not overshot."""
    return min(max((target_mps - speed_mps) / (2 * PEDAL_LAG_S), -rate_mps2), rate_mps2)


@dataclass(slots=True)
class Reaction:
    """A driver whose foot goes to the brake late.

    Attributes:
        reaction_s: from the moment when braking is needed to doing it.
        needed_s: for how long it has been needed.
    """

    reaction_s: float = 0.0
    needed_s: float = 0.0

    def filtered(self, wanted_mps2: float, step_s: float) -> float:
        """What the driver does of what is needed: until the reaction time is over, roll on."""
        if wanted_mps2 > NOTICEABLE_BRAKING_MPS2:
            self.needed_s = 0.0
            return wanted_mps2
        self.needed_s += step_s
        return wanted_mps2 if self.needed_s >= self.reaction_s else max(wanted_mps2, 0.0)


@dataclass(frozen=True, slots=True)
class LaneChange:
    """A minimum-jerk move from one lateral position to another (10 t^3 - 15 t^4 + 6 t^5)."""

    start_s: float
    over_s: float
    from_m: float
    to_m: float

    def at(self, time_s: float) -> tuple[float, float]:
        """Lateral position and speed."""
        t = min(max((time_s - self.start_s) / self.over_s, 0.0), 1.0)
        way_m = self.to_m - self.from_m
        position = self.from_m + way_m * t**3 * (10 - 15 * t + 6 * t**2)
        return position, way_m * 30 * t**2 * (1 - t) ** 2 / self.over_s


@dataclass(frozen=True, slots=True)
class Sway:
    """Nobody drives down the very middle of a lane: a slow wave along the road."""

    amplitude_m: float
    wavelength_m: float
    phase_rad: float

    def at(self, s_m: float) -> tuple[float, float]:
        """Lateral deviation and its slope along the road."""
        wave_per_m = 2 * math.pi / self.wavelength_m
        angle = wave_per_m * s_m + self.phase_rad
        return self.amplitude_m * math.sin(angle), self.amplitude_m * wave_per_m * math.cos(angle)


@dataclass(slots=True)
class NoseDive:
    """Body pitch behind the own acceleration: a damped spring; 0 at constant speed."""

    pitch_rad: float = 0.0
    rate_radps: float = 0.0

    def step(self, acceleration_mps2: float, step_s: float) -> None:
        """Move on; semi-implicit, so that the spring gains no energy."""
        omega = 2 * math.pi * BODY_FREQUENCY_HZ
        target_rad = -DIVE_RAD_PER_MPS2 * acceleration_mps2
        force = omega**2 * (target_rad - self.pitch_rad) - 2 * BODY_DAMPING * omega * self.rate_radps
        self.rate_radps += force * step_s
        self.pitch_rad += self.rate_radps * step_s


class RoadShake:
    """Pitch and bounce from the road's roughness: sums of waves with frequencies in the body's band."""

    def __init__(self, roughness: float, generator: np.random.Generator) -> None:
        self._omega: FloatArray = 2 * np.pi * generator.uniform(*SHAKE_BAND_HZ, (2, SHAKE_WAVES))
        self._phase: FloatArray = generator.uniform(0, 2 * np.pi, (2, SHAKE_WAVES))
        rms = np.array((SHAKE_PITCH_RMS_RAD, SHAKE_BOUNCE_RMS_M))
        # Each wave of amplitude A has the mean square A^2 / 2.
        self._amplitude: FloatArray = roughness * rms * math.sqrt(2 / SHAKE_WAVES)

    def at(self, time_s: float, speed_mps: float) -> tuple[float, float]:
        """Pitch and bounce; none while standing."""
        waves = np.sin(self._omega * time_s + self._phase).sum(axis=1)
        pitch, bounce = self._amplitude * waves * min(speed_mps / SHAKE_SPEED_MPS, 1.0)
        return float(pitch), float(bounce)
