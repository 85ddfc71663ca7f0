"""The horizon and yaw that a drive shows are the true ones, within their intervals, whatever the camera."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import cast

import cv2
import numpy as np
import pytest

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.file import default_path, read_calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import VEHICLE_WIDTH_M, Ruler
from fcw.camera.solve import calibrate
from fcw.errors import UserError
from fcw.frame import Frame, ImageSize
from fcw.self_calibration.clip import ClipCalibration, ClipObservations
from fcw.self_calibration.turning.by_turns import LensByTurns
from fcw.sources import open_source
from fcw.warning.ego_speed import EgoSpeed
from fcw_viz.calibrate_app.proposals import drive_look
from fcw_viz.calibrate_app.proposals.drive_look import DriveLook, Look, find_vehicles, find_view, look_at
from fcw_viz.page.pictures import Pictures

DEMO = Path(__file__).parents[3] / "recordings" / "demo" / "drive.mp4"
KITTI_HORIZON_ROW_PX = 172.854 + 721.538 * np.tan(np.radians(0.3))
"""Of `kitti-odometry-03`: the axis is 0.3 degrees above the direction of travel."""
KITTI_VIEW_RAD = 2 * np.arctan(1241 / 2 / 721.538)
CLIPS = {
    "udacity_test_video": (8, 593.75, 15, 512.67, 40, 454.75),
    "udacity_test_small1": (8, 592.62, 15, 511.83, 40, 454.12),
    "udacity_project_video_cut": (8, 597.88, 15, 516.50, 40, 458.38),
    "solidWhiteRight": (8, 480.38, 15, 397.83, 40, 338.88),
    "muchlisin_driving": (8, 323.00, 15, 271.67, 40, 235.00),
    "tmo_seattlestreet2": (8, 266.75, 15, 232.33, 40, 207.75),
    "tmo_countryroad": (8, 273.12, 15, 231.53, 40, 201.82),
}
"""Distances and rows of `calibrations.txt`: from vanishing points of lane lines."""


@pytest.mark.slow
def test_the_shipped_drive_shows_its_horizon_to_half_a_percent_of_the_height():
    look = look_at(Pictures(open_source(DEMO)))
    true_row_px = read_calibration(default_path(DEMO)).horizon_row_px
    assert look.horizon is not None
    assert abs(look.horizon.value - true_row_px) < min(2 * look.horizon.sigma, 0.005 * 720)
    assert f"row {look.horizon.value:.0f}" in look.words


@pytest.mark.slow
@pytest.mark.parametrize("cut_px", [100, -100])
def test_a_drive_seen_aside_shows_the_yaw(cut_px: int):
    # Without its first or last columns the picture is that of a camera whose axis lies elsewhere; the shipped
    # drive's looks straight ahead.
    look = look_at(cast(Pictures, Cropped(Pictures(open_source(DEMO)), cut_px)))
    assert look.yaw_rad is not None
    camera = read_calibration(default_path(DEMO)).camera
    true_rad = -np.arctan(cut_px / 2 / camera.focal_y_px)
    assert abs(true_rad) > np.radians(2.5)
    assert abs(look.yaw_rad.value - true_rad) < look.yaw_rad.sigma < np.radians(1.0)
    assert f"to the {'right' if cut_px > 0 else 'left'}" in look.words


def observations(
    travel_px: tuple[Gaussian, Gaussian] | None, lanes_px: tuple[Gaussian, Gaussian] | None, vehicles: int = 0
) -> ClipObservations:
    rulers = tuple(Ruler(640.0, 400.0 + number, 90.0, VEHICLE_WIDTH_M, 1.0) for number in range(vehicles))
    return ClipObservations(travel_px, lanes_px, rulers, 10)


class Cropped:
    """Pictures without so many of their first columns; below 0, of their last."""

    def __init__(self, pictures: Pictures, cut_px: int) -> None:
        self._pictures, self._cut_px, self.source, self.count = pictures, cut_px, self, pictures.count
        size = pictures.image_size
        self.image_size = ImageSize(size.width - abs(cut_px), size.height)

    def frames(self) -> Iterator[Frame]:
        columns = slice(self._cut_px, None) if self._cut_px > 0 else slice(None, self._cut_px)
        for frame in self._pictures.source.frames():
            yield replace(frame, image=np.ascontiguousarray(frame.image[:, columns]))


def test_kitti_shows_its_horizon_though_the_lens_is_another_than_assumed(data_dir: Path):
    look = look_at(Pictures(open_source(data_dir / "kitti-odometry-03" / "drive.mp4")))
    assert look.horizon is not None
    assert abs(look.horizon.value - KITTI_HORIZON_ROW_PX) < 2 * look.horizon.sigma


@pytest.mark.parametrize("clip", CLIPS)
def test_clips_show_the_horizon_of_their_lane_lines(data_dir: Path, clip: str):
    pictures = Pictures(open_source(data_dir / "clips" / f"{clip}.mp4"))
    numbers = CLIPS[clip]
    points = [GroundPoint(d, row) for d, row in zip(numbers[::2], numbers[1::2], strict=True)]
    true_row_px = calibrate(points, pictures.image_size, 1.3).horizon_row_px
    look = look_at(pictures)
    assert look.horizon is not None
    assert abs(look.horizon.value - true_row_px) < 2 * look.horizon.sigma


def test_a_picture_and_a_standing_drive_show_none_and_say_what_to_do(tmp_path: Path):
    image = np.random.default_rng(3).integers(0, 255, (180, 320, 3), np.uint8)
    for number in range(12):
        cv2.imwrite(str(tmp_path / f"{number:02}.png"), image)
    for source in (tmp_path / "00.png", tmp_path):
        look = look_at(Pictures(open_source(source)))
        assert look.horizon is None
        assert "neither its motion nor its lane lines" in look.words or "shows no motion" in look.words
        assert "drag the horizon" in look.words


def test_a_drive_whose_motion_comes_and_goes_shows_what_it_showed(data_dir: Path, tmp_path: Path):
    frames = open_source(data_dir / "kitti-odometry-03" / "drive.mp4").frames()
    pictures = [frame.image for _, frame in zip(range(60), frames, strict=False)]
    for number, image in enumerate([*pictures, *[np.zeros_like(pictures[0])] * 120]):
        cv2.imwrite(str(tmp_path / f"{number:03}.jpg"), image)
    look = look_at(Pictures(open_source(tmp_path)))
    assert look.horizon is not None
    assert abs(look.horizon.value - KITTI_HORIZON_ROW_PX) < 2 * look.horizon.sigma
    assert look.words.startswith("By the drive's motion ")


LANES = Gaussian(640.0, 5.0), Gaussian(330.0, 6.0)
FAR_LANES, VAGUE = (Gaussian(640.0, 5.0), Gaussian(480.0, 6.0)), Gaussian(330.0, 50.0)
TRAVEL = Gaussian(640.0, 3.0), Gaussian(320.0, 3.0)


@pytest.mark.parametrize(
    ("seen", "piece_s", "row_px", "words"),
    [
        (observations(TRAVEL, None), None, 320.0, "By the drive's motion alone, the horizon is at row 320"),
        (observations(TRAVEL, LANES), None, 322.0, "By the drive's motion and lane lines, the horizon"),
        (
            observations(None, LANES),
            None,
            330.0,
            "By the drive's lane lines alone, .* Does a flat road end there?",
        ),
        (observations(TRAVEL, None), (0.0, 7.0), 320.0, "This holds until 7 s: the horizon jumps there"),
        (observations(TRAVEL, None), (8.0, 40.0), 320.0, "This holds from 8 s on"),
        (observations(TRAVEL, None), (8.0, 20.0), 320.0, "This holds from 8 s to 20 s: the horizon"),
        (
            replace(observations(TRAVEL, None), parts_s=((0.0, 7.8), (8.0, 20.0))),
            (8.0, 20.0),
            320.0,
            "This holds from 8 s to 20 s: the clip is cut there.",
        ),
        (
            observations(TRAVEL, FAR_LANES),
            None,
            None,
            "motion says row 320 ± 3, its lane lines row 480 ± 6; drag",
        ),
        (
            observations(None, (TRAVEL[0], VAGUE)),
            None,
            None,
            "by its lane lines alone, it is at row 330 ± 50;",
        ),
        (
            observations(None, None),
            None,
            None,
            "neither its motion nor its lane lines show it; drag the horizon",
        ),
        (observations(None, None, vehicles=5), None, None, "use the vehicles ahead as rulers, or drag"),
    ],
)
def test_a_look_says_what_tells_the_horizon_and_how_far_to_trust_it(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    seen: ClipObservations,
    piece_s: tuple[float, float] | None,
    row_px: float | None,
    words: str,
):
    for name in ("0.png", "1.png"):
        cv2.imwrite(str(tmp_path / name), np.zeros((720, 1280, 3), np.uint8))
    calibration = Calibration.from_camera(
        GroundPlaneCamera(0.035, 1000.0, 359.5, 1.3, 639.5), ImageSize(1280, 720)
    )
    is_cut = len(seen.parts_s) > 1
    found = ClipCalibration(calibration, seen, True, seen.travel_px is not None, piece_s, is_cut=is_cut)
    monkeypatch.setattr(drive_look, "calibrate_clip", lambda *_args, **_kwargs: found)
    look = look_at(Pictures(open_source(tmp_path)))
    assert re.search(words, look.words)
    assert (look.horizon is None) == (row_px is None)
    if look.horizon is not None:
        assert look.horizon.value == pytest.approx(row_px, abs=0.1)


def test_a_car_that_stands_for_most_of_the_look_gives_no_scale(tmp_path: Path, data_dir: Path):
    first = next(iter(open_source(data_dir / "kitti-odometry-03" / "drive.mp4").frames())).image
    for number in range(60):
        cv2.imwrite(str(tmp_path / f"{number:02}.png"), first)
    assert look_at(Pictures(open_source(tmp_path))).scale_per_mps is None


def test_turns_show_the_field_of_view(data_dir: Path):
    view = find_view(Pictures(open_source(data_dir / "kitti-odometry-03" / "drive.mp4"))).view_rad
    assert view is not None
    assert abs(view.value - KITTI_VIEW_RAD) < view.sigma < np.radians(8)


class Cut(Cropped):
    """Half a minute of a drive, the first three seconds of it upside down."""

    def __init__(self, pictures: Pictures) -> None:
        super().__init__(pictures, 0)
        self.image_size = pictures.image_size

    def frames(self) -> Iterator[Frame]:
        for frame in self._pictures.source.frames():
            upside_down = frame.time_ns < 3e9
            if frame.time_ns > 30e9:
                return
            yield replace(frame, image=np.ascontiguousarray(frame.image[::-1])) if upside_down else frame


def test_of_a_clip_that_is_cut_the_longest_part_is_searched(data_dir: Path, monkeypatch: pytest.MonkeyPatch):
    cut = cast(Pictures, Cut(Pictures(open_source(data_dir / "kitti-odometry-03" / "drive.mp4"))))
    looked_at: list[tuple[float, float]] = []

    def nine_vehicles(_source: object, _detector: object, piece_s: tuple[float, float], _going_on: object):
        looked_at.append(piece_s)
        return observations(None, None, vehicles=9).rulers, 10

    monkeypatch.setattr(drive_look, "vehicles_of", nine_vehicles)
    view, vehicles = find_view(cut), find_vehicles(cut)
    assert view.view_rad is not None
    assert abs(view.view_rad.value - KITTI_VIEW_RAD) < view.view_rad.sigma
    assert view.words.endswith(" The clip is cut: this is from its longest part, from 3 s to 30 s.")
    assert vehicles.words.endswith(" The clip is cut: this is from its longest part, from 3 s to 20 s.")
    ((begin_s, end_s),) = looked_at
    assert 3.0 < begin_s < 3.5 < 19.5 < end_s <= 20.0


def test_a_straight_drive_shows_no_field_of_view_and_says_so(data_dir: Path):
    look = find_view(Pictures(open_source(data_dir / "clips" / "udacity_test_video.mp4")))
    assert look.view_rad is None
    assert "it turns too little" in look.words


def test_of_a_lens_that_bends_lines_no_field_of_view_is_offered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(drive_look, "lens_by_turns", lambda _: LensByTurns(Gaussian(800.0, 80.0), -0.3))
    cv2.imwrite(str(tmp_path / "one.png"), np.zeros((360, 640, 3), np.uint8))
    look = find_view(Pictures(open_source(tmp_path / "one.png")))
    assert look.view_rad is None
    assert "bends straight lines (its focal length is 800 px ± 80): import it" in look.words


def test_a_look_is_done_once_and_its_listeners_are_told(tmp_path: Path):
    cv2.imwrite(str(tmp_path / "one.png"), np.zeros((90, 160, 3), np.uint8))
    look = DriveLook(Pictures(open_source(tmp_path / "one.png")))
    heard: list[bool] = []
    forget = look.listen(lambda: heard.append(look.running))
    look.start()
    look.wait()
    assert heard == [True, False]
    assert look.look is not None
    look.start()
    forget()
    assert heard == [True, False]


def test_a_look_tells_how_far_it_has_come(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def look_thrice(_: Pictures, going_on: Callable[[], bool]) -> Look:
        assert all(going_on() for _ in range(3))
        return Look(None, "")

    monkeypatch.setattr(drive_look, "TOLD_EVERY_S", 0.0)
    cv2.imwrite(str(tmp_path / "one.png"), np.zeros((90, 160, 3), np.uint8))
    look = DriveLook(Pictures(open_source(tmp_path / "one.png")), look_thrice)
    counts: list[int] = []
    look.listen(lambda: counts.append(look.picture_count))
    look.start()
    look.wait()
    assert counts == [0, 1, 2, 3, 3]


def test_a_file_of_speeds_gives_the_mean_over_the_pictures_that_were_looked_at():
    look = Look(None, "", 100.0, times_ns=tuple(range(2_000_000_000, 4_000_000_001, 100_000_000)))
    ramp = EgoSpeed((0.0, 10.0), (0.0, 20.0))
    assert look.mean_speed_mps(ramp, "drive.csv") == pytest.approx(6.0)
    # A receiver knows nothing of the drive's clock, which begins at 1.5 s.
    track = replace(ramp, from_first_frame=True)
    assert replace(look, first_ns=1_500_000_000).mean_speed_mps(track, "drive.gpx") == pytest.approx(3.0)
    with pytest.raises(UserError, match=r"drive\.gpx: it has no speed for the seconds"):
        look.mean_speed_mps(EgoSpeed((10.0, 20.0), (5.0, 5.0)), "drive.gpx")
