"""The own path on simulated bends, from rendered pictures: how far aside of the lane it is 30 m ahead.

Bends of roads grow to their smallest radius and fall back, so that the path ahead bends otherwise than where
we are. Each is driven once with what lane lines say, as always, and once by own motion alone: there may be
none.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from fcw.motion.ego import EgoEstimator
from fcw.motion.path import PathAhead
from fcw.simulation.drive import true_calibration
from fcw.simulation.picture.renderer import Renderer
from fcw.simulation.world.scenario import IMAGE_SIZE, BendPlan, EgoPlan, RoadPlan, Scenario
from fcw.simulation.world.state import WorldState
from fcw.simulation.world.world import World
from fcw.threads import one_opencv_thread

RADII_M = (150.0, -300.0, 500.0, -800.0)
LATERAL_MPS2 = 1.2
"""At the smallest radius: how fast people drive through bends; no faster than on a main road."""
FASTEST_MPS = 25.0
AHEAD_M = 30.0
BEFORE_M = 60.0
"""The straight before the bend: own motion is known by its end."""
TURNED_PART = 0.6
"""Length of a bend as a part of its smallest radius."""
EVERY = 3
"""One picture in so many is made: ten a second, as in the drives that own motion was measured on."""
BEGINS_S = 2.0
"""From here on it counts."""


@dataclass(frozen=True, slots=True)
class BendResult:
    """One bend.

    Attributes:
        radius_m: the smallest, positive to the left.
        speed_mps: own speed.
        median_m: median error with lane lines.
        p90_m: nine of ten errors are smaller.
        without_lines_median_m: median error by own motion alone.
        without_lines_p90_m: nine of ten errors are smaller.
    """

    radius_m: float
    speed_mps: float
    median_m: float
    p90_m: float
    without_lines_median_m: float
    without_lines_p90_m: float


def bend_scenario(radius_m: float) -> Scenario:
    """A straight, a bend, and a straight again."""
    speed_mps = min((LATERAL_MPS2 * abs(radius_m)) ** 0.5, FASTEST_MPS)
    length_m = TURNED_PART * abs(radius_m)
    return Scenario(
        description="A bend, and nobody else.",
        duration_s=round((BEFORE_M + length_m) / speed_mps + 1.0, 1),
        ego=EgoPlan(speed_kmh=speed_mps * 3.6),
        road=RoadPlan(bends=(BendPlan(start_m=BEFORE_M, length_m=length_m, radius_m=radius_m),)),
    )


def picture_count(radius_m: float) -> int:
    """How many pictures a bend takes."""
    return len(range(0, bend_scenario(radius_m).frame_count, EVERY))


def evaluate_bends(
    radii_m: Sequence[float] = RADII_M,
    seed: int = 0,
    on_frame: Callable[[], None] = lambda: None,
) -> tuple[BendResult, ...]:
    """Drive through a bend of each radius."""
    with one_opencv_thread():
        return tuple(_one(radius_m, seed, on_frame) for radius_m in radii_m)


def _one(radius_m: float, seed: int, on_frame: Callable[[], None]) -> BendResult:
    scenario = bend_scenario(radius_m)
    ego, alone = EgoEstimator(true_calibration(scenario)), PathAhead()
    errors_m: list[tuple[float, float]] = []
    renderer = Renderer(scenario.camera.camera(), IMAGE_SIZE, seed)
    for state in islice(World(scenario, seed).states(), 0, None, EVERY):
        believed = ego.update(state.time_ns, renderer.render(state))
        by_motion = alone.update(state.time_ns, believed.motion, None)
        x_m, y_m = _way_ahead(state)
        if state.time_ns / 1e9 >= BEGINS_S:
            errors_m.append((believed.path.lateral_at(x_m) - y_m, by_motion.lateral_at(x_m) - y_m))
        on_frame()
    errors = np.abs(errors_m)
    (median_m, without_m), (p90_m, without_p90_m) = np.quantile(errors, (0.5, 0.9), axis=0).tolist()
    speed_mps = scenario.ego.speed_kmh / 3.6
    return BendResult(radius_m, speed_mps, median_m, p90_m, without_m, without_p90_m)


def _way_ahead(state: WorldState) -> tuple[float, float]:
    """Where we will be `AHEAD_M` on, if we keep our place in the lane, in the camera's axes."""
    ego = state.ego
    x_m, y_m, _ = state.road_points(ego.s_m + AHEAD_M, ego.lateral_m).tolist()
    return x_m, y_m
