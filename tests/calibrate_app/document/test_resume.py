"""What a session says of the calibration file it begins with."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, Priors
from fcw.camera.file import write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import VEHICLE_WIDTH_M, Evidence, Ruler
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.solve import calibrate
from fcw.camera.straight import Orientation
from fcw.frame import ImageSize
from fcw.self_calibration.turning.lens import PlainLens
from fcw_viz.calibrate_app.document.resume import Beginning, begin
from fcw_viz.calibrate_app.document.solution import calibration_of

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.03, 1000.0, 359.5, 1.3, 639.5)
POINTS = tuple(GroundPoint(d, row) for d, row in ((6.0, 500.2), (15.0, 408.0), (30.0, 371.1)))


def begun(calibration: Calibration, folder: Path) -> Beginning:
    path = folder / "clip.calibration.yaml"
    write_calibration(calibration, path)
    beginning = begin(folder / "clip.mp4", SIZE, path)
    beginning.journal.close()
    return beginning


VIEW = Gaussian(Calibration.from_camera(CAMERA, SIZE).field_of_view_rad, 0.1)
TURNED = replace(Calibration.from_camera(CAMERA, SIZE), orientation=Orientation(yaw_rad=0.05, roll_rad=-0.02))


OF_A_CLIP = replace(TURNED, priors=Priors(VIEW))
"""Whose view was stated: where the horizon lies was seen in the clip."""
WIDE = replace(
    Calibration.from_camera(CAMERA, SIZE),
    lens=PlainLens(CAMERA.focal_y_px, -0.3, (639.5, 359.5)).fisheye(SIZE),
    priors=Priors(VIEW, Gaussian(359.5, 3.0)),
)


@pytest.mark.parametrize("made", [TURNED, OF_A_CLIP, WIDE, calibrate(POINTS, SIZE, 1.3, tape_error=0.03)])
def test_what_a_file_holds_is_shown_and_kept(made, tmp_path):
    """Also of a camera without any point: its distances stay as they are when the page saves it again."""
    document = begun(made, tmp_path).history.document
    kept = calibration_of(document)
    assert kept is not None
    assert kept.orientation.yaw_rad == pytest.approx(made.orientation.yaw_rad, abs=1e-4)
    assert kept.orientation.roll_rad == pytest.approx(made.orientation.roll_rad, abs=1e-4)
    if made.points:
        assert kept.tape_error == made.tape_error
    for distance_m in (8.0, 20.0, 40.0):
        assert kept.distance_at(made.row_at(distance_m)) == pytest.approx(distance_m, rel=1e-3)


@pytest.mark.parametrize("bend", [None, -0.3])
def test_a_camera_that_a_clip_tells_is_as_uncertain_on_the_page_as_in_its_file(bend, tmp_path):
    seen = Evidence(travel_px=(Gaussian(639.5, 8.0), Gaussian(330.0, 2.0)))
    priors = Priors(Gaussian(VIEW.value, 0.1 * math.sin(VIEW.value)), Gaussian(359.5, 3.0))
    made = calibrate_jointly(Known(seen, SIZE, Gaussian(1.3, 0.12), priors=priors, rough=True))
    if bend is not None:
        focal_px = made.camera.focal_y_px
        made = replace(made, lens=PlainLens(focal_px, bend, (639.5, 359.5)).fisheye(SIZE))
    kept = calibration_of(begun(made, tmp_path).history.document)
    assert kept is not None
    for distance_m in (8.0, 20.0, 40.0):
        row_px = made.row_at(distance_m)
        low_m, high_m = made.distance_interval(row_px)
        kept_low_m, kept_high_m = kept.distance_interval(row_px)
        assert kept_high_m - kept_low_m == pytest.approx(high_m - low_m, rel=0.2)


def test_of_an_ordinary_file_nothing_is_said_but_that_it_was_loaded(tmp_path):
    assert (
        begun(calibrate(POINTS, SIZE, 1.3), tmp_path).notice
        == "The points of clip.calibration.yaml were loaded."
    )


EXACT = calibrate(
    [GroundPoint(d, row) for d, row in ((4.0, 461.0), (5.0, 428.0), (7.0, 383.0))], SIZE, 1.225, exact=True
)
"""The paper's own example: with what every lens has, 10 m are seen in row 352, not 344."""
BY_VEHICLES = calibrate_jointly(
    Known(
        Evidence(
            POINTS[:1],
            rulers=tuple(
                Ruler(639.5, CAMERA.row_at(d), 1000 * VEHICLE_WIDTH_M.value / d, VEHICLE_WIDTH_M, 1.0)
                for d in (10.0, 15.0, 20.0, 30.0, 45.0)
            ),
        ),
        SIZE,
        Gaussian(1.3, 0.03),
        reference_offset_m=1.6,
    )
)


@pytest.mark.parametrize("made", [EXACT, BY_VEHICLES])
def test_a_file_whose_points_give_another_camera_is_not_said_to_be_what_is_shown(made, tmp_path):
    """Made without the priors of the page, or with what a file has no place for."""
    beginning = begun(made, tmp_path)
    assert beginning.saved is None
    assert "They alone do not give the camera in that file" in beginning.notice
    again = begin(tmp_path / "clip.mp4", SIZE, tmp_path / "clip.calibration.yaml")
    assert again.saved is None
    again.journal.close()
