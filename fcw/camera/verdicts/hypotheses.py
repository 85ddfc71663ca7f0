"""What may be true: the input as it was stated, or one of the mistakes that people make.

How often each mistake is made (`SHARES`) is a guess about people, not a count. The verdict itself is in
`fcw.camera.verdicts.judgement`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations, pairwise

import numpy as np

from fcw.camera.calibration import GroundPoint
from fcw.units import FEET_PER_METRE


class Fault(Enum):
    """What is wrong with the input."""

    NONE = "none"
    """Nothing but the noise of clicks and tape."""
    BUMPER = "bumper"
    """The distances start at the bumper, or not where they were stated to start."""
    SWAPPED = "swapped"
    """Two distances are exchanged."""
    SLIP_OF_TEN = "slip_of_ten"
    """A decimal point is missing or misplaced."""
    FEET = "feet"
    """The distances are in feet."""
    DASHES = "dashes"
    """Evenly spaced marks start elsewhere, or have another period."""
    POINT = "point"
    """One point is not where it was stated to be: a bump or dip of the road, or a wrong mark."""
    AXIS = "axis"
    """The optical axis is far from the middle: the picture is cropped."""


SHARES = {
    Fault.NONE: 0.67,
    Fault.BUMPER: 0.18,
    Fault.SWAPPED: 0.02,
    Fault.SLIP_OF_TEN: 0.03,
    Fault.FEET: 0.06,
    Fault.POINT: 0.03,
    Fault.AXIS: 0.01,
}
DASHES_SHARE = 0.05
"""The same if distances are evenly spaced; otherwise they are not dashes."""
BUMPER_M, BUMPER_SIGMA_M = 2.0, 0.35
"""Distance from a camera behind the windscreen forward to the bumper."""
OFFSET_SLIP_SIGMA_M = 0.7
"""Standard deviation of a measured offset if it is wrong."""
DASH_START_SIGMA_M = 5.0
DASH_PERIODS_M = {
    6.0: "towns",
    9.0: "Britain",
    12.0: "Netherlands",
    12.19: "USA",
    13.0: "France",
    14.63: "California",
    15.0: "China",
    17.0: "Spain",
    18.0: "Germany",
    20.0: "Japan",
    24.0: "",
}
"""From one broken line to the next, and a place where it is so: 2 + 4, 2 + 7, 3 + 9, 10 + 30 ft, 3 + 10,
12 + 36 ft, 6 + 9, 5 + 12, 6 + 12 and 8 + 12 m of line and gap, or every other dash of 12 m."""
EVEN_PART = 0.01
"""Gaps that differ by less than this part count as even."""
POINT_SIGMA_HEIGHTS = 0.06
"""How far a point on the wrong mark is off, in picture heights."""
AXIS_SIGMA_HEIGHTS = 0.25


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One thing that may be true.

    Attributes:
        fault: kind of mistake.
        share: prior probability, before any click.
        distances_m: the true distances from the reference under it.
        points: indices of the points that are wrong under it.
        offset_m: mean and standard deviation of the reference offset.
        axis_sigma_heights: standard deviation of the principal row, in picture heights; None for the stated
            or usual one.
        loose: index of a point whose row says little; None if there is none.
        period_m: period of the dashes, if it is another one.
    """

    fault: Fault
    share: float
    distances_m: tuple[float, ...]
    points: tuple[int, ...] = ()
    offset_m: tuple[float, float] = (0.0, 1e-6)
    axis_sigma_heights: float | None = None
    loose: int | None = None
    period_m: float | None = None


def hypotheses(points: Sequence[GroundPoint], offset_m: float, imperial: bool = False) -> list[Hypothesis]:
    """All hypotheses about points whose stated reference is so far ahead of the camera."""
    return list(_all(points, offset_m, imperial))


def _all(points: Sequence[GroundPoint], offset_m: float, imperial: bool) -> Iterator[Hypothesis]:
    said = tuple(point.distance_m for point in points)
    where = (offset_m, 1e-6)
    count = len(said)

    def changed(changes: dict[int, float]) -> tuple[float, ...]:
        return tuple(changes.get(k, distance_m) for k, distance_m in enumerate(said))

    yield Hypothesis(Fault.NONE, SHARES[Fault.NONE], said, offset_m=where)
    if offset_m:
        share = SHARES[Fault.BUMPER] / 2
        yield Hypothesis(Fault.BUMPER, share, said, offset_m=(offset_m, OFFSET_SLIP_SIGMA_M))
        yield Hypothesis(Fault.BUMPER, share, said, offset_m=(BUMPER_M, BUMPER_SIGMA_M))
    else:
        yield Hypothesis(Fault.BUMPER, SHARES[Fault.BUMPER], said, offset_m=(BUMPER_M, BUMPER_SIGMA_M))
    pairs = [(i, j) for i, j in combinations(range(count), 2) if said[i] != said[j]]
    for i, j in pairs:
        swapped = changed({i: said[j], j: said[i]})
        yield Hypothesis(Fault.SWAPPED, SHARES[Fault.SWAPPED] / len(pairs), swapped, (i, j), where)
    for k in range(count):
        for factor in (0.1, 10.0):
            slip = changed({k: said[k] * factor})
            yield Hypothesis(Fault.SLIP_OF_TEN, SHARES[Fault.SLIP_OF_TEN] / 2 / count, slip, (k,), where)
        if count > 2:
            share = SHARES[Fault.POINT] / count
            yield Hypothesis(Fault.POINT, share, said, (k,), where, loose=k)
    scale = FEET_PER_METRE if imperial else 1 / FEET_PER_METRE
    in_feet = tuple(distance_m * scale for distance_m in said)
    yield Hypothesis(Fault.FEET, SHARES[Fault.FEET], in_feet, offset_m=where)
    yield Hypothesis(
        Fault.AXIS, SHARES[Fault.AXIS], said, offset_m=where, axis_sigma_heights=AXIS_SIGMA_HEIGHTS
    )
    yield from _dashes(said, offset_m)


def _dashes(said: tuple[float, ...], offset_m: float) -> Iterator[Hypothesis]:
    """The hypotheses that evenly spaced marks are dashes whose first distance or period was guessed."""
    ordered = sorted(said)
    gaps = [far - near for near, far in pairwise(ordered)]
    if len(gaps) < 2 or min(gaps) <= 0 or max(gaps) > (1 + EVEN_PART) * min(gaps):
        return
    period_m = float(np.mean(gaps))
    start = (offset_m, DASH_START_SIGMA_M)
    yield Hypothesis(Fault.DASHES, DASHES_SHARE, said, offset_m=start)
    others = [other for other in DASH_PERIODS_M if abs(other / period_m - 1) > 0.02]
    for other in others:
        distances_m = tuple(ordered[0] + (d - ordered[0]) * other / period_m for d in said)
        share = DASHES_SHARE / len(others)
        yield Hypothesis(Fault.DASHES, share, distances_m, offset_m=start, period_m=other)
