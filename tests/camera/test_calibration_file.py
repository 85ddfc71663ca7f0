"""The calibration file, other image sizes, and exports."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.export import export_text
from fcw.camera.file import calibration_text, parse_calibration, read_calibration, write_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.lens.model import Lens
from fcw.camera.solve import calibrate
from fcw.camera.straight import Orientation, Straightening, Undone
from fcw.errors import UserError
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)


def full_calibration() -> Calibration:
    return calibrate(
        [
            GroundPoint(4.1, 560.3, 600.25),
            GroundPoint(9, 461.7),
            GroundPoint(15, 430),
            GroundPoint(33, 405.1),
        ],
        SIZE,
        1.2345,
        reference_offset_m=1.1,
        row_sigma_px=0.7,
        field_of_view=Gaussian(1.1, 0.05),
        principal_row=Gaussian(360, 20),
        horizon_row=Gaussian(390, 5),
    )


def three_point_calibration() -> Calibration:
    return calibrate([GroundPoint(6, 560.3), GroundPoint(15, 430), GroundPoint(40, 405.1)], SIZE, 1.2)


def test_an_implausible_calibration_carries_its_warning_in_the_file():
    paper = calibrate([GroundPoint(4, 461), GroundPoint(5, 428), GroundPoint(7, 383)], SIZE, 1.225)
    warnings = [line for line in calibration_text(paper).splitlines() if line.startswith("# Warning: ")]
    assert any("reference offset of 2.29 m" in line for line in warnings)
    assert parse_calibration(calibration_text(paper), "paper.yaml") == paper
    plausible = calibrate(paper.points, SIZE, 1.225, reference_offset_m=2.29)
    assert "Warning" not in calibration_text(plausible)


@given(st.floats(-0.1, 0.3), st.floats(400, 2000), st.floats(0.8, 3), st.floats(0, 3), st.floats(0.1, 3))
def test_file_gives_back_every_bit(pitch_rad, focal_px, height_m, offset_m, sigma_px):
    truth = GroundPlaneCamera(pitch_rad, focal_px, 359.5, height_m, 639.5)
    points = [GroundPoint(d, truth.row_at(d + offset_m)) for d in (6.0, 15.0, 40.0)]
    calibration = calibrate(points, ImageSize(1280, 1440), height_m, offset_m, sigma_px)
    assert parse_calibration(calibration_text(calibration), "x") == calibration


def test_file_holds_priors_columns_and_fits_too(tmp_path):
    calibration = full_calibration()
    write_calibration(calibration, tmp_path / "drive.calibration.yaml")
    loaded = read_calibration(tmp_path / "drive.calibration.yaml")
    assert loaded == calibration
    assert loaded.distance_interval(450.0, 1.0) == calibration.distance_interval(450.0, 1.0)
    assert [path.name for path in tmp_path.iterdir()] == ["drive.calibration.yaml"]


def test_known_camera_in_numpy_numbers_can_be_saved(tmp_path):
    camera = GroundPlaneCamera(*(np.float64(v) for v in (0.01, 721.5, 172.8, 1.65, 609.6)))
    calibration = Calibration.from_camera(camera, ImageSize(*np.array([1242, 375])))
    write_calibration(calibration, tmp_path / "kitti.yaml")
    assert read_calibration(tmp_path / "kitti.yaml") == calibration


def test_file_is_readable_and_says_degrees_only_in_a_comment():
    text = calibration_text(full_calibration())
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert "degrees" in " ".join(comments)
    assert "degrees" not in "\n".join(line for line in text.splitlines() if not line.startswith("#"))
    document = yaml.safe_load(text)
    assert document["fcw_calibration_version"] == 3
    assert document["image_size"] == {"width": 1280, "height": 720}
    assert document["points"][0] == {"distance_m": 4.1, "row_px": 560.3, "column_px": 600.25}
    assert document["height_m"] == 1.2345
    assert document["reference_offset_m"] == 1.1


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("fcw_calibration_version",), 5, "fcw_calibration_version is 5, this program reads 1, 2, 3, 4"),
        (("image_size", "width"), 0, "image_size.width is 0, expected a whole number of at least 1"),
        (("image_size",), [1, 2], "image_size is [1, 2], expected a mapping of fields"),
        (("height_m",), -1.2, "height_m is -1.2, expected a number above 0"),
        (("height_m",), "1.2 m", "height_m is '1.2 m', expected a finite number"),
        (("height_m",), True, "height_m is True, expected a finite number"),
        (("reference_offset_m",), -0.1, "reference_offset_m is -0.1, expected a number of at least 0"),
        (("row_sigma_px",), math.nan, "row_sigma_px is nan, expected a finite number"),
        (("points", 1, "distance_m"), 0, "points[1].distance_m is 0.0, expected a number above 0"),
        (("points", 1), 7, "points[1] is 7, expected a mapping of fields"),
        (("points",), None, "points is None, expected a list"),
        (("residuals_px",), [0.0], "residuals_px is [0.0], expected a list of 4 numbers"),
        (
            ("priors", "field_of_view_rad", "sigma"),
            0,
            "field_of_view_rad.sigma is 0.0, expected a number above 0",
        ),
        (
            ("camera", "pitch_rad"),
            2.0,
            "camera.pitch_rad is 2.0, expected a number between -1.5708 and 1.5708",
        ),
        (("camera", "focal_y_px"), 0, "camera.focal_y_px is 0.0, expected a number above 0"),
        (("height_m",), 1e300, "height_m is 1e+300, expected a number between -1e+12 and 1e+12"),
        (("row_sigma_px",), 1e9, "row_sigma_px is 1000000000.0, expected a number of at most 16384"),
        (("tape_error",), 0.7, "tape_error is 0.7, expected a number of at most 0.5"),
        (("orientation", "yaw_sigma_rad"), 4, "yaw_sigma_rad is 4.0, expected a number of at most 3.14159"),
        (("camera", "focal_y_px"), 1e-300, "camera.focal_y_px is 1e-300, expected a number of at least 1"),
        (
            ("row_covariance", "covariance_px2", 0, 0),
            1e308,
            "covariance_px2[0][0] is 1e+308, expected a number between -1e+12 and 1e+12",
        ),
        (("camera", "colour"), 1, "camera.colour is 1, expected no field of that name"),
        (("row_covariance", "support_distances_m"), [5.0, 4.0, 9.0], "expected three ascending distances"),
        (
            ("row_covariance", "covariance_px2"),
            [[1, 2, 0], [2, 1, 0], [0, 0, 1]],
            "without negative eigenvalues",
        ),
        (
            ("row_covariance", "covariance_px2", 2),
            [0, 1],
            "covariance_px2[2] is [0, 1], expected three numbers",
        ),
    ],
)
def test_wrong_field_is_named_with_its_value_and_what_was_expected(tmp_path, path, value, message):
    document = yaml.safe_load(calibration_text(full_calibration()))
    parent = document
    for key in path[:-1]:
        parent = parent[key]
    parent[path[-1]] = value
    file = tmp_path / "wrong.yaml"
    file.write_text(yaml.safe_dump(document))
    with pytest.raises(UserError, match=re.escape(message)) as error:
        read_calibration(file)
    assert str(error.value).startswith(f"{file}: ")


@pytest.mark.parametrize(
    "section", [(), ("image_size",), ("points", 0), ("priors",), ("camera",), ("row_covariance",)]
)
def test_every_missing_field_is_named(section):
    text = calibration_text(full_calibration())
    fields = yaml.safe_load(text)
    for key in section:
        fields = fields[key]
    for field in fields:
        document = yaml.safe_load(text)
        parent = document
        for key in section:
            parent = parent[key]
        del parent[field]
        with pytest.raises(UserError, match=f"x: .*{field} is missing"):
            parse_calibration(yaml.safe_dump(document), "x")


def test_result_that_does_not_belong_to_the_points_is_refused():
    document = yaml.safe_load(calibration_text(three_point_calibration()))
    document["points"][1]["row_px"] += 3
    with pytest.raises(UserError, match=r"residuals_px\[1\] is .* changed after calibrating"):
        parse_calibration(yaml.safe_dump(document), "x")


@pytest.mark.parametrize("text", ["", "- 1\n", "a: [", "points: 3\n", "\0"])
def test_what_is_no_calibration_is_named_so(text):
    with pytest.raises(UserError, match=r"x: not a .*fcw calibrate"):
        parse_calibration(text, "x")


def test_missing_and_unreadable_files(tmp_path):
    with pytest.raises(
        UserError, match=r"none\.yaml: no such calibration file; make one with `fcw calibrate`"
    ):
        read_calibration(tmp_path / "none.yaml")
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(UserError, match=r"binary\.yaml: cannot read"):
        read_calibration(tmp_path / "binary.yaml")


def test_what_could_not_be_read_again_is_not_saved(tmp_path):
    """A focal length of 2e7 px is that of no lens; the file that was there stays."""
    file = tmp_path / "camera.yaml"
    camera = GroundPlaneCamera(0.03, 1100.0, 359.5, 1.225, 639.5)
    write_calibration(Calibration.from_camera(camera, ImageSize(1280, 720)), file)
    before = file.read_text()
    nowhere = Calibration.from_camera(replace(camera, focal_y_px=2e7), ImageSize(1280, 720))
    with pytest.raises(UserError, match=r"camera\.yaml: .*focal_y_px is 20000000.*; not saved: check"):
        write_calibration(nowhere, file)
    assert file.read_text() == before


def test_saving_where_nothing_can_be_written_leaves_nothing(tmp_path):
    with pytest.raises(UserError, match=r"x\.yaml: cannot write .* name a file in a folder that exists"):
        write_calibration(three_point_calibration(), tmp_path / "no folder" / "x.yaml")
    (tmp_path / "folder").mkdir()
    with pytest.raises(UserError, match="this is no file, but a device, a pipe or a folder; name a file"):
        write_calibration(three_point_calibration(), tmp_path / "folder")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


@pytest.mark.parametrize(
    "size", [ImageSize(640, 360), ImageSize(1920, 1080), ImageSize(854, 480), ImageSize(2560, 1440)]
)
@pytest.mark.parametrize("calibration", [full_calibration(), three_point_calibration()])
def test_other_size_of_the_same_picture_sees_the_same_distances(calibration, size):
    """A point keeps its place between the picture's edges: v' + 1/2 = (v + 1/2) s."""
    other = calibration.for_image_size(size)
    assert other.image_size == size
    scale, column_scale = size.height / 720, size.width / 1280
    for row_px in (410.0, 450.0, 600.0):
        scaled_px = (row_px + 0.5) * scale - 0.5
        assert other.distance_at(scaled_px) == pytest.approx(calibration.distance_at(row_px), rel=1e-9)
        assert other.distance_interval(scaled_px, 2 * scale) == pytest.approx(
            calibration.distance_interval(row_px, 2.0), rel=1e-7
        )
        # 854 columns for 853.33: the lateral position is off by a part in a thousand at most.
        assert other.lateral_at((900.5) * column_scale - 0.5, scaled_px) == pytest.approx(
            calibration.lateral_at(900.0, row_px), rel=1e-3
        )
    assert other.row_sigma_px == pytest.approx(calibration.row_sigma_px * scale)
    assert parse_calibration(calibration_text(other), "x") == other


def test_rescaled_calibration_is_that_of_the_rescaled_clicks():
    calibration = full_calibration()
    other = calibration.for_image_size(ImageSize(640, 360))
    again = calibrate(
        other.points,
        ImageSize(640, 360),
        1.2345,
        reference_offset_m=1.1,
        row_sigma_px=0.35,
        field_of_view=Gaussian(1.1, 0.05),
        principal_row=Gaussian(360.5 / 2 - 0.5, 10),
        horizon_row=Gaussian(390.5 / 2 - 0.5, 2.5),
    )
    assert other.camera.pitch_rad == pytest.approx(again.camera.pitch_rad, rel=1e-6)
    assert other.camera.focal_y_px == pytest.approx(again.camera.focal_y_px, rel=1e-6)
    assert np.array(other.covariance) == pytest.approx(np.array(again.covariance), rel=1e-4)
    assert other.residuals_px == pytest.approx(again.residuals_px, abs=1e-5)


@pytest.mark.parametrize("roll_deg", [0.04, 0.12, 3.0])
@pytest.mark.parametrize("size", [ImageSize(426, 240), ImageSize(640, 360), ImageSize(3840, 2160)])
def test_a_rolled_camera_for_another_size_is_read_back_as_it_was_written(roll_deg, size):
    """A tenth of a degree moves a pixel of a large picture, and none of a small one; 426 is not 426.67."""
    camera = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
    way = Straightening(camera, Orientation(roll_rad=math.radians(roll_deg)), None, SIZE)
    ground_m = ((6.0, 2.0), (9.0, -2.0), (15.0, 2.0), (30.0, -3.0))
    straight = np.array([(camera.column_at(left_m, d), camera.row_at(d)) for d, left_m in ground_m])
    points = tuple(
        GroundPoint(d, row_px, column_px)
        for (d, _), (column_px, row_px) in zip(ground_m, way.to_picture(straight).tolist(), strict=True)
    )
    other = calibrate_jointly(Known(Evidence(points=points), SIZE, Gaussian(1.3, 0.02))).for_image_size(size)
    assert parse_calibration(calibration_text(other), "x") == other
    logged = other.straight()
    assert parse_calibration(calibration_text(logged), "drive") == logged


def test_same_size_is_the_same_calibration():
    calibration = three_point_calibration()
    assert calibration.for_image_size(ImageSize(1280, 720)) is calibration


@pytest.mark.parametrize(
    "size", [ImageSize(1024, 768), ImageSize(1280, 800), ImageSize(720, 1280), ImageSize(960, 544)]
)
def test_another_aspect_ratio_is_refused_with_both_sizes(size):
    with pytest.raises(
        UserError, match=f"1280x720.*{size}.*another aspect ratio; calibrate with a picture of {size}"
    ):
        three_point_calibration().for_image_size(size)


def test_exports_hold_the_intrinsics_in_the_places_of_their_formats():
    calibration = three_point_calibration()
    focal, row = calibration.camera.focal_y_px, calibration.camera.principal_row_px
    info = yaml.safe_load(export_text(calibration, "camera_info"))
    assert (info["image_width"], info["image_height"]) == (1280, 720)
    assert info["camera_matrix"] == {"rows": 3, "cols": 3, "data": [focal, 0, 639.5, 0, focal, row, 0, 0, 1]}
    assert info["projection_matrix"]["data"] == [focal, 0, 639.5, 0, 0, focal, row, 0, 0, 0, 1, 0]
    assert info["distortion_model"] == "plumb_bob"
    assert info["distortion_coefficients"]["data"] == [0] * 5
    kalibr = yaml.safe_load(export_text(calibration, "kalibr"))["cam0"]
    assert kalibr["camera_model"] == "pinhole"
    assert kalibr["intrinsics"] == [focal, focal, 639.5, row]
    assert kalibr["distortion_coeffs"] == [0] * 4
    assert kalibr["resolution"] == [1280, 720]


def test_a_log_keeps_what_was_undone_of_its_pictures_and_a_file_has_no_word_of_it():
    lens = Lens("radtan", 1000.0, 1001.0, 640.0, 360.0, (-0.2, 0.1, 0.0, 0.0, 0.0), SIZE)
    turned = replace(
        full_calibration(), points=(), residuals_px=(), orientation=Orientation(0.02, 0.01, 0.003, 0.004)
    )
    assert "undone" not in calibration_text(turned)
    for taken in (turned, replace(turned, lens=lens), three_point_calibration()):
        straight = taken.straight()
        assert straight.undone == Undone(taken.orientation, taken.lens)
        assert parse_calibration(calibration_text(straight), "drive").undone == straight.undone
        smaller = straight.for_image_size(ImageSize(640, 360)).undone
        assert smaller == taken.for_image_size(ImageSize(640, 360)).straight().undone
