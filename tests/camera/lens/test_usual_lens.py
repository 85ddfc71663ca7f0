"""What every lens sees, of pictures that are wider than high and of upright ones."""

import math
from dataclasses import replace

import pytest

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.lens.usual import across_picture, usual_lens
from fcw.camera.plausibility import FindingKind, plausibility
from fcw.frame import ImageSize
from fcw.self_calibration.clip import rough_calibration
from fcw_viz.calibrate_app.document.ways.ways import TYPICAL_LENSES
from fcw_viz.calibrate_app.proposals.drive_look import assumed_camera

WIDE, UPRIGHT = ImageSize(1920, 1080), ImageSize(1080, 1920)


def focal_of(view: Gaussian | None, size: ImageSize) -> float:
    assert view is not None
    return size.width / 2 / math.tan(view.value / 2)


@pytest.mark.parametrize("marked", [True, False])
def test_a_camera_that_is_turned_upright_keeps_its_focal_length(marked):
    wide, upright = (usual_lens(size, marked=marked).field_of_view_rad for size in (WIDE, UPRIGHT))
    assert focal_of(upright, UPRIGHT) == pytest.approx(focal_of(wide, WIDE))
    for lens in TYPICAL_LENSES:
        assert focal_of(lens.across(UPRIGHT), UPRIGHT) == pytest.approx(focal_of(lens.across(WIDE), WIDE))
    for camera_of in (assumed_camera, lambda size: rough_calibration(size, 1.3).camera):
        assert camera_of(UPRIGHT).focal_y_px == pytest.approx(camera_of(WIDE).focal_y_px)


def test_a_telephone_held_upright_sees_38_degrees_from_side_to_side():
    phone = Gaussian(math.radians(63), math.radians(6))
    assert math.degrees(across_picture(phone, UPRIGHT).value) == pytest.approx(38, abs=0.2)
    assert across_picture(phone, WIDE) == phone


def test_its_sigma_follows_by_the_derivative():
    step = 1e-6
    for view_rad in (0.6, 1.1, 1.8):
        low, high = (across_picture(Gaussian(view_rad + d, 0.1), UPRIGHT) for d in (-step, step))
        slope = (high.value - low.value) / (2 * step)
        assert across_picture(Gaussian(view_rad, 0.1), UPRIGHT).sigma == pytest.approx(0.1 * slope, rel=1e-6)


def test_an_upright_telephone_that_zooms_a_little_is_no_tele_lens():
    """45 degrees along the longer side are 26 from side to side."""
    camera = assumed_camera(UPRIGHT)
    focal_px = UPRIGHT.height / 2 / math.tan(math.radians(45) / 2)
    calibration = Calibration.from_camera(replace(camera, focal_y_px=focal_px), UPRIGHT)
    assert FindingKind.FIELD_OF_VIEW not in {finding.kind for finding in plausibility(calibration)}
