"""Rear-end scenarios of NHTSA and Euro NCAP, exact in closed form, and the driver who is warned in them.

The own car keeps its speed. The lead keeps its speed too, or brakes from some time on until it stands.

Sources: NHTSA, "Forward Collision Warning System Confirmation Test" (February 2013): three tests at 45 mph,
a standing lead with a TTC of 2.1 s; the figures of the other two, and that 5 of 7 trials must pass, are as
commonly quoted and not verified against its text. Euro NCAP, "Test Protocol - AEB Car-to-Car systems" 4.3.1
(February 2024), sections 8.2.2 and 8.4.6: CCRs (standing) up to 80 km/h, CCRm (30 to 80 km/h; that the other
moves at 20 km/h is not verified), CCRb (both at 50 km/h, 12 or 40 m apart, -2 or -6 m/s^2), and a driver who
brakes at 4 m/s^2 1.2 s after the warning. There the lead's deceleration may take a second to build up; here
it is there at once, which is harder.
"""

import math
from dataclasses import dataclass

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.units import KMH_PER_MPS, MPH_PER_MPS, STANDARD_GRAVITY_MPS2
from fcw.warning.driver import EXPECTED_DRIVER, Driver

TRIALS = 7
NHTSA_PASSES = 5
"""Of seven trials, by NHTSA."""
START_M = 150.0
"""Gap at the start of an approach: NHTSA's standing lead is approached from 150 m."""
SETTLE_S = 3.0
"""How long a lead is followed before it brakes."""
OVERLAP_WIDTH_M = 1.8
"""Euro NCAP states overlap as a part of the width of the car under test."""
OVERLAPS = (-0.5, -0.75, 0.75, 0.5)
OVERLAP_SPEEDS_KMH = (30, 50, 70)
_STEP_S = 0.001


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """One test.

    Attributes:
        name: as in the results.
        own_mps: own speed.
        lead_mps: speed of the lead before it brakes.
        gap_m: from bumper to bumper at time 0.
        braking_mps2: deceleration of the lead, from `SETTLE_S` on; 0 where it keeps its speed.
        required_ttc_s: the warning must come at this TTC; None where it must come in time for
            `EXPECTED_DRIVER` to avoid the crash.
        preventable: whether it is asked to be prevented at all.
        overlap: part of our width that the lead is in the way of; below 0 it stands to our right.
    """

    name: str
    own_mps: float
    lead_mps: float
    gap_m: float
    braking_mps2: float = 0.0
    required_ttc_s: float | None = None
    preventable: bool = True
    overlap: float = 1.0

    @property
    def offset_m(self) -> float:
        """Of the lead's middle from our path's, positive to the left: both cars are as wide."""
        return math.copysign((1 - abs(self.overlap)) * OVERLAP_WIDTH_M, self.overlap)

    def lead_at(self, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Way and speed of the lead since time 0."""
        if self.braking_mps2 == 0:
            return self.lead_mps * time_s, np.full_like(time_s, self.lead_mps)
        braking_s = np.clip(time_s - SETTLE_S, 0.0, self.lead_mps / self.braking_mps2)
        way_m = self.lead_mps * (np.minimum(time_s, SETTLE_S) + braking_s)
        return way_m - self.braking_mps2 * braking_s**2 / 2, self.lead_mps - self.braking_mps2 * braking_s

    def gap_at(self, time_s: FloatArray) -> FloatArray:
        """Gap while the own car keeps its speed; negative after the crash."""
        return self.gap_m + self.lead_at(time_s)[0] - self.own_mps * time_s

    def closing_at(self, time_s: FloatArray) -> FloatArray:
        """Closing speed while the own car keeps its speed."""
        return self.own_mps - self.lead_at(time_s)[1]

    @property
    def danger_s(self) -> float:
        """When the danger begins: a braking lead is none before."""
        return SETTLE_S if self.braking_mps2 else 0.0

    @property
    def crash_s(self) -> float:
        """When the own car hits the lead if nobody brakes."""
        times_s = np.arange(0.0, 120.0, _STEP_S)
        return float(times_s[np.argmax(self.gap_at(times_s) <= 0)])

    def impact_mps(self, warned_s: float | None, driver: Driver = EXPECTED_DRIVER) -> float:
        """Speed of impact, 0 where it is avoided, with a driver who brakes after the warning, or never."""
        braking_from_s = math.inf if warned_s is None else warned_s + driver.reaction_s
        stopping_s = self.own_mps / driver.braking_mps2
        latest_s = self.crash_s if warned_s is None else braking_from_s + stopping_s
        times_s = np.arange(0.0, latest_s + _STEP_S, _STEP_S)
        braking_s = np.clip(times_s - braking_from_s, 0.0, stopping_s)
        way_own_m = self.own_mps * (np.minimum(times_s, braking_from_s) + braking_s)
        way_own_m -= driver.braking_mps2 * braking_s**2 / 2
        way_m, lead_mps = self.lead_at(times_s)
        hits = self.gap_m + way_m - way_own_m <= 0
        if not hits.any():
            return 0.0
        first = int(np.argmax(hits))
        return max(float(self.own_mps - driver.braking_mps2 * braking_s[first] - lead_mps[first]), 0.0)

    def latest_warning_s(self, driver: Driver = EXPECTED_DRIVER) -> float | None:
        """The last moment at which a warning lets the driver avoid the crash.

        None where there is none after the lead began to brake.
        """
        low_s, high_s = self.danger_s, self.crash_s
        if self.impact_mps(low_s, driver) > 0:
            return None
        while high_s - low_s > _STEP_S:
            middle_s = (low_s + high_s) / 2
            if self.impact_mps(middle_s, driver) > 0:
                high_s = middle_s
            else:
                low_s = middle_s
        return low_s

    @property
    def required_gap_m(self) -> float | None:
        """True gap at the last moment at which a warning is in time; None where there is none."""
        latest_s = self.latest_warning_s()
        return None if latest_s is None else float(self.gap_at(np.array([latest_s]))[0])


def _mph(speed_mph: float) -> float:
    return speed_mph / MPH_PER_MPS


def _kmh(speed_kmh: float) -> float:
    return speed_kmh / KMH_PER_MPS


def nhtsa_scenarios() -> tuple[Scenario, ...]:
    """The three tests of NHTSA's confirmation test of forward collision warning."""
    own_mps = _mph(45)
    return (
        Scenario(name="NHTSA stopped lead", own_mps=own_mps, lead_mps=0.0, gap_m=START_M, required_ttc_s=2.1),
        Scenario(
            name="NHTSA braking lead",
            own_mps=own_mps,
            lead_mps=own_mps,
            gap_m=30.0,
            braking_mps2=0.3 * STANDARD_GRAVITY_MPS2,
            required_ttc_s=2.4,
        ),
        Scenario(
            name="NHTSA slower lead", own_mps=own_mps, lead_mps=_mph(20), gap_m=START_M, required_ttc_s=2.0
        ),
    )


def euro_ncap_scenarios() -> tuple[Scenario, ...]:
    """CCRs and CCRm at 30 to 80 km/h, CCRb at 50 km/h; CCRs with 50 and 75 % overlap to either side."""
    speeds_kmh = range(30, 90, 10)
    standing = (
        Scenario(
            name=f"CCRs {speed} km/h",
            own_mps=_kmh(speed),
            lead_mps=0.0,
            gap_m=START_M,
            preventable=speed < 80,
        )
        for speed in speeds_kmh
    )
    moving = (
        Scenario(name=f"CCRm {speed} km/h", own_mps=_kmh(speed), lead_mps=_kmh(20), gap_m=START_M)
        for speed in speeds_kmh
    )
    braking = (
        Scenario(
            name=f"CCRb {gap} m -{braking} m/s2",
            own_mps=_kmh(50),
            lead_mps=_kmh(50),
            gap_m=float(gap),
            braking_mps2=float(braking),
            preventable=(gap, braking) != (12, 6),
        )
        for gap in (12, 40)
        for braking in (2, 6)
    )
    partly = (
        Scenario(
            name=f"CCRs {speed} km/h {abs(overlap):.0%} {'left' if overlap > 0 else 'right'}",
            own_mps=_kmh(speed),
            lead_mps=0.0,
            gap_m=START_M,
            overlap=overlap,
        )
        for speed in OVERLAP_SPEEDS_KMH
        for overlap in OVERLAPS
    )
    return (*standing, *moving, *braking, *partly)
