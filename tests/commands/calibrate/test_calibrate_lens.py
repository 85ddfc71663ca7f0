"""`fcw calibrate` with a lens, and without one where it would be needed."""

import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.export import camera_info_text
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.files import read_lens
from fcw.camera.lens.model import Lens
from fcw.camera.straight import Orientation, Straightening
from fcw.frame import ImageSize
from fcw_viz.cli import main

SIZE = ImageSize(1280, 720)
TRUTH = GroundPlaneCamera(0.03, 1100, 359.5, 1.225, 639.5)
LANES = [
    "--lane-line",
    *(
        ":".join(f"{value:.2f}" for d in (6.0, 40.0) for value in (TRUTH.column_at(y, d), TRUTH.row_at(d)))
        for y in (1.8, -1.8)
    ),
]


def result_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict:
    assert main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def lens_file(tmp_path: Path, lens: Lens) -> str:
    """As ROS has it, for `--lens`."""
    file = tmp_path / "camera.lens.yaml"
    file.write_text(camera_info_text(replace(Calibration.from_camera(TRUTH, lens.image_size), lens=lens)))
    return str(file)


STRAIGHT_LENS = Lens("radtan", 1100.0, 1100.0, 639.5, 359.5, (0.0, 0.0, 0.0, 0.0), SIZE)


@pytest.mark.parametrize("besides", ["lens", "lane lines"])
def test_two_points_are_enough_where_the_lens_or_the_lane_lines_tell_the_rest(besides, tmp_path, capsys):
    """As they are on the page."""
    said = ["--lens", lens_file(tmp_path, STRAIGHT_LENS)] if besides == "lens" else LANES
    points = [f"{d}:{TRUTH.row_at(d)!r}" for d in (6.0, 15.0)]
    arguments = ["calibrate", "--points", *points, "--image-size", "1280x720", "--height", "1.225"]
    result = result_of([*arguments, *said], capsys)
    at_20 = next(row for row in result["rows"] if row["distance_m"] == 20)
    assert at_20["row_px"] == pytest.approx(TRUTH.row_at(20.0), abs=0.5)
    assert main(arguments) == 2
    assert "2 points given" in capsys.readouterr().err


def test_marks_beside_each_other_at_one_distance_are_of_a_fisheye_in_two_rows(tmp_path, capsys):
    camera = GroundPlaneCamera(0.1, 500.0, 359.5, 1.3, 639.5)
    lens = Lens("equidistant", 500.0, 500.0, 639.5, 359.5, (0.0, 0.0, 0.0, 0.0), SIZE)
    marks_m = ((3.0, 0.0), (3.0, 4.0), (12.0, 0.0))
    straight = np.array([(camera.column_at(y, d), camera.row_at(d)) for d, y in marks_m])
    places = Straightening(camera, Orientation(), lens, SIZE).to_picture(straight)
    assert places[0, 1] - places[1, 1] > 40
    points = [f"{d}:{row}:{column}" for (d, _), (column, row) in zip(marks_m, places.tolist(), strict=True)]
    arguments = ["calibrate", "--points", *points, "--image-size", "1280x720", "--height", "1.3"]
    result = result_of([*arguments, "--lens", lens_file(tmp_path, lens)], capsys)
    assert result["pitch_rad"] == pytest.approx(camera.pitch_rad, abs=0.002)
    assert main(arguments) == 2
    assert "have the same distance, 3 m" in capsys.readouterr().err


BOARD_FOCAL_PX = 500.0


def write_boards(folder: Path, sizes: list[tuple[int, int]]) -> None:
    """A chessboard of 6x4 inner corners seen by a lens of `BOARD_FOCAL_PX`, in pictures of these sizes."""
    folder.mkdir()
    for number, (width, height) in enumerate(sizes):
        focal_px = BOARD_FOCAL_PX * width / 640
        matrix = np.array([[focal_px, 0, width / 2 - 0.5], [0, focal_px, height / 2 - 0.5], [0, 0, 1]])
        turn = np.array([0.35 * math.sin(2.0 * number), 0.35 * math.cos(2.0 * number), 0.1 * number])
        away = np.array([-3.5, -2.5, 9.0])
        image = np.full((height, width, 3), 255, np.uint8)
        for row in range(5):
            for column in range(7):
                if (row + column) % 2:
                    continue
                square = np.array([(column + x, row + y, 0.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
                places, _ = cv2.projectPoints(square, turn, away, matrix, np.zeros(5))
                corners = np.round(places.reshape(-1, 2) * 16).astype(np.int32)
                cv2.fillConvexPoly(image, corners, (0, 0, 0), cv2.LINE_AA, 4)
        cv2.imwrite(str(folder / f"{number}.png"), image)


@pytest.mark.parametrize("named", ["boards.v1", "."])
def test_the_lens_of_a_folder_of_boards_is_saved_under_the_folders_whole_name(
    named, tmp_path, capsys, monkeypatch
):
    folder = tmp_path / "boards.v1"
    write_boards(folder, [(640, 480)] * 4)
    monkeypatch.chdir(folder if named == "." else tmp_path)
    result = result_of(["calibrate", named, "--chessboard", "6x4"], capsys)
    assert Path(result["saved"]).name == "boards.v1.lens.yaml"
    assert read_lens(Path(result["saved"])).focal_y_px == pytest.approx(BOARD_FOCAL_PX, rel=0.02)


def test_boards_in_pictures_of_several_sizes_give_no_lens(tmp_path, capsys):
    """Taken for one size they gave a wrong lens, and no word of it."""
    folder = tmp_path / "boards"
    write_boards(folder, [(640, 480), (640, 480), (320, 240), (640, 480), (641, 481)])
    assert main(["calibrate", str(folder), "--chessboard", "6x4"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "pictures of several sizes (3 of 640x480, 1 of 320x240, 1 of 641x481)" in said
    assert list(tmp_path.iterdir()) == [folder]
    (folder / "2.png").unlink()
    assert main(["calibrate", str(folder), "--chessboard", "6x4"]) == 0, "a pixel more is of the same lens"
