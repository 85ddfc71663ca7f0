"""A recorded clip calibrated by what it shows."""

import math

import pytest

from fcw.box import Box
from fcw.camera.calibration import Gaussian, GroundPoint, Priors
from fcw.camera.solve import calibrate
from fcw.detection.choice import load_model, make_detector
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.self_calibration.clip import (
    ClipObservations,
    _ruler,
    calibrate_clip,
    rough_calibration,
)
from fcw.sources import open_source

SIZE = ImageSize(1280, 720)
LENS = Priors(Gaussian(math.radians(58), math.radians(3)))
"""As a data sheet would say it; the chessboards say 57.8 degrees."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("height_m", "priors", "error"),
    [
        (Gaussian(1.2, 0.024), LENS, 0.08),
        (Gaussian(1.3, 0.12), Priors(), 0.20),
    ],
)
def test_the_udacity_clip_without_any_mark(height_m, priors, error, data_dir):
    """Vehicles within 8 % with lens and height, within 20 % with nothing; each inside its own interval."""
    source = open_source(data_dir / "clips" / "udacity_test_small1.mp4")
    # `calibrations.txt`: by the chessboards, lane and dashes.
    truth = calibrate(
        [GroundPoint(8, 592.62), GroundPoint(15, 511.83), GroundPoint(40, 454.12)], SIZE, 1.19, exact=True
    )
    guess = rough_calibration(SIZE, height_m.value, priors)
    detector = make_detector("acf-full", load_model("acf-full"), guess)
    found = calibrate_clip(source, detector, height_m, priors=priors)
    row_px = truth.row_at(30.0)
    assert found.distance_at(row_px) == pytest.approx(30, rel=error)
    low_m, high_m = found.distance_interval(row_px)
    assert low_m < 30 < high_m


def test_a_known_speed_gives_the_height():
    seen = ClipObservations(None, (), 20.0, 10)
    assert seen.height_by_speed(26.0).value == pytest.approx(1.3)
    with pytest.raises(UserError, match="measure the camera's height"):
        ClipObservations(None, (), None, 10).height_by_speed(26.0)


def test_boxes_that_are_cut_small_or_aside_are_no_rulers():
    assert _ruler(Box(600, 400, 80, 60), SIZE) is not None
    for box in (
        Box(600, 400, 20, 15),
        Box(0, 400, 200, 100),
        Box(1100, 400, 80, 60),
        Box(600, 700, 80, 60),
    ):
        assert _ruler(box, SIZE) is None
