"""Two calibrations side by side: rows and what one reads where the other says so."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Ruler
from fcw.camera.straight import Orientation
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.panels.compare import comparison_html, read_there, vehicles_words

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.0, 1000.0, 359.5, 1.3, 639.5)
HERE = Calibration.from_camera(CAMERA, SIZE)
FILE = Path("drives/old.calibration.yaml")


def test_a_camera_a_tenth_higher_reads_a_tenth_more():
    there = Calibration.from_camera(GroundPlaneCamera(0.0, 1000.0, 359.5, 1.43, 639.5), SIZE)
    assert read_there(HERE, there, 20.0) == pytest.approx(22.0)
    html = comparison_html(HERE, there, FILE, imperial=False)
    # v - v0 = f h / d
    assert "<tr><td>20 m</td><td>424.5</td><td>431.0</td><td>22.0</td><td>+10.0%</td></tr>" in html
    assert "old.calibration.yaml" in html


def test_distances_from_another_reference_are_told_from_the_one_here():
    there = Calibration.from_camera(CAMERA, SIZE, 1.8)
    assert read_there(HERE, there, 20.0) == pytest.approx(20.0)


def test_rows_that_the_other_one_sees_in_the_sky_are_said_to_be():
    there = Calibration.from_camera(GroundPlaneCamera(-0.06, 1000.0, 359.5, 1.3, 639.5), SIZE)
    assert "<td>sky</td>" in comparison_html(HERE, there, FILE, imperial=False)


def test_how_each_camera_is_turned_is_told_where_its_file_says_it():
    turned = Orientation(math.radians(3.0), math.radians(-1.8), math.radians(0.2), math.radians(0.5))
    html = comparison_html(HERE, replace(HERE, orientation=turned), FILE, imperial=False)
    assert html.count("yaw 3.00 ± 0.20° to the left, roll -1.80 ± 0.50° to the right") == 1
    assert html.count("yaw") == 1, "of the level one nothing is known"


@pytest.mark.parametrize(
    ("height_m", "pitch_rad", "words"),
    [
        (1.3, 0.0, "they fit both equally well (here they come out +0% wide; there they come out +0% wide)"),
        (
            1.56,
            0.0,
            "they fit clearly better here (here they come out +0% wide; there they come out +20% wide)",
        ),
        (1.3, -0.012, "they fit clearly better here"),
    ],
)
def test_vehicles_judge_which_calibration_has_them_as_wide_near_and_far(height_m, pitch_rad, words):
    """A horizon that is 12 px too low makes far vehicles wider than near ones."""
    rulers = [
        Ruler(639.5, CAMERA.row_at(d), 1.8 * 1000.0 / d, Gaussian(1.8, 0.15), 1.0)
        for d in (10.0, 15.0, 20.0, 30.0, 45.0)
    ]
    there = Calibration.from_camera(GroundPlaneCamera(pitch_rad, 1000.0, 359.5, height_m, 639.5), SIZE)
    told = vehicles_words(HERE, there, rulers, taken=False)
    assert told.startswith("5 vehicles of the drive, by their widths near and far: ")
    assert words in told
    if words.startswith("they fit clearly"):
        assert "clearly better there" in vehicles_words(there, HERE, rulers, taken=False)


def test_feet_are_feet():
    assert "<td>65.6 ft</td>" in comparison_html(HERE, HERE, FILE, imperial=True)
