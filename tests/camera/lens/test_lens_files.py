"""Lenses of other tools' files, and lenses from pictures."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.export import camera_info_text, kalibr_text
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.files import read_lens
from fcw.camera.lens.model import Lens
from fcw.camera.lens.solve import lens_of_chessboards
from fcw.camera.straight import Orientation
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
LENS = Lens("radtan", 1157.0, 1152.0, 666.0, 388.0, (-0.24, 0.05, -0.001, 0.0002), SIZE)


def test_what_we_export_is_read_again(tmp_path):
    camera = GroundPlaneCamera(0.05, 1152.0, 388.0, 1.3, 666.0)
    calibration = replace(
        Calibration.from_camera(camera, SIZE), lens=LENS, orientation=Orientation(0.02, -0.01)
    )
    for name, text in (
        ("info.yaml", camera_info_text(calibration)),
        ("chain.yaml", kalibr_text(calibration)),
    ):
        (tmp_path / name).write_text(text)
        lens = read_lens(tmp_path / name)
        assert lens.coefficients[:4] == LENS.coefficients
        assert (lens.focal_x_px, lens.row_px, lens.image_size) == (1157.0, 388.0, SIZE)


def with_lens(lens: Lens) -> Calibration:
    camera = GroundPlaneCamera(0.05, lens.focal_y_px, lens.row_px, 1.3, lens.column_px)
    return replace(Calibration.from_camera(camera, SIZE), lens=lens)


@pytest.mark.parametrize(
    ("focal_px", "coefficients"),
    [(1157.0, (-0.25, -0.005, -7e-4, 3e-4, -0.02)), (1000.0, (-0.35, 0.15, 3e-4, -5e-4, -0.03))],
)
def test_kalibrs_four_coefficients_stand_for_a_lens_of_five(focal_px, coefficients, tmp_path):
    """Those of chessboards have five. Without the last, corners would lie 3 and 18 px off."""
    lens = Lens("radtan", focal_px, focal_px, 639.5, 359.5, coefficients, SIZE)
    (tmp_path / "chain.yaml").write_text(kalibr_text(with_lens(lens)))
    kalibr = read_lens(tmp_path / "chain.yaml")
    assert len(kalibr.coefficients) == 4
    places = np.array([(u, v) for u in (0.0, 320.0, 640.0, 1279.0) for v in (0.0, 180.0, 719.0)])
    off_px = np.linalg.norm(kalibr.distorted(lens.undistorted(places)) - places, axis=1)
    assert off_px.max() < 4
    assert np.median(off_px) < 1


def test_a_lens_that_kalibr_has_no_place_for_is_refused_with_the_other_format():
    lens = Lens("radtan", 700.0, 705.0, 639.5, 359.5, (0.3, 0.1, 1e-3, 0.0, 0.02, 0.6, 0.2, 0.05), SIZE)
    with pytest.raises(
        UserError, match=r"four coefficients, which miss it by up to \d+ px; export camera_info"
    ):
        kalibr_text(with_lens(lens))


def test_opencvs_own_file_is_read(tmp_path):
    path = tmp_path / "camera.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 1280)
    storage.write("image_height", 720)
    storage.write("camera_matrix", LENS.matrix)
    storage.write("distortion_coefficients", np.array([(*LENS.coefficients, 0.0)]))
    storage.release()
    lens = read_lens(path)
    assert lens.focal_y_px == 1152.0
    assert lens.coefficients == (*LENS.coefficients, 0.0)


@pytest.mark.parametrize("text", ["1e-05", "-2E3", "1.5e3", "6.5e+02"])
def test_numbers_are_read_however_another_tool_writes_them(text, tmp_path):
    """yaml-cpp, and with it ROS, writes 1e-05, in which PyYAML by itself sees a text."""
    path = tmp_path / "info.yaml"
    path.write_text(
        "{image_width: 4, image_height: 3, camera_matrix: [9, 0, 1, 0, 9, 1, 0, 0, 1], "
        f"distortion_coefficients: [{text}, 0, 0, 0]}}"
    )
    assert read_lens(path).coefficients[0] == float(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [", "not YAML"),
        ("height: 3", "no camera_matrix and no cam0"),
        ("cam0: {camera_model: omni}", "cam0.camera_model is 'omni', expected pinhole"),
        (
            "{image_width: 4, image_height: 3, camera_matrix: [1, 2], distortion_coefficients: [0, 0, 0, 0]}",
            "camera_matrix is (1.0, 2.0), expected nine numbers",
        ),
        (
            "{image_width: 4, image_height: 3, camera_matrix: [9, 0, 1, 0, 9, 1, 0, 0, 1], "
            "distortion_coefficients: [0.1]}",
            "distortion coefficients is [0.1], expected 4 or 5 or 8 numbers of radtan",
        ),
        (
            "{image_width: 4, image_height: 3, camera_matrix: [9, 0, 1, 0, 9, 1, 0, 0, 1], "
            "distortion_model: [plumb_bob], distortion_coefficients: [0, 0, 0, 0]}",
            "distortion_model is ['plumb_bob'], expected one of plumb_bob",
        ),
    ],
)
def test_another_file_is_named_with_what_was_expected(text, message, tmp_path):
    path = tmp_path / "lens.yaml"
    path.write_text(text)
    with pytest.raises(UserError) as error:
        read_lens(path)
    assert message in str(error.value)
    assert str(path) in str(error.value)
    with pytest.raises(UserError, match="no such lens file"):
        read_lens(tmp_path / "none.yaml")


@pytest.mark.slow
def test_the_udacity_boards_give_its_camera(data_dir):
    """`data/README.md`: f about 1157 px."""
    pictures = [
        np.asarray(cv2.imread(str(path)), np.uint8)
        for path in sorted((data_dir / "udacity-chessboards").glob("*.jpg"))
    ]
    pictures = [picture for picture in pictures if picture.shape[:2] == (720, 1280)]
    lens = lens_of_chessboards(pictures, (9, 6))
    assert lens.focal_x_px == pytest.approx(1157, rel=0.01)
    assert lens.coefficients[0] < -0.2
    assert math.degrees(2 * math.atan(640 / lens.focal_x_px)) == pytest.approx(57.9, abs=1)


def test_too_few_boards_are_refused():
    with pytest.raises(UserError, match="shows in 0 of 2 pictures, expected 3 or more"):
        lens_of_chessboards([np.zeros((90, 160, 3), np.uint8)] * 2, (9, 6))


def test_a_file_that_grows_when_it_is_read_is_refused(tmp_path):
    path = tmp_path / "lens.yaml"
    path.write_text("a: &a [1, 1]\nb: &b [*a, *a]\ncamera_matrix: [*b, *b]\n")
    with pytest.raises(UserError, match=r"lens\.yaml: not YAML \(anchors are not allowed"):
        read_lens(path)
