"""A horizon that the drive and the vehicles ahead tell differently."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Gaussian, Priors
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import VEHICLE_WIDTH_M, Evidence, Ruler
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.uncertainty import camera_sigmas
from fcw.detection.choice import searching_detector
from fcw.frame import ImageSize
from fcw.self_calibration.clip import ClipObservations, calibrate_clip, rough_calibration
from fcw.self_calibration.contradiction import contradiction_in
from fcw.sources import open_source

DEMO = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(math.radians(2), 1000.0, 359.5, 1.3, 639.5)
VEHICLES = tuple(
    Ruler(
        CAMERA.principal_column_px,
        CAMERA.row_at(distance_m),
        CAMERA.focal_y_px * VEHICLE_WIDTH_M.value / distance_m,
        VEHICLE_WIDTH_M,
        1.0,
    )
    for distance_m in (10.0, 14.0, 20.0, 25.0, 35.0, 50.0)
)


def known(off_px: float) -> Known:
    """A drive that leads to a row so far below the horizon of the vehicles."""
    travel = Gaussian(639.5, 5.0), Gaussian(CAMERA.horizon_row_px + off_px, 5.0)
    return Known(Evidence(travel_px=travel, rulers=VEHICLES), SIZE, Gaussian(1.3, 0.05))


@pytest.mark.parametrize("off_px", [-3.0, 0.0, 3.0])
def test_what_agrees_contradicts_nothing(off_px: float):
    assert contradiction_in(known(off_px)) is None


@given(off_px=st.floats(12.0, 80.0), sign=st.sampled_from((-1.0, 1.0)))
def test_neither_is_ruled_out_by_what_comes_of_both(off_px: float, sign: float):
    """From 0.7 to 4.6 degrees apart; before, the one that loses is up to 16 sigmas away."""
    both = known(sign * off_px)
    before, contradiction = calibrate_jointly(both), contradiction_in(both)
    assert contradiction is not None
    assert contradiction.apart_rad == pytest.approx(off_px / CAMERA.focal_y_px, rel=0.1)
    after = contradiction.widened(before)
    assert after.camera == before.camera
    sigma_px = camera_sigmas(after).horizon_row_px
    for told_px in (CAMERA.horizon_row_px, CAMERA.horizon_row_px + sign * off_px):
        assert abs(told_px - after.horizon_row_px) < 2 * sigma_px
    assert sigma_px < off_px
    # It is the pitch that is not known: what is told of the lens stays.
    assert camera_sigmas(after).pitch_rad > camera_sigmas(before).pitch_rad
    assert camera_sigmas(after).focal_y_px == pytest.approx(camera_sigmas(before).focal_y_px)


@pytest.mark.parametrize("without", ["drive", "vehicles"])
def test_what_is_told_once_is_contradicted_by_nothing(without: str):
    both = known(60.0)
    alone = Evidence(rulers=VEHICLES) if without == "drive" else Evidence(travel_px=both.evidence.travel_px)
    assert contradiction_in(Known(alone, SIZE, Gaussian(1.3, 0.05))) is None


@pytest.mark.parametrize("stated", [None, Gaussian(330.0, 2.0)])
def test_a_clip_is_as_unsure_as_it_contradicts_itself_unless_the_horizon_is_stated(stated, monkeypatch):
    seen = ClipObservations(known(50.0).evidence.travel_px, None, VEHICLES, 10)
    monkeypatch.setattr("fcw.self_calibration.clip.observe_clip", lambda *_args, **_kwargs: seen)
    source = open_source(DEMO)
    detector = searching_detector(rough_calibration(source.image_size, 1.3))
    priors = Priors(horizon_row_px=stated)
    height_m = Gaussian(1.3, 0.05)
    found = calibrate_clip(source, detector, Known(Evidence(), source.image_size, height_m, priors=priors))
    sigma_px = camera_sigmas(found.calibration).horizon_row_px
    if stated is None:
        assert found.contradiction is not None
        assert sigma_px > 20
    else:
        assert found.contradiction is None
        assert sigma_px < 2
