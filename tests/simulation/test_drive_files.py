"""The files of a simulated drive agree with each other and are what every other part reads."""

import dataclasses
import itertools

import av
import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import GroundPoint
from fcw.camera.file import read_calibration
from fcw.camera.solve import calibrate
from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog
from fcw.simulation.drive import render_drive, true_calibration, write_drive
from fcw.simulation.truth.file import read_truth
from fcw.simulation.truth.log import truth_result
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth
from fcw.simulation.world.scenario import IMAGE_SIZE, load_scenario, scenario_names
from fcw.warning.ego_speed import EgoSpeed
from fcw.warning.types import WarningLevel

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def short_demo():
    return dataclasses.replace(load_scenario("demo"), duration_s=1.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, short_demo):
    directory = tmp_path_factory.mktemp("drive")
    frames = []
    write_drive(short_demo, directory, seed=2, on_frame=lambda: frames.append(1))
    assert len(frames) == 30
    return directory


def test_two_drives_of_one_seed_are_the_same_bit_for_bit_and_of_another_are_not(short_demo):
    first, again, other = (list(itertools.islice(render_drive(short_demo, seed), 2)) for seed in (3, 3, 4))
    for (one, truth), (two, same_truth) in zip(first, again, strict=True):
        assert one.time_ns == two.time_ns
        assert truth == same_truth
        np.testing.assert_array_equal(one.image, two.image)
    assert not np.array_equal(first[0][0].image, other[0][0].image)


def test_the_files_are_there_and_nothing_else(folder):
    assert sorted(path.name for path in folder.iterdir()) == [
        "drive.calibration.yaml",
        "drive.mp4",
        "drive.speed.csv",
        "truth.csv",
        "truth.mcap",
    ]


def test_the_video_has_no_b_frames_and_a_keyframe_a_second(folder):
    with av.open(str(folder / "drive.mp4")) as container:
        stream = container.streams.video[0]
        packets = [packet for packet in container.demux(stream) if packet.size]
    assert stream.codec_context.name == "h264"
    assert [packet.pts for packet in packets] == [packet.dts for packet in packets]
    assert len(packets) == 30
    assert packets[0].is_keyframe
    assert float(stream.average_rate or 0) == 30


def test_truth_as_csv_and_as_log_agree(folder):
    truth = read_truth(folder / "truth.csv")
    log = DriveLog(folder / "truth.mcap")
    results = list(log.results())
    assert len(results) == len(truth) == 30
    for result, frame in zip(results, truth, strict=True):
        assert result.time_ns == pytest.approx(frame.time_ns, abs=1000)
        assert sorted(track.distance_m for track in result.tracks) == pytest.approx(
            [vehicle.distance_m for vehicle in frame.vehicles], abs=1e-3
        )
        assert frame.lead is not None
        assert result.lead is not None
        assert result.lead.distance_m == pytest.approx(frame.lead.distance_m, abs=1e-3)


def test_the_speed_file_has_the_own_speed_of_every_frame(folder):
    speed = EgoSpeed.read_csv(folder / "drive.speed.csv")
    for frame in read_truth(folder / "truth.csv"):
        assert speed.at(frame.time_ns) == pytest.approx(frame.ego_speed_mps, abs=1e-3)


@pytest.mark.parametrize("name", scenario_names())
def test_the_calibration_is_the_true_camera(name):
    """As near as the weak knowledge of cameras lets exact marks be."""
    scenario = load_scenario(name)
    calibration, camera = true_calibration(scenario), scenario.camera.camera()
    for distance_m in (5.0, 20.0, 80.0):
        row_px = camera.row_at(distance_m + scenario.camera.reference_offset_m)
        assert calibration.distance_at(row_px) == pytest.approx(distance_m, rel=1e-3)
    assert calibration.camera.pitch_rad == pytest.approx(camera.pitch_rad, abs=1e-3)
    assert [point.distance_m for point in calibration.points] == [6, 15, 30]


def test_the_saved_calibration_is_for_the_pictures(folder):
    assert read_calibration(folder / "drive.calibration.yaml").image_size == IMAGE_SIZE


def test_clicks_on_the_painted_marks_give_the_true_distances(short_demo):
    """The bars' middles in the first picture, to whole pixels, as somebody would click them."""
    frame, _ = next(iter(render_drive(short_demo, seed=0)))
    scenario, camera = short_demo, short_demo.camera.camera()
    offset_m = scenario.camera.reference_offset_m
    points = []
    for distance_m in scenario.road.marks_m:
        # The brightest run of rows near where somebody expects the mark, in the columns of its middle.
        expected = camera.row_at(distance_m + offset_m)
        half = round(0.3 * (expected - camera.horizon_row_px))
        rows = np.arange(round(expected) - half, round(expected) + half + 1)
        light = frame.image[rows, 620:660].mean(axis=(1, 2)).astype(float)
        bright = rows[light > (light.max() + np.median(light)) / 2]
        assert bright[-1] - bright[0] < half, "one bar"
        points.append(GroundPoint(distance_m, float(round((bright[0] + bright[-1]) / 2))))
    clicked = calibrate(tuple(points), IMAGE_SIZE, camera.height_m, offset_m, row_sigma_px=0.5)
    for distance_m in (8.0, 20.0, 30.0, 40.0):
        row_px = camera.row_at(distance_m + offset_m)
        # Two and a half sigmas of the predicted interval.
        low_m, high_m = clicked.distance_interval(row_px)
        found_m = clicked.distance_at(row_px)
        assert found_m - 2.5 * (found_m - low_m) <= distance_m <= found_m + 2.5 * (high_m - found_m)
    assert clicked.distance_at(camera.row_at(40.0 + offset_m)) == pytest.approx(40.0, rel=0.03)


def test_the_truth_log_raises_the_warning_while_it_is_due():
    def result(distance_m, in_path=True):
        vehicle = VehicleTruth(
            "a",
            distance_m,
            0,
            0,
            10.0,
            distance_m / 10,
            Box(0, 0, 9, 9),
            Box(0, 0, 9, 9),
            1.0,
            False,
            in_path,
        )
        return truth_result(0, 0, FrameTruth(0, 20.0, 0, 0, 330.0, (vehicle,)), {"a": 4})

    assert result(25.0).warning.level is WarningLevel.NONE
    assert result(24.0).warning.level is WarningLevel.WARNING
    assert result(24.0).warning.track_id == result(24.0).lead_id == 4
    assert result(24.0, in_path=False).lead_id is None


def test_a_folder_that_cannot_be_made_is_the_users_mistake(tmp_path, short_demo):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="name a folder that can be written"):
        write_drive(short_demo, tmp_path / "file")


def test_an_interrupted_rendering_leaves_no_video_behind(tmp_path, short_demo):
    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_drive(short_demo, tmp_path, on_frame=stop)
    assert list(tmp_path.iterdir()) == []
