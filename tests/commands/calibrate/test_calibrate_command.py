"""`fcw calibrate --points`: what scripts and people get, and that mistakes save nothing."""

import json
import math
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from fcw.camera.file import read_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.model import Lens
from fcw.camera.straight import LEVEL, Straightening
from fcw.frame import ImageSize
from fcw_viz.cli import main

PAPER = ["calibrate", "--points", "4:461", "5:428", "7:383", "--image-size", "1280x720", "--height", "1.225"]
TRUTH = GroundPlaneCamera(0.03, 1100, 359.5, 1.225, 639.5)
GOOD_POINTS = [f"{d}:{TRUTH.row_at(float(d))!r}" for d in (6, 15, 40)]
GOOD = ["calibrate", "--points", *GOOD_POINTS, "--image-size", "1280x720", "--height", "1.225"]


def result_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict:
    assert main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def test_papers_example_as_json(capsys):
    result = result_of(PAPER, capsys)
    free = result_of([*PAPER, "--exact"], capsys)
    for exact in (result["exact"], free["exact"], free):
        assert exact["pitch_rad"] == pytest.approx(1.10363, abs=5e-6)
        assert exact["focal_y_px"] == pytest.approx(260.928, abs=5e-4)
        assert exact["principal_row_px"] == pytest.approx(733.149, abs=5e-4)
        assert exact["horizon_row_px"] == pytest.approx(215.857, abs=5e-4)
    assert free["residuals_px"] == pytest.approx([0, 0, 0], abs=1e-9)
    assert math.degrees(abs(result["pitch_rad"])) < 20
    for answer in (result, free):
        assert any("2.29 m" in text and "2.1 to 2.4 m" in text for text in answer["warnings"])
        assert answer["proposed_reference_offset"]["offset_m"] == pytest.approx(2.29, abs=0.005)
    rows = free["rows"]
    assert [row["distance_m"] for row in rows] == [5, 10, 15, 20, 30, 40, 50, 80]
    assert rows[0]["row_px"] == pytest.approx(428)
    assert rows[-1]["high_m"] is None
    assert all(row["low_m"] <= row["distance_m"] for row in rows)
    assert free["saved"] is None


def test_rows_and_intervals_of_good_clicks(capsys):
    """The notes' table for clicks at 6, 15, 40 m: 38.9-41.3 m at 40 m, 73.8-88.0 m at 80 m."""
    result = result_of([*GOOD, "--exact", "--tape-error", "0"], capsys)
    rows = {row["distance_m"]: row for row in result["rows"]}
    assert rows[40]["row_px"] == pytest.approx(TRUTH.row_at(40.0))
    assert (rows[40]["low_m"], rows[40]["high_m"]) == pytest.approx((38.9, 41.3), abs=0.1)
    assert (rows[80]["low_m"], rows[80]["high_m"]) == pytest.approx((73.8, 88.0), abs=0.5)
    assert result["warnings"] == []


def test_a_worse_tape_widens_the_intervals(capsys):
    widths = []
    for tape_error in ("0", "0.01", "0.03"):
        rows = {
            row["distance_m"]: row for row in result_of([*GOOD, "--tape-error", tape_error], capsys)["rows"]
        }
        widths.append(rows[40]["high_m"] - rows[40]["low_m"])
    assert widths[0] < widths[1] < widths[2]


def test_implausible_is_a_warning_and_saved(tmp_path, capsys):
    file = tmp_path / "out.yaml"
    assert main([*PAPER, "--exact", "--save", str(file)]) == 0
    captured = capsys.readouterr()
    assert "likely cause: the distances were measured from the front bumper" in captured.err
    assert "2.29 m" in captured.err
    assert "1.10363 rad" in captured.out
    assert "733.149" in captured.out
    assert "unbounded" in captured.out
    assert f"saved {file}" in captured.out
    assert read_calibration(file).distance_at(383.0) == pytest.approx(7.0)


def test_three_points_are_not_praised_for_their_residuals_and_four_show_them(capsys):
    assert main([*GOOD, "--exact"]) == 0
    three = capsys.readouterr().out
    assert "says nothing about its quality" in three
    assert "residuals" not in three
    more = [*GOOD_POINTS, f"25:{TRUTH.row_at(25.0) + 1.5}"]
    assert main(["calibrate", "--points", *more, "--image-size", "1280x720", "--height", "1.225"]) == 0
    assert "residuals in px" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (("6", "166", "40"), "likely cause: 166 m should be 16.6 m, a slip of the decimal point"),
        (("6", "40", "16.6"), "likely cause: the distances of 40:{} and 16.6:{} are swapped"),
    ],
)
def test_points_out_of_order_are_told_with_the_mistake_that_explains_them(wrong, words, capsys):
    rows = [f"{TRUTH.row_at(d):.1f}" for d in (6.0, 16.6, 40.0)]
    points = [f"{said}:{row}" for said, row in zip(wrong, rows, strict=True)]
    assert main(["calibrate", "--points", *points, "--image-size", "1280x720", "--height", "1.225"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert words.format(*rows[1:]) in " ".join(captured.err.split())


def test_a_tilt_is_found_by_columns_and_named_as_a_cause_without_them(capsys):
    """Cameras tilted by -4 and 2 degrees; without columns a tilt looks like other mistakes."""
    result = result_of(command_of("4:569.6:425.8", "5:546.9:910.6", "7:451.5:480.0"), capsys)
    (warning,) = result["warnings"]
    tilt = re.search(r"the camera is tilted by (\S+) degrees to the left", warning)
    assert tilt is not None
    assert float(tilt[1]) == pytest.approx(4.0, abs=0.11)
    tilted = ("5:533.0:486.0", "10:408.1:784.3", "20:359.0:527.1")
    (warning,) = result_of(command_of(*tilted), capsys)["warnings"]
    assert "the camera is tilted by 1.9 degrees to the right" in warning
    without = [point.rpartition(":")[0] for point in tilted]
    (warning,) = result_of(command_of(*without), capsys)["warnings"]
    assert "or the camera is tilted: give the columns of the marks" in warning


def command_of(*points: str) -> list[str]:
    return ["calibrate", "--points", *points, "--image-size", "1280x720", "--height", "1.3"]


def test_reference_offset_moves_the_camera_behind_the_points(capsys):
    result = result_of([*PAPER, "--exact", "--reference-offset", "2.28"], capsys)
    assert result["pitch_rad"] == pytest.approx(0.1207, abs=5e-5)
    assert result["focal_y_px"] == pytest.approx(1267.8, abs=0.05)
    assert result["principal_row_px"] == pytest.approx(369.6, abs=0.05)
    assert result["reference_offset_m"] == 2.28
    assert result["warnings"] == []


def test_priors_are_taken_in_degrees_and_pixels(tmp_path, capsys):
    file = tmp_path / "out.yaml"
    field_of_view_deg = math.degrees(2 * math.atan(640 / 1100))
    result = result_of(
        [
            *("calibrate", "--points", GOOD_POINTS[0], GOOD_POINTS[2], "--image-size", "1280x720"),
            *("--height", "1.225", "--field-of-view", f"{field_of_view_deg}:2", "--principal-row", "359.5"),
            *("--horizon-row", f"{TRUTH.horizon_row_px}:1.5", "--row-sigma", "0.5", "--save", str(file)),
        ],
        capsys,
    )
    # But for the weak belief that a camera looks a little down.
    assert result["pitch_rad"] == pytest.approx(0.03, abs=1e-3)
    assert result["field_of_view_rad"] == pytest.approx(math.radians(field_of_view_deg), rel=1e-3)
    calibration = read_calibration(file)
    priors = calibration.priors
    assert calibration.row_sigma_px == 0.5
    assert priors.field_of_view_rad is not None
    assert priors.field_of_view_rad.sigma == pytest.approx(math.radians(2))
    assert priors.principal_row_px is not None
    assert priors.principal_row_px.sigma == pytest.approx(0.03 * 720)
    assert priors.horizon_row_px is not None
    assert priors.horizon_row_px.sigma == 1.5


def test_column_is_kept(tmp_path, capsys):
    file = tmp_path / "out.yaml"
    arguments = [*PAPER, "--save", str(file)]
    arguments[2] = "4:461:640.5"
    assert main(arguments) == 0
    capsys.readouterr()
    assert read_calibration(file).points[0].column_px == 640.5


@pytest.mark.parametrize("file_format", ["camera_info", "kalibr"])
def test_export_writes_the_named_file(file_format, tmp_path, capsys):
    file = tmp_path / "camera.yaml"
    focal_px = result_of([*GOOD, "--export", file_format, str(file)], capsys)["focal_y_px"]
    document = yaml.safe_load(file.read_text())
    written = document["cam0"]["intrinsics"] if file_format == "kalibr" else document["camera_matrix"]["data"]
    assert written[0] == focal_px


def test_imperial_units_for_people(capsys):
    assert main([*GOOD, "--units", "imperial"]) == 0
    text = capsys.readouterr().out
    assert "33 ft" in text
    heads, rest = text.split("two times in three", 1)[1].split("\n", 1)
    assert heads.split() == ["±"], "of the distance, as a part of it"
    assert " m " not in rest


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--points", "4:461", "4:428", "7:383"], "points 4:461 and 4:428 have the same distance"),
        (["--points", "4:461", "5:461", "7:383"], "points 4:461 and 5:461 have the same row"),
        (["--points", "4:461", "5:428", "7:440"], "point 7:440 is farther than 5:428 but lower"),
        (["--points", "4:461", "5:428"], "2 points given (4:461, 5:428), expected at least 3"),
        (["--points", "4:461", "5:nan", "7:383"], "point 5:nan: expected finite numbers"),
        (["--points", "4-461", "5:428", "7:383"], "--points 4-461: expected DISTANCE:ROW"),
        (["--points", "4:461:1:2", "5:428", "7:383"], "--points 4:461:1:2: expected DISTANCE:ROW"),
        (["--height", "0"], "--height 0 m: a camera behind a windscreen is 0.5 to 4 m above the road"),
        (["--height", "-1.2"], "--height -1.2 m: a camera behind a windscreen is 0.5 to 4 m"),
        (["--height", "120"], "did you mean 1.20 m?"),
        (["--height", "1225"], "did you mean 1.23 m?"),
        (["--height", "0.01"], "--height 0.01 m: a camera behind a windscreen"),
        (["--height", "nan"], "--height nan: expected a finite number"),
        (["--height", "inf"], "--height inf: expected a finite number"),
        (["--height", "1,2"], "--height 1,2: expected a number with a point: 1.2"),
        (["--row-sigma", "one"], "--row-sigma one: expected a finite number, such as 1.2"),
        (["--image-size", "1280"], "--image-size 1280: expected WIDTHxHEIGHT"),
        (["--reference-offset", "-1"], "--reference-offset -1 m: expected 0 to 5"),
        (["--reference-offset", "190"], "--reference-offset 190 m: expected 0 to 5, the metres from the"),
        (["--reference-offset", "190"], "did you mean 1.90 m?"),
        (["--field-of-view", "wide"], "--field-of-view wide: expected VALUE or VALUE:SIGMA"),
        (["--field-of-view", "190"], "field of view 190 degrees: expected more than 0 and less than 180"),
        (["--principal-row", "360:0"], "principal row: sigma 0, expected a number above 0"),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_mistakes_exit_2_with_one_message_and_save_nothing(arguments, message, as_json, tmp_path, capsys):
    option, *values = arguments
    given = {"--points": ["4:461", "5:428", "7:383"], "--image-size": ["1280x720"], "--height": ["1.225"]}
    given[option] = values
    command = ["calibrate", *(text for name, texts in given.items() for text in (name, *texts))]
    command += ["--save", str(tmp_path / "x.yaml"), "--export", "kalibr", str(tmp_path / "k.yaml")]
    assert main([*command, *(["--json"] if as_json else [])]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "no points: name a video or a picture to click them in, or give at least three as --points"),
        (["--points", "4:461", "5:428", "7:383", "--height", "1.2"], "--image-size is missing"),
        (["--points", "4:461", "5:428", "7:383", "--image-size", "1280x720"], "--height is missing"),
    ],
)
def test_missing_options_are_named(arguments, message, capsys):
    assert main(["calibrate", *arguments]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == ""


@pytest.fixture
def picture_folder(tmp_path: Path) -> Path:
    folder = tmp_path / "my.drive"
    folder.mkdir()
    for index in range(2):
        cv2.imwrite(str(folder / f"{index:03}.png"), np.zeros((72, 128, 3), np.uint8))
    return folder


def test_source_gives_the_image_size_and_the_place_to_save(picture_folder, capsys):
    camera = GroundPlaneCamera(0.03, 110, 35.5, 1.225, 63.5)
    points = [f"{d}:{camera.row_at(float(d))!r}" for d in (6, 15, 40)]
    command = ["calibrate", str(picture_folder), "--points", *points, "--height", "1.225", "--json"]
    assert main(command) == 0
    file = picture_folder.with_name("my.drive.calibration.yaml")
    assert json.loads(capsys.readouterr().out)["saved"] == str(file)
    assert read_calibration(file).image_size == ImageSize(128, 72)
    assert main([*command, "--image-size", "640x360"]) == 2
    assert "--image-size 640x360" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--json"], "--json: only with --points; the page has a button for it"),
        (["--export", "kalibr", "k.yaml"], "--export: only with --points"),
        (["--port", "0"], "--port 0: expected a number from 1 to 65535"),
        (["--speed", "25"], "--speed: only with --from-clip"),
        (["--lane-width", "3.7"], "--lane-width: needs two --lane-line"),
        (["--horizon-line", "0:30:127:31"], "--height is missing"),
    ],
)
def test_what_the_page_refuses_before_it_starts(arguments, message, picture_folder, capsys):
    assert main(["calibrate", str(picture_folder), "--no-open", *arguments]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == ""
    assert list(picture_folder.parent.iterdir()) == [picture_folder]


def test_missing_source_is_named(tmp_path, capsys):
    for arguments in (PAPER[1:], []):
        assert main(["calibrate", str(tmp_path / "no.mp4"), *arguments]) == 2
        assert "no.mp4" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_camera_that_looks_up_is_said_to_look_up(tmp_path, capsys):
    up = GroundPlaneCamera(-0.03, 1100, 359.5, 1.225, 639.5)
    points = [f"{d}:{up.row_at(float(d))!r}" for d in (6, 15, 40)]
    saved = tmp_path / "up.yaml"
    assert main(["calibrate", "--points", *points, *GOOD[-4:], "--exact", "--save", str(saved)]) == 0
    said = capsys.readouterr().out
    assert re.search(r"pitch 1\.72 ± \d+\.\d\d degrees up \(-0\.03 rad\)", said)
    assert "# Pitch 1.72 degrees up, " in saved.read_text()


@pytest.mark.slow
def test_a_chessboard_gives_a_lens_file_that_the_calibration_takes(tmp_path, capsys, data_dir):
    lens = tmp_path / "udacity.lens.yaml"
    found = result_of(
        ["calibrate", str(data_dir / "udacity-chessboards"), "--chessboard", "9x6", "--save", str(lens)],
        capsys,
    )
    assert found["field_of_view_deg"] == pytest.approx(57.9, abs=1)  # `data/README.md`: f about 1157 px
    assert found["coefficients"][0] < -0.2
    result = result_of([*GOOD, "--lens", str(lens)], capsys)
    assert result["focal_y_px"] == pytest.approx(1157, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--chessboard", "9x6"], "--chessboard: name the folder"),
        (["FOLDER", "--chessboard", "9"], "--chessboard 9: expected its inner corners"),
        (["FOLDER/no", "--chessboard", "9x6"], "not a folder of pictures of the board"),
        (["FOLDER", "--chessboard", "9x6"], "no picture in this folder that can be read; expected"),
        (["FOLDER", "--chessboard", "9x6", "--height", "1.3"], "--height: --chessboard does not use it"),
        (
            ["--from-drive", "FOLDER", "--save", "x.yaml", "--height", "1.3"],
            "--height: --from-drive does not",
        ),
    ],
)
def test_a_chessboard_that_is_not_there_is_refused(tmp_path, capsys, arguments, message):
    told = [argument.replace("FOLDER", str(tmp_path)) for argument in arguments]
    assert main(["calibrate", *told]) == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_a_lens_that_bends_the_picture_is_warned_of(capsys):
    wide = Lens("radtan", 700.0, 700.0, 639.5, 359.5, (-0.25, 0.06, 0.0, 0.0), ImageSize(1280, 720))
    camera = GroundPlaneCamera(0.03, 700.0, 359.5, 1.225, 639.5)
    way = Straightening(camera, LEVEL, wide, ImageSize(1280, 720))
    points = []
    for distance_m in (6.0, 15.0, 30.0):
        for lateral_m in (-3.0, 0.0, 3.0):
            straight = [[camera.column_at(lateral_m, distance_m), camera.row_at(distance_m)]]
            column_px, row_px = way.to_picture(np.array(straight))[0]
            points.append(f"{distance_m}:{row_px}:{column_px}")
    asked = ["calibrate", "--points", *points, "--image-size", "1280x720", "--height", "1.225"]
    (warning,) = result_of(asked, capsys)["warnings"]
    assert "the lens bends this picture" in warning
    assert "--chessboard" in warning


def test_a_point_in_the_sky_is_named_alone(capsys):
    points = ["5:585", "10:455", "20:392", "40:100"]
    assert main(["calibrate", "--points", *points, "--image-size", "1280x720", "--height", "1.3"]) == 2
    message = capsys.readouterr().err
    assert "the point 40:100 lies above the horizon" in " ".join(message.split())
    assert "5:585" not in message


def camera_info(path: Path, focal_px: float, width: int = 1280, height: int = 720) -> Path:
    """A lens of ROS that bends nothing, for `--lens`."""
    matrix = [focal_px, 0, (width - 1) / 2, 0, focal_px, (height - 1) / 2, 0, 0, 1]
    lens = {
        "image_width": width,
        "image_height": height,
        "distortion_model": "plumb_bob",
        "camera_matrix": {"rows": 3, "cols": 3, "data": matrix},
        "distortion_coefficients": {"rows": 1, "cols": 5, "data": [0.0] * 5},
    }
    path.write_text(yaml.safe_dump(lens))
    return path


def test_a_lens_of_pictures_of_another_aspect_ratio_is_refused_not_stretched(tmp_path, capsys):
    lens = camera_info(tmp_path / "four-by-three.yaml", 1100.0, 1280, 960)
    assert main([*GOOD, "--lens", str(lens)]) == 2
    said = capsys.readouterr().err
    assert f"--lens {lens}: the lens is of pictures of 1280x960, these are 1280x720: another aspect" in said


def test_with_a_lens_three_points_are_not_said_to_be_met_exactly(tmp_path, capsys):
    lens = camera_info(tmp_path / "other.yaml", 1000.0)
    assert main([*GOOD, "--lens", str(lens)]) == 0
    said = capsys.readouterr().out
    assert "exactly" not in said
    assert "residuals in px" in said


def test_a_lens_that_contradicts_the_height_is_said_and_not_just_obeyed(tmp_path, capsys):
    """The marks of a camera of 1100 px, and the lens of one that has 1400."""
    path = camera_info(tmp_path / "other.lens.yaml", 1400.0)
    points = [f"{text}:640" for text in GOOD_POINTS]
    (warning,) = result_of(["calibrate", "--points", *points, *GOOD[-4:], "--lens", str(path)], capsys)[
        "warnings"
    ]
    assert "the camera height of 1.225" in warning
    assert "contradicts the rest" in warning
