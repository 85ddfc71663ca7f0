"""Dashes that do not keep the period that was said: seen by what else is known, said, and in the interval."""

import pytest

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.joint.uneven import uneven_dashes
from fcw.camera.lens.model import Lens
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
LENS = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (0.0, 0.0, 0.0, 0.0), SIZE)
HEIGHT = Gaussian(1.3, 0.03)
LINE_M, LANE_M = -1.8, 3.6
AT_M = 30.0


def evidence(period_m: float, *true_m: float) -> Evidence:
    """Dashes where they truly are, with the period that is said, and the lane lines."""

    def place(lateral_m: float, distance_m: float) -> tuple[float, float]:
        return CAMERA.column_at(lateral_m, distance_m), CAMERA.row_at(distance_m)

    points = tuple(
        GroundPoint(period_m * k, row_px, column_px)
        for k, (column_px, row_px) in enumerate(place(LINE_M, distance_m) for distance_m in true_m)
    )
    right, left = ((place(side_m, 7.0), place(side_m, 40.0)) for side_m in (LINE_M, LINE_M + LANE_M))
    return Evidence(
        points=points, first_unknown=True, lines=(left, right), lane_width_m=Gaussian(LANE_M, 0.1)
    )


def at_30_m(calibration: Calibration) -> tuple[float, float, float]:
    """What is read where the road is 30 m away, and its interval."""
    row_px = CAMERA.row_at(AT_M)
    low_m, high_m = calibration.distance_interval(row_px)
    return calibration.distance_at(row_px), low_m, high_m


@pytest.mark.parametrize("period_m", [9.0, 12.0, 14.63])
def test_dashes_that_keep_their_period_are_not_accused(period_m):
    true_m = [8.0 + k * period_m for k in range(4)]
    assert uneven_dashes(Known(evidence(period_m, *true_m), SIZE, HEIGHT, lens=LENS)) is None
    seen_m, low_m, high_m = at_30_m(
        calibrate_jointly(Known(evidence(period_m, *true_m), SIZE, HEIGHT, lens=LENS))
    )
    assert seen_m == pytest.approx(AT_M, rel=0.005)
    assert high_m - low_m < 0.12 * AT_M


def test_a_gap_that_is_another_one_is_found_and_named():
    """A bridge's joint lies between the second and the third dash."""
    broken = evidence(12.0, 8.0, 20.0, 36.0, 48.0)
    uneven = uneven_dashes(Known(broken, SIZE, HEIGHT, lens=LENS))
    assert uneven is not None
    assert uneven.gaps_m == pytest.approx((12.0, 16.0, 12.0), rel=0.06)
    assert "between dash 2 and dash 3 it is about" in uneven.text
    seen_m, low_m, high_m = at_30_m(calibrate_jointly(Known(broken, SIZE, HEIGHT, lens=LENS)))
    assert low_m < AT_M < high_m
    assert seen_m == pytest.approx(AT_M, rel=0.03)


@pytest.mark.parametrize("true_period_m", [11.5, 12.7, 17.0])
def test_dashes_of_another_period_than_the_rules_leave_no_sure_and_wrong_distance(true_period_m):
    other = evidence(14.63, *(8.0 + k * true_period_m for k in range(4)))
    seen_m, low_m, high_m = at_30_m(calibrate_jointly(Known(other, SIZE, HEIGHT, lens=LENS)))
    assert low_m < AT_M < high_m
    # The rest of what was said has more weight than the rule.
    assert abs(seen_m / AT_M - 1) < 0.5 * abs(14.63 / true_period_m - 1)


@pytest.mark.parametrize("true_period_m", [11.5, 17.0])
def test_another_period_is_told_where_the_rest_is_sure_enough(true_period_m):
    other = evidence(14.63, *(8.0 + k * true_period_m for k in range(4)))
    uneven = uneven_dashes(Known(other, SIZE, HEIGHT, lens=LENS))
    assert uneven is not None
    assert uneven.gaps_m == pytest.approx([true_period_m] * 3, rel=0.03)
    assert "their period of 14.63 m: judging by everything else you gave, here it is about" in uneven.text


def test_without_anything_that_would_tell_nobody_is_accused():
    other = evidence(14.63, 8.0, 20.7, 33.4)
    dashes_alone = Evidence(points=other.points, first_unknown=True)
    assert uneven_dashes(Known(dashes_alone, SIZE, HEIGHT)) is None
