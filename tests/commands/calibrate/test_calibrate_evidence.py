"""`fcw calibrate` with what is known of the road: lane lines, dashes, rectangles, number plates."""

import json
import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from fcw.camera.calibration import Calibration, Gaussian, Priors
from fcw.camera.export import camera_info_text
from fcw.camera.file import default_path, read_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.lens.model import Lens
from fcw.camera.straight import Orientation, Straightening
from fcw.frame import ImageSize
from fcw.self_calibration.clip import ClipCalibration, ClipObservations
from fcw.self_calibration.contradiction import Contradiction
from fcw.self_calibration.turning.lens import PlainLens
from fcw.sources.straight import StraightSource
from fcw_viz.cli import main
from fcw_viz.commands.calibrate.from_clip import _assumed
from fcw_viz.commands.calibrate.options import CalibrateCommand

TRUTH = GroundPlaneCamera(0.03, 1100, 359.5, 1.225, 639.5)
GOOD_POINTS = [f"{d}:{TRUTH.row_at(float(d))!r}" for d in (6, 15, 40)]
GOOD = ["calibrate", "--points", *GOOD_POINTS, "--image-size", "1280x720", "--height", "1.225"]


def result_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict:
    assert main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


LANES = [
    "--lane-line",
    *(
        ":".join(f"{value:.2f}" for d in (6.0, 40.0) for value in (TRUTH.column_at(y, d), TRUTH.row_at(d)))
        for y in (1.8, -1.8)
    ),
]


def test_lane_lines_and_points_with_columns_tell_the_whole_orientation(tmp_path, capsys):
    file = tmp_path / "out.yaml"
    points = [f"{d}:{TRUTH.row_at(float(d))!r}:{c}" for d, c in ((6, 500), (15, 700), (40, 640))]
    arguments = ["calibrate", "--points", *points, *LANES, "--image-size", "1280x720", "--height", "1.225"]
    result = result_of([*arguments, "--save", str(file)], capsys)
    orientation = result["orientation"]
    assert orientation["yaw_rad"] == pytest.approx(0, abs=0.01)
    assert abs(orientation["roll_rad"]) < 3 * orientation["roll_sigma_rad"]
    assert read_calibration(file).orientation.yaw_rad == orientation["yaw_rad"]


def test_a_line_that_the_lens_bends_is_said(capsys):
    places = [(TRUTH.column_at(1.8, d), TRUTH.row_at(d)) for d in np.geomspace(6.0, 40.0, 9).tolist()]
    bent = ":".join(f"{u + 30 * (1 - (k / 4 - 1) ** 2):.2f}:{v:.2f}" for k, (u, v) in enumerate(places))
    result = result_of([*GOOD, "--lane-line", bent, LANES[2]], capsys)
    assert any("give it with --lens" in warning for warning in result["warnings"])


def test_dashes_of_a_known_period_need_no_first_distance(capsys):
    rows = [f"{TRUTH.row_at(9.0 + 12 * k):.2f}" for k in range(4)]
    arguments = ["calibrate", "--dashes", *rows, "--dash-period", "12", "--image-size", "1280x720"]
    result = result_of([*arguments, "--height", "1.225"], capsys)
    assert result["points"][0]["distance_m"] == pytest.approx(9.0, rel=0.15)
    at_30 = next(row for row in result["rows"] if row["distance_m"] == 30)
    assert at_30["low_m"] < 30 < at_30["high_m"]


def test_marks_that_nobody_measures_are_refused(capsys):
    setup = ["--image-size", "1280x720", "--height", "1.225"]
    assert main(["calibrate", "--dashes", "640", "520", "480", "--dash-period", "1e300", *setup]) == 2
    assert "point 2e+300:480: distance 2e+300 m, expected at most 500" in capsys.readouterr().err
    assert main(["calibrate", "--points", *GOOD_POINTS, "1e9:360", *setup]) == 2
    assert "point 1e+09:360: distance 1e+09 m, expected at most 500" in capsys.readouterr().err
    many = [f"{d / 10}:{TRUTH.row_at(d / 10)}" for d in range(60, 161)]
    assert main(["calibrate", "--points", *many, *setup]) == 2
    assert "101 points: expected at most 100" in capsys.readouterr().err


BAY_M = ((6.0, -1.0), (6.0, 1.5), (11.0, 1.5), (11.0, -1.0))
BAY = [
    "--rectangle",
    ":".join(f"{TRUTH.column_at(y, d):.2f}:{TRUTH.row_at(d):.2f}" for d, y in BAY_M),
]


def test_a_parking_bay_alone_gives_the_camera_and_comes_back_from_the_file(tmp_path, capsys):
    file = tmp_path / "out.yaml"
    arguments = ["calibrate", *BAY, "--image-size", "1280x720", "--save", str(file)]
    result = result_of([*arguments, "--rectangle-sides", "2.5x5:0.05"], capsys)
    assert result["warnings"] == []
    assert result["height_m"] == pytest.approx(TRUTH.height_m, rel=0.02)
    assert result["pitch_rad"] == pytest.approx(TRUTH.pitch_rad, abs=0.005)
    at_20 = next(row for row in result["rows"] if row["distance_m"] == 20)
    assert at_20["row_px"] == pytest.approx(TRUTH.row_at(20.0), abs=2)
    saved = read_calibration(file).rectangles[0]
    assert saved.first_side_m is not None
    assert saved.second_side_m is not None
    assert (saved.first_side_m.sigma, saved.second_side_m.sigma) == (0.02, 0.05)


def test_exchanged_sides_are_refused_and_what_is_no_rectangle_is_said_before_what_comes_of_it(
    tmp_path, capsys
):
    file = tmp_path / "out.yaml"
    arguments = ["calibrate", "--image-size", "1280x720", "--save", str(file)]
    assert main([*arguments, *BAY, "--rectangle-sides", "5x2.5"]) == 2
    assert "exchange them in --rectangle-sides" in " ".join(capsys.readouterr().err.split())
    assert not file.exists()

    *others, column_px, row_px = map(float, BAY[1].split(":"))
    elsewhere = ":".join(map(str, (*others, column_px + 80, row_px + 30)))
    result = result_of([*arguments, "--rectangle", elsewhere, "--rectangle-sides", "2.5x5"], capsys)
    assert "the four corners are no rectangle of 2.5 by 5 m" in result["warnings"][0]
    assert not any("likely cause" in warning for warning in result["warnings"])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (("6:nan", "15:450"), "point 6:nan: expected finite numbers"),
        (("6:560", "6:450"), "points 6:560 and 6:450 have the same distance, 6 m"),
        (("6:560", "15:380", "40:430"), "likely cause: the distances of 15:380 and 40:430 are swapped"),
    ],
)
def test_points_beside_a_rectangle_are_checked_as_they_are_alone(points, message, capsys):
    arguments = ["calibrate", "--points", *points, *BAY, "--rectangle-sides", "2.5x5"]
    assert main([*arguments, "--image-size", "1280x720"]) == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_plates_and_the_lens_give_the_camera_without_its_height(capsys):
    plates = []
    for rear_m, left_m in ((7.0, 0.0), (12.0, 3.0), (20.0, -2.0)):
        tyre = (TRUTH.column_at(left_m, rear_m + 0.75), TRUTH.row_at(rear_m + 0.75))
        box = TRUTH.ground_box(rear_m, left_m, 0.52, 0.8)  # its top edge is the plate's
        ends = (box.x, box.y, box.x + box.w, box.y)
        plates.append(":".join(f"{value:.2f}" for value in (*ends, *tyre)))
    arguments = ["calibrate", "--plate", *plates, "--field-of-view", "60.4:1", "--image-size", "1280x720"]
    result = result_of(arguments, capsys)
    assert result["height_m"] == pytest.approx(TRUTH.height_m, rel=0.1)
    at_20 = next(row for row in result["rows"] if row["distance_m"] == 20)
    assert at_20["low_m"] < 20 < at_20["high_m"]
    assert at_20["row_px"] == pytest.approx(TRUTH.row_at(20.0), abs=5)
    larger = result_of([*arguments, "--plate-width", "0.6"], capsys)
    assert larger["height_m"] > 1.1 * result["height_m"]


def test_a_rectangle_without_a_side_needs_the_height(capsys):
    assert main(["calibrate", *BAY, "--image-size", "1280x720"]) == 2
    assert "--height is missing" in capsys.readouterr().err
    result = result_of(["calibrate", *BAY, "--image-size", "1280x720", "--height", "1.225"], capsys)
    assert result["focal_y_px"] == pytest.approx(TRUTH.focal_y_px, rel=0.15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--dashes", "500", "450", "430"], "--dash-period is missing"),
        (["--dashes", "500", "450", "430", "--dash-period", "0"], "--dash-period 0: expected metres above 0"),
        (["--lane-line", "1:2:3:nan"], "--lane-line 1:2:3:nan: expected COLUMN:ROW:COLUMN:ROW"),
        (["--dashes", "500", "450", "--dash-period", "12"], "2 ends given, expected 3 or more"),
        (["--lane-line", "1:2:3"], "--lane-line 1:2:3: expected COLUMN:ROW:COLUMN:ROW"),
        (["--rectangle", "1:2:3:4"], "--rectangle 1:2:3:4: expected the columns and rows of four corners"),
        (["--rectangle-sides", "2.5x5"], "--rectangle-sides: needs --rectangle"),
        ([*BAY, "--rectangle-sides", "2.5x5", "2.4x4.8"], "2 given for 1 --rectangle"),
        ([*BAY, "--rectangle-sides", "2.5"], "--rectangle-sides 2.5: expected AxB in metres, such as 2.5x5"),
        ([*BAY, "--rectangle-sides", "0x5"], "side 0 ± 0.02 m: expected 0.3 to 100 m"),
        (["--plate", "1:2:3:4"], "--plate 1:2:3:4: expected columns and rows of two ends and of a tyre"),
        (
            ["--plate", "1:2:9:2:5:9", "--plate-width", "fr"],
            "--plate-width fr: expected eu, us, jp, au or metres",
        ),
        (["--lane-line", "1:2:3:4", "--lane-width", "3.7"], "--lane-width: needs two --lane-line"),
        (["--from-clip"], "--from-clip: name the video or folder of pictures"),
        (
            ["--dashes", "500", "450", "430", "--dash-period", "12", "--points", "6:500"],
            "--dashes: only for marks whose first distance is not known; leave out --points",
        ),
        (["--points", *GOOD_POINTS, "--lens", "none.yaml"], "none.yaml: no such lens file"),
    ],
)
def test_wrong_statements_about_the_road_are_named(arguments, message, capsys):
    assert main(["calibrate", "--image-size", "1280x720", "--height", "1.2", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in " ".join(captured.err.split())


@pytest.mark.parametrize(
    ("focal_px", "expected"),
    [
        (
            None,
            "a field of view of 66 ± 16 degrees (of any camera), and distances are as uncertain as that; "
            "give",
        ),
        (
            Gaussian(758.0, 83.0),
            "and takes the focal length from the turns in the clip: 758 px ± 11 %; give",
        ),
    ],
)
def test_what_turns_tell_of_the_lens_is_said(focal_px, expected):
    view = Gaussian(math.radians(66), math.radians(16))
    command = CalibrateCommand(from_clip=True, height=1.3)
    (note,) = _assumed(command, Gaussian(1.3, 0.026), Priors(view), focal_px)
    assert expected in note
    assert note.endswith("give --field-of-view (degrees from side to side, by the data sheet)")
    assert _assumed(command, Gaussian(1.3, 0.026), Priors(), focal_px) == ()


BENT = PlainLens(300.0, -0.3, (319.5, 179.5)).fisheye(ImageSize(640, 360))


@pytest.fixture
def bent_clip(tmp_path, monkeypatch):
    """A clip whose turns tell a lens that bends; its straight pictures then tell a camera."""
    clip = tmp_path / "wide.mp4"
    writer = cv2.VideoWriter(str(clip), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (640, 360))
    for level in range(5):
        writer.write(np.full((360, 640, 3), 100 + level, np.uint8))
    writer.release()
    straight = Calibration.from_camera(GroundPlaneCamera(0.03, 310.0, 179.5, 1.3, 319.5), ImageSize(640, 360))
    seen = ClipObservations(None, None, (), 5)

    def tells(source, *_args, **_kwargs):
        if isinstance(source, StraightSource):
            return ClipCalibration(straight, seen, shows_road=True, by_motion=True)
        return ClipCalibration(straight, seen, True, True, None, Gaussian(300.0, 30.0), BENT)

    monkeypatch.setattr("fcw.self_calibration.clip.calibrate_clip", tells)
    return clip


def test_a_lens_that_turns_show_to_bend_is_saved_with_the_focal_length_of_all_together(bent_clip, capsys):
    assert main(["calibrate", str(bent_clip), "--from-clip"]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "the lens bends straight lines: the turns in the clip show that it sees about 118 degrees" in told
    assert "300 px ± 10 %; its distortion is saved with the calibration and corrected" in told
    lens = read_calibration(default_path(bent_clip)).lens
    assert lens == replace(BENT, focal_x_px=310.0, focal_y_px=310.0)


def test_marks_and_lens_count_in_a_clip_as_they_do_in_a_picture(bent_clip, monkeypatch, tmp_path):
    """A lens whose axis is aside, marks from the bumper, a clip of which only the marks tell anything."""
    monkeypatch.undo()
    size = ImageSize(640, 360)
    lens = Lens("radtan", 500.0, 500.0, 340.0, 170.0, (-0.3, 0.1, 0.0, 0.0, 0.0), size)
    camera = GroundPlaneCamera(0.04, 500.0, 170.0, 1.3, 340.0)
    way = Straightening(camera, Orientation(), lens, size)
    offset_m, sides_m = 2.0, (-1.5, 1.5, -1.0, 1.2)
    straight = [
        (camera.column_at(y, d + offset_m), camera.row_at(d + offset_m))
        for d, y in zip((4.0, 7.0, 12.0, 25.0), sides_m, strict=True)
    ]
    marks = way.to_picture(np.array(straight)).tolist()
    lens_file = tmp_path / "lens.yaml"
    lens_file.write_text(camera_info_text(replace(Calibration.from_camera(camera, size), lens=lens)))
    lines = [
        ":".join(f"{value:.3f}" for place in way.to_picture(np.array(ends)) for value in place)
        for side_m in (1.8, -1.8)
        for ends in ([(camera.column_at(side_m, d), camera.row_at(d)) for d in (7.0, 30.0)],)
    ]
    points = [
        f"{d:g}:{row:.3f}:{column:.3f}"
        for d, (column, row) in zip((4.0, 7.0, 12.0, 25.0), marks, strict=True)
    ]
    command = ["calibrate", str(bent_clip), "--from-clip", "--height", "1.3", "--lens", str(lens_file)]
    command += ["--reference-offset", "2", "--points", *points, "--lane-line", *lines]
    assert main(command) == 0
    calibration = read_calibration(default_path(bent_clip))
    assert calibration.orientation.yaw_rad == pytest.approx(0.0, abs=math.radians(0.3))
    assert calibration.reference_offset_m == 2.0
    for d, (column_px, row_px) in zip((4.0, 7.0, 12.0, 25.0), marks, strict=True):
        _, straight_row_px = calibration.straight_place(column_px, row_px)
        assert calibration.distance_at(straight_row_px) == pytest.approx(d, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--points", "6:nan"], "point 6:nan: expected finite numbers"),
        (["--points", "6:200", "-3:180"], "point -3:180: distance -3 m, expected more than 0"),
        (
            ["--points", "6:200", "--dashes", "200", "190", "185", "--dash-period", "12"],
            "--dashes: only for marks whose first distance is not known; leave out --points",
        ),
    ],
)
def test_marks_of_a_clip_are_checked_as_they_are_in_a_picture(arguments, message, bent_clip, capsys):
    assert main(["calibrate", str(bent_clip), "--from-clip", *arguments]) == 2
    assert message in " ".join(capsys.readouterr().err.split())
    assert not default_path(bent_clip).exists()


def test_exchanged_sides_are_refused_in_a_clip_too(bent_clip, monkeypatch, capsys):
    """Every distance would be wrong by a factor of two."""
    monkeypatch.undo()
    camera = GroundPlaneCamera(0.03, 500.0, 179.5, 1.3, 319.5)
    corners = ":".join(f"{camera.column_at(y, d):.2f}:{camera.row_at(d):.2f}" for d, y in BAY_M)
    command = ["calibrate", str(bent_clip), "--from-clip", "--rectangle", corners, "--rectangle-sides"]
    assert main([*command, "5x2.5"]) == 2
    assert "exchange them in --rectangle-sides" in " ".join(capsys.readouterr().err.split())
    assert not default_path(bent_clip).exists()
    assert main([*command, "2.5x5"]) == 0
    assert read_calibration(default_path(bent_clip)).distance_at(camera.row_at(20.0)) == pytest.approx(
        20.0, rel=0.05
    )


def test_marks_in_a_bent_picture_are_taken_as_they_are_and_that_is_said(bent_clip, capsys):
    assert main(["calibrate", str(bent_clip), "--from-clip", *LANES]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "the values that you gave are used as if it did not: give the lens with --lens" in told
    assert read_calibration(default_path(bent_clip)).lens is None


@pytest.mark.parametrize(("sigmas", "said"), [(1.5, False), (4.0, True)])
def test_a_horizon_that_drive_and_vehicles_tell_differently_is_said(
    sigmas, said, bent_clip, monkeypatch, capsys
):
    camera = GroundPlaneCamera(0.03, 310.0, 179.5, 1.3, 319.5)
    found = ClipCalibration(
        Calibration.from_camera(camera, ImageSize(640, 360)),
        ClipObservations(None, None, (), 5),
        shows_road=True,
        by_motion=True,
        contradiction=Contradiction(math.radians(2.7), sigmas),
    )
    monkeypatch.setattr("fcw.self_calibration.clip.calibrate_clip", lambda *_args, **_kwargs: found)
    assert main(["calibrate", str(bent_clip), "--from-clip"]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert ("the vehicles ahead give horizons 2.7 degrees apart: one of them is wrong" in told) == said


@pytest.mark.slow
def test_a_clip_that_shows_no_road_gives_a_rough_camera_and_says_so(tmp_path, capsys):
    clip = tmp_path / "night.mp4"
    writer = cv2.VideoWriter(str(clip), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (640, 360))
    for level in range(30):
        writer.write(np.full((360, 640, 3), 8 + level % 3, np.uint8))
    writer.release()
    assert main(["calibrate", str(clip), "--from-clip"]) == 0
    captured = capsys.readouterr()
    told = " ".join(captured.err.split())
    assert "nothing in this clip shows where the road lies" in told
    assert (
        "rough: this assumes a height of 1.30 ± 0.12 m (of a car) and a field of view of 66 ± 16 degrees "
        "(of any camera), and distances are as uncertain as that; give --height (metres from the road up "
        "to the lens) and --field-of-view" in told
    )
    assert "One more point helps most" not in captured.out
    assert "unbounded" in captured.out
    assert read_calibration(default_path(clip)).assumed.field_of_view_rad is not None
    assert (
        main(
            [
                "calibrate",
                str(clip),
                "--from-clip",
                "--height",
                "1.2",
                "--horizon-row",
                "180",
                "--field-of-view",
                "60",
            ]
        )
        == 0
    )
    told = " ".join(capsys.readouterr().err.split())
    assert "rough" not in told
    assert "the motion of the camera could not be used" in told


@pytest.mark.parametrize(
    ("height", "message"),
    [
        ("0", "--height 0 m: a camera behind a windscreen is 0.5 to 4 m above the road"),
        ("-1.2", "--height -1.2 m: a camera"),
        ("inf", "--height inf: expected a finite number"),
        ("nan", "--height nan: expected a finite number"),
        ("120", "did you mean 1.20 m?"),
        ("0.01", "--height 0.01 m: a camera"),
    ],
)
def test_a_height_of_no_camera_is_refused_before_the_clip_is_opened(height, message, tmp_path, capsys):
    """Its source is not even there, which would be said if it were opened."""
    assert main(["calibrate", str(tmp_path / "clip.mp4"), "--from-clip", "--height", height]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
