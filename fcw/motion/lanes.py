"""Lane lines in the strip of road ahead, seen from above.

The small picture is sampled on a grid of the road. Across each row of the grid, a painted line is a ridge
that is brighter than the road on both sides. The ridges vote for two lines with a common heading and
curvature, close to those expected from mount and yaw rate. A least-squares fit through the voters gives the
lane with its covariance (after Aly 2008, "Real time detection of lane markers in urban streets", with a known
road plane and parallel lines). The curvature may change along the lane, as where a straight road becomes a
bend (a clothoid; Dickmanns and Mysliwetz 1992, "Recursive 3-D road and relative ego-state recognition").
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray
from fcw.kernels.jit import kernel
from fcw.kernels.linear import eliminate
from fcw.motion.bend.turning import growth_sigma_per_m2
from fcw.motion.view import RoadView

DISTANCES_M = np.geomspace(6.0, 40.0, 24)
"""Rows of the grid, closer together near us, where a row of the picture covers less of the road."""
HALF_WIDTH_M, STEP_M = 6.0, 0.05
LATERALS_M = np.arange(-HALF_WIDTH_M, HALF_WIDTH_M + STEP_M / 2, STEP_M)
SIDE_STEPS = 5
"""A line must be brighter than the road this many steps (a quarter of a metre) beside it. Lines are 0.1 to
0.2 m wide."""
FAINTEST = 6.0
"""Least number of grey values by which a line is brighter than the road on both sides."""
ROUGHNESS = 3.0
"""It must also be brighter by this many times the usual variation of the road over the same distance, as
gravel is no line."""
STRONGEST = 30.0
"""Brighter ridges do not count for more: a lamp's reflection is no better line."""
HEADINGS_RAD = np.radians(np.linspace(-2.5, 2.5, 17))
BENDS_PER_M = np.linspace(-2.4e-3, 2.4e-3, 9)
"""Headings and curvatures that are tried, relative to the expected ones."""
LANE_M, LANE_SIGMA_M = 3.5, 0.4
"""Usual width of a lane, and its 1-sigma."""
NARROWEST_M, WIDEST_M = 2.5, 4.6
NEAR_LINE_M = 0.25
"""A ridge this near to a line belongs to it; farther ahead, twice as much."""
FEWEST_ROWS = 5
"""Least number of rows of the grid in which each line must be seen, as kerbs and shadows look like lines."""
LEAST_REACH_M = 6.0
"""Least length of each line."""
FARTHEST_ASIDE_M = 1.0
"""Largest distance of the camera from the middle of the lane. During a lane change there is no own lane."""
SAME_LANE_M = 0.4
CONFIRMATIONS = 3
"""A lane is used once it was found this often in a row, within `SAME_LANE_M`."""
RIDGE_SIGMA_M = 0.1
"""1-sigma of a ridge's lateral position near the camera."""
HEADING_SIGMA_RAD, BEND_SIGMA_PER_M = math.radians(1.5), 2e-3
"""1-sigmas of the lane's heading and curvature about those of mount and yaw rate: lane changes, and bends
that begin."""
SMOOTHING_S = 0.4
LOST_S = 1.5
"""Time after which a lane that is not seen is forgotten."""
WALK = np.array([0.4, math.radians(1.0), 1e-3, 1e-4, 0.1])
"""Random walk of offset, heading, curvature, its change, and width of the lane: 1-sigma after one second."""


@dataclass(frozen=True, slots=True, eq=False)
class Lane:
    """The own lane.

    Attributes:
        mean: (5,) lateral offset of its middle at the camera, m, heading, rad, curvature, 1/m, change of the
            curvature along it, 1/m^2, all from the camera's axis and positive to the left; and its width, m.
        covariance: (5, 5) covariance of `mean`.
    """

    mean: FloatArray
    covariance: FloatArray


@kernel()
def _ridges(
    grey: NDArray[np.uint8],
    columns: NDArray[np.float32],
    rows: NDArray[np.float32],
    found: NDArray[np.float32],
) -> int:  # pragma: no cover - compiled
    """Find ridges of the sampled road: row of the grid, index across it, strength; returns their number."""
    height, width = grey.shape
    across = columns.shape[1]
    values, ridge = np.empty(across, np.float32), np.empty(across, np.float32)
    count = 0
    for i in range(columns.shape[0]):
        for j in range(across):
            x, y = columns[i, j], rows[i, j]
            if x < 0 or y < 0 or x >= width - 1 or y >= height - 1:
                values[j] = -1000.0  # outside the picture: no ridge here or next to it
                continue
            x0, y0 = int(x), int(y)
            a, b = x - x0, y - y0
            upper = (1 - a) * grey[y0, x0] + a * grey[y0, x0 + 1]
            lower = (1 - a) * grey[y0 + 1, x0] + a * grey[y0 + 1, x0 + 1]
            values[j] = (1 - b) * upper + b * lower
        ridge[:] = 0.0
        rough, used = 0.0, 1
        for j in range(SIDE_STEPS, across - SIDE_STEPS):
            left, right = values[j - SIDE_STEPS], values[j + SIDE_STEPS]
            if left >= 0 and right >= 0 and values[j] >= 0:
                ridge[j] = values[j] - max(left, right)
                rough += abs(values[j] - (left + right) / 2)
                used += 1
        faintest = max(FAINTEST, ROUGHNESS * rough / used)
        for j in range(SIDE_STEPS, across - SIDE_STEPS):
            if ridge[j] > faintest and ridge[j] >= ridge[j - 1] and ridge[j] > ridge[j + 1]:
                best = True
                for k in range(j - 3, j + 4):
                    if ridge[k] > ridge[j]:
                        best = False
                if best and count < found.shape[0]:
                    found[count, 0], found[count, 1], found[count, 2] = i, j, min(ridge[j], STRONGEST)
                    count += 1
    return count


@kernel()
def _vote(
    distances: FloatArray,
    laterals: FloatArray,
    strengths: FloatArray,
    headings: FloatArray,
    bends: FloatArray,
    lane_m: float,
) -> tuple[float, int, int, float, float]:  # pragma: no cover - compiled
    """Score, index of heading and of curvature, and lateral positions of left and right line at the camera.

    Indices are -1 and positions nan if there is no lane.
    """
    bins = 68
    best, best_heading, best_bend, best_left, best_right = 0.0, -1, -1, np.nan, np.nan
    left, right = np.zeros(bins), np.zeros(bins)
    for h in range(len(headings)):
        for b in range(len(bends)):
            left[:] = 0.0
            right[:] = 0.0
            for i in range(len(distances)):
                d = distances[i]
                y = laterals[i] - headings[h] * d - bends[b] * d * d / 2
                place = int(abs(y) / 0.05)
                if 1 <= place < bins - 1:
                    side = left if y > 0 else right
                    side[place] += strengths[i]
                    side[place - 1] += strengths[i] / 2
                    side[place + 1] += strengths[i] / 2
            highest_left, highest_right = 0.0, 0.0
            for u in range(10, bins):
                highest_left, highest_right = max(highest_left, left[u]), max(highest_right, right[u])
            if highest_left + highest_right <= best:
                continue
            for u in range(10, bins):
                if left[u] + highest_right <= best:
                    continue
                for v in range(10, bins):
                    lane = (u + v + 1) * 0.05
                    if NARROWEST_M <= lane <= WIDEST_M:
                        apart = (lane - lane_m) / LANE_SIGMA_M
                        score = (left[u] + right[v]) * (1 / (1 + 0.1 * apart * apart))
                        if score > best:
                            best, best_heading, best_bend = score, h, b
                            best_left, best_right = (u + 0.5) * 0.05, -(v + 0.5) * 0.05
    return best, best_heading, best_bend, best_left, best_right


def find_lane(
    grey: NDArray[np.uint8],
    view: RoadView,
    heading_rad: float,
    bend_per_m: float,
    speed_mps: float | None = None,
    lane_m: float = LANE_M,
) -> Lane | None:
    """The own lane in one small picture; None if it shows none.

    Args:
        grey: (height, width).
        view: where the road is in it.
        heading_rad: expected heading of the path, positive to the left.
        bend_per_m: expected curvature of the path, positive to the left.
        speed_mps: own speed, which limits how fast a road's curvature changes; None when unknown.
        lane_m: expected width of the lane.
    """
    columns, rows = view.places(LATERALS_M[None, :], DISTANCES_M[:, None])
    found = np.empty((200, 3), np.float32)
    count = _ridges(grey, columns, rows, found)
    if count < 2 * FEWEST_ROWS:
        return None
    ridges = found[:count].astype(np.float64)
    distances_m = DISTANCES_M[ridges[:, 0].astype(int)]
    laterals_m = LATERALS_M[ridges[:, 1].astype(int)]
    _, heading, bend, left_m, right_m = _vote(
        distances_m,
        laterals_m,
        ridges[:, 2],
        heading_rad + HEADINGS_RAD,
        bend_per_m + BENDS_PER_M,
        lane_m,
    )
    if heading < 0:
        return None
    start = left_m, right_m, heading_rad + HEADINGS_RAD[heading], bend_per_m + BENDS_PER_M[bend], 0.0
    expected = heading_rad, bend_per_m, lane_m
    return _fitted(distances_m, laterals_m, np.array(start), expected, growth_sigma_per_m2(speed_mps))


@kernel()
def _fit(
    distances_m: FloatArray,
    laterals_m: FloatArray,
    expected: tuple[float, float, float],
    growth_sigma: float,
    x: FloatArray,
    information: FloatArray,
    sides: NDArray[np.int8],
) -> bool:  # pragma: no cover - compiled
    """Least squares through the ridges; returns False if there are too few.

    `x` holds the start and becomes the result, `information` its information matrix. `sides` becomes 1 for
    ridges of the left line, -1 for those of the right one, and 0 for others.
    """
    heading_rad, bend_per_m, lane_m = expected
    matrix, gradient, row = np.empty((5, 5)), np.empty(5), np.empty(5)
    for _ in range(3):
        information[:, :] = 0.0
        gradient[:] = 0.0
        count = 0
        for i in range(len(distances_m)):
            d = distances_m[i]
            row[2], row[3], row[4] = d, d * d / 2, d * d * d / 6
            bent_m = x[2] * row[2] + x[3] * row[3] + x[4] * row[4]
            off_left, off_right = laterals_m[i] - x[0] - bent_m, laterals_m[i] - x[1] - bent_m
            is_left = abs(off_left) < abs(off_right)
            off_m = off_left if is_left else off_right
            sides[i] = 0
            if abs(off_m) >= NEAR_LINE_M * (1 + d / 40):
                continue
            count += 1
            sides[i] = 1 if is_left else -1
            row[0], row[1] = (1.0, 0.0) if is_left else (0.0, 1.0)
            sigma_m = RIDGE_SIGMA_M * (1 + d / 20)
            weight = 1 / (sigma_m * sigma_m)
            for m in range(5):
                gradient[m] += weight * row[m] * off_m
                for n in range(5):
                    information[m, n] += weight * row[m] * row[n]
        if count < 4:
            return False
        of_width, of_heading = 1 / LANE_SIGMA_M**2, 1 / HEADING_SIGMA_RAD**2
        of_bend, of_growth = 1 / BEND_SIGMA_PER_M**2, 1 / growth_sigma**2
        wider = of_width * (lane_m - (x[0] - x[1]))
        gradient[0] += wider
        gradient[1] -= wider
        gradient[2] += of_heading * (heading_rad - x[2])
        gradient[3] += of_bend * (bend_per_m - x[3])
        gradient[4] -= of_growth * x[4]
        information[0, 0] += of_width
        information[1, 1] += of_width
        information[0, 1] -= of_width
        information[1, 0] -= of_width
        information[2, 2] += of_heading
        information[3, 3] += of_bend
        information[4, 4] += of_growth
        matrix[:, :] = information
        eliminate(matrix, gradient)
        for m in range(5):
            x[m] += gradient[m]
    return True


def _fitted(
    distances_m: FloatArray,
    laterals_m: FloatArray,
    start: FloatArray,
    expected: tuple[float, float, float],
    growth_sigma: float,
) -> Lane | None:
    """The lane by least squares from a start: left, right, heading, curvature and its change; None if bad."""
    x, information, sides = start.copy(), np.empty((5, 5)), np.empty(len(distances_m), np.int8)
    if not _fit(distances_m, laterals_m, expected, growth_sigma, x, information, sides):
        return None
    for line in (sides == 1, sides == -1):
        if len(np.unique(distances_m[line])) < FEWEST_ROWS or np.ptp(distances_m[line]) < LEAST_REACH_M:
            return None
    left_m, right_m = float(x[0]), float(-x[1])
    if not (NARROWEST_M <= left_m + right_m <= WIDEST_M and abs(left_m - right_m) / 2 <= FARTHEST_ASIDE_M):
        return None
    # The errors of ridges in neighbouring rows are correlated.
    covariance = np.linalg.inv(information) * 4
    to_lane = np.array(
        [[0.5, 0.5, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1], [1, -1, 0, 0, 0]]
    )
    return Lane(to_lane @ x, np.asarray(to_lane @ covariance @ to_lane.T, np.float64))


class LaneTracker:
    """The own lane over time."""

    def __init__(self) -> None:
        self._lane: Lane | None = None
        self._unseen_s = 0.0
        self._candidate: Lane | None = None
        self._confirmed = 0

    @property
    def lane(self) -> Lane | None:
        """The present estimate; None if no lane was seen for a while."""
        return self._lane

    def update(
        self,
        grey: NDArray[np.uint8],
        view: RoadView,
        heading_rad: float,
        bend_per_m: float,
        speed_mps: float | None,
        dt_s: float,
    ) -> Lane | None:
        """Update with a picture; returns `lane`.

        Args:
            grey: the small picture.
            view: where the road is in it.
            heading_rad: heading of the path by the mount, positive to the left.
            bend_per_m: curvature of the path by the yaw rate, positive to the left.
            speed_mps: own speed; None when unknown.
            dt_s: time since the previous picture.
        """
        before = self._lane
        if before is not None and speed_mps is not None:
            before = _moved_on(before, speed_mps * dt_s)
        lane_m = LANE_M if before is None else float(before.mean[4])
        seen = find_lane(grey, view, heading_rad, bend_per_m, speed_mps, lane_m)
        self._unseen_s += dt_s
        if before is not None and seen is not None and _alike(before, seen):
            self._unseen_s = 0.0
            predicted = before.covariance + np.diag(WALK**2 * dt_s)
            noise = seen.covariance * max(1.0, SMOOTHING_S / max(dt_s, 1e-3))
            gain = predicted @ np.linalg.inv(predicted + noise)
            mean = before.mean + gain @ (seen.mean - before.mean)
            self._lane = Lane(mean, np.asarray(predicted - gain @ predicted, np.float64))
        elif before is not None:
            self._lane = Lane(before.mean, before.covariance + np.diag(WALK**2 * dt_s))
        if self._unseen_s > LOST_S:
            self._lane = None
        self._confirm(seen)
        return self._lane

    def _confirm(self, seen: Lane | None) -> None:
        """Count how often in a row a lane was found, and let it finally replace the present one."""
        if seen is None:
            self._candidate, self._confirmed = None, 0
            return
        again = self._candidate is not None and _alike(self._candidate, seen)
        self._candidate, self._confirmed = seen, self._confirmed + 1 if again else 1
        if self._confirmed >= CONFIRMATIONS and (self._lane is None or not _alike(self._lane, seen)):
            self._lane, self._unseen_s = seen, 0.0


def _moved_on(lane: Lane, moved_m: float) -> Lane:
    """The lane as seen from farther along it, where its curvature has changed."""
    mean = lane.mean.copy()
    mean[2] += mean[3] * moved_m
    return Lane(mean, lane.covariance)


def _alike(one: Lane, other: Lane) -> bool:
    return abs(float(one.mean[0] - other.mean[0])) < SAME_LANE_M
