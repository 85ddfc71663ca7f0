"""What a session says of the calibration file it begins with."""

from dataclasses import replace
from pathlib import Path

import pytest

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.file import write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.camera.straight import Orientation
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.resume import begin

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.03, 1000.0, 359.5, 1.3, 639.5)
POINTS = tuple(GroundPoint(d, row) for d, row in ((6.0, 500.2), (15.0, 408.0), (30.0, 371.1)))


def notice_of(calibration: Calibration, folder: Path) -> str:
    path = folder / "clip.calibration.yaml"
    write_calibration(calibration, path)
    beginning = begin(folder / "clip.mp4", SIZE, path)
    beginning.journal.close()
    return beginning.notice


@pytest.mark.parametrize(
    ("made", "held"),
    [
        (
            replace(Calibration.from_camera(CAMERA, SIZE), orientation=Orientation(yaw_rad=0.05)),
            "turned to the side",
        ),
        (calibrate(POINTS, SIZE, 1.3, tape_error=0.03), "a tape error of 3.0%"),
    ],
)
def test_what_the_page_has_no_place_for_is_said_before_it_is_lost(made, held, tmp_path):
    notice = notice_of(made, tmp_path)
    assert held in notice
    assert "saving here leaves it out" in notice


def test_of_an_ordinary_file_nothing_is_said_but_that_it_was_loaded(tmp_path):
    notice = notice_of(calibrate(POINTS, SIZE, 1.3), tmp_path)
    assert notice == "The points of clip.calibration.yaml were loaded."
