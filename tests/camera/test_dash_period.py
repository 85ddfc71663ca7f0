"""Dashes do not tell their period: what that leaves open is said, and is in the interval."""

import math

import numpy as np
import pytest

from fcw.camera.calibration import Gaussian, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.lens.model import Lens
from fcw.camera.plausibility import FindingKind, plausibility
from fcw.camera.solve import calibrate
from fcw.camera.verdicts.period import dash_period_m, period_doubt
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
VIEW = Gaussian(2 * math.atan(640 / 1000), math.radians(2))


def dashes(said_m: tuple[float, ...], true_m: tuple[float, ...]) -> list[GroundPoint]:
    return [GroundPoint(said, CAMERA.row_at(true)) for said, true in zip(said_m, true_m, strict=True)]


def test_a_period_that_the_lens_leaves_open_is_asked_about_and_widens_the_interval():
    points = dashes((6.0, 18.0, 30.0), (6.0, 18.0, 30.0))
    unsure = calibrate(points, SIZE, 1.3)
    (finding,) = plausibility(unsure)
    assert finding.kind is FindingKind.PERIOD
    assert finding.is_question
    assert "do not tell whether their period is 12 m" in finding.text
    sure = calibrate(points, SIZE, 1.3, field_of_view=VIEW)
    assert plausibility(sure) == ()
    widths = [high - low for low, high in (c.distance_interval(c.row_at(30.0)) for c in (unsure, sure))]
    assert widths[0] > 2 * widths[1]


@pytest.mark.parametrize(
    "true_m", [(9.0, 27.0, 45.0), (9.0, 45.0, 81.0), (9.0, 45.0, 63.0), (9.0, 27.0, 63.0)]
)
@pytest.mark.parametrize("height_m", [1.1, 1.3, 1.7])
def test_guessed_dashes_of_another_period_are_never_passed_in_silence(true_m, height_m):
    """The issue's 24, 6 and 42 m, whose dashes are 18 m apart elsewhere, or are not next to each other."""
    camera = GroundPlaneCamera(0.05, 1000.0, 359.5, height_m, 639.5)
    points = [GroundPoint(d, camera.row_at(true)) for d, true in zip((6.0, 24.0, 42.0), true_m, strict=True)]
    assert plausibility(calibrate(points, SIZE, height_m))


@pytest.mark.parametrize(
    "taped_m", [(5.0, 10.0, 15.0), (10.0, 20.0, 30.0), (4.0, 5.0, 7.0), (6.0, 15.0, 40.0)]
)
def test_taped_marks_are_taken_for_no_dashes(taped_m):
    assert dash_period_m(taped_m) is None
    assert period_doubt(calibrate(dashes(taped_m, taped_m), SIZE, 1.3)) is None


def test_a_measured_period_and_a_known_lens_leave_no_doubt():
    lens = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (0.0, 0.0, 0.0, 0.0), SIZE)
    points = tuple(dashes((0.0, 15.0, 30.0), (8.0, 23.0, 38.0)))
    height = Gaussian(1.3, 0.03)

    def interval_m(lens: Lens | None, sigma_m: float | None) -> float:
        evidence = Evidence(points=points, first_unknown=True, period_sigma_m=sigma_m)
        calibration = calibrate_jointly(Known(evidence, SIZE, height, lens=lens))
        low_m, high_m = calibration.distance_interval(calibration.row_at(30.0))
        assert low_m < 30.0 < high_m
        return high_m - low_m

    by_rule, measured = interval_m(None, None), interval_m(None, 0.15)
    assert by_rule > 1.3 * measured
    assert interval_m(lens, None) < by_rule


def test_a_lens_that_is_known_moves_no_rows_by_its_axis():
    """An axis three pixels off shifts the straight picture and all that is in it: no distance changes."""
    lens = Lens("radtan", 1000.0, 1000.0, 639.5, 359.5, (0.0, 0.0, 0.0, 0.0), SIZE)
    points = tuple(GroundPoint(d, CAMERA.row_at(d), 639.5) for d in (6.0, 15.0, 40.0))
    calibration = calibrate_jointly(Known(Evidence(points=points), SIZE, Gaussian(1.3, 0.01), lens=lens))
    low_m, high_m = calibration.distance_interval(calibration.row_at(40.0))
    slope = CAMERA.row_slope_at(np.array([40.0]))[0]
    by_clicks_m = 1.0 / slope
    assert (high_m - low_m) / 2 < 1.2 * math.hypot(by_clicks_m, 0.01 * 40)
