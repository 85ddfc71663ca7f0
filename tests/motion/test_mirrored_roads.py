"""Lane lines and own motion do not tell left from right: the mirror image has the mirrored answer."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from road_pictures import Pose, Road, camera
from searching import examples
from test_solver import PRIOR_SIGMAS, TRUE, points, solved

from fcw.motion.lanes import find_lane
from fcw.motion.solver import UNKNOWNS
from fcw.motion.view import RoadView

VIEW = RoadView.of(camera(), 1)
MIRROR = np.array([1.0, -1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0])
"""Of the solver's unknowns: what turns or tilts to one side, to the other."""


@given(st.floats(-0.8, 0.8), st.floats(2.8, 4.2), st.floats(-2e-3, 2e-3))
@examples(15)
def test_the_lane_of_the_mirrored_road_is_mirrored(offset_m, lane_m, bend_per_m):
    road = Road(lines_m=(offset_m + lane_m / 2, offset_m - lane_m / 2))
    grey = np.ascontiguousarray(road.picture(Pose(), lane_of=lambda x: bend_per_m * x**2 / 2)[:, :, 1])
    mirrored_px = grey.shape[1] - 1 - VIEW.column_px
    there = RoadView(VIEW.focal_px, mirrored_px, VIEW.row_px, VIEW.pitch_rad, VIEW.height_m)
    lane = find_lane(grey, VIEW, 0.0, bend_per_m)
    other = find_lane(np.ascontiguousarray(grey[:, ::-1]), there, 0.0, -bend_per_m)
    assert (lane is None) == (other is None)
    if lane is not None and other is not None:
        # Places of ridges are as fine as the grid of the road, 5 cm.
        assert other.mean[0] == pytest.approx(-lane.mean[0], abs=0.03)
        assert other.mean[1] == pytest.approx(-lane.mean[1], abs=2e-3)
        assert other.mean[4] == pytest.approx(lane.mean[4], abs=0.03)


@pytest.mark.parametrize("seed", range(5))
def test_the_motion_of_mirrored_points_is_mirrored(seed):
    rng = np.random.default_rng(seed)
    before, after, road = points(rng, TRUE)
    after[:10] += rng.uniform(-0.1, 0.1, (10, 2))  # astray
    mean = TRUE + PRIOR_SIGMAS * rng.standard_normal(UNKNOWNS) / 2
    flip = np.array([-1.0, 1.0])
    one, other = solved(before, after, road, mean), solved(before * flip, after * flip, road, mean * MIRROR)
    np.testing.assert_allclose(other.unknowns, one.unknowns * MIRROR, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(other.inlying, one.inlying, atol=1e-7)
