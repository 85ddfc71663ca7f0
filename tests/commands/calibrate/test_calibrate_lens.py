"""`fcw calibrate` with a lens, and without one where it would be needed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.export import camera_info_text
from fcw.camera.ground_plane import GroundPlaneCamera
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
