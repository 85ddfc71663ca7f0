"""Distances against labels: what counts, how errors are weighted, and what is honest."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from fcw.errors import UserError
from fcw.evaluation.distance.cues import Cue
from fcw.evaluation.distance.kitti import (
    DistanceEvaluation,
    DistanceSample,
    detections_of,
    evaluate_distance,
    range_errors,
    track_weights,
    tracker_settings,
    weighted_quantile,
)
from fcw.evaluation.distance.kitti_tracking import read_own_motion, read_sequence, sequence_names
from fcw.evaluation.distance.report import write_report
from fcw.evaluation.distance.simulation import simulate_coverage
from fcw.evaluation.distance.tusimple_velocity import evaluate_single_boxes
from fcw.tracking.range.model import RangeModel
from fcw_viz.commands.evaluate.distance import print_tables

FOCAL_PX, AXIS_ROW_PX, AXIS_COLUMN_PX = 700.0, 180.0, 620.0
LABEL = (
    "{frame} {track} {kind} 0 {occluded} 0.0 {left} {top} {right} {bottom} "
    "1.5 1.7 4.0 {x} 1.65 {z} {rotation}\n"
)


def label(frame, distance_m, track=1, x=0.0, rotation=-math.pi / 2, occluded=0, kind="Car"):
    """A car whose rear is at a distance; its box is that of the rear."""
    half_px, below_px = FOCAL_PX * 0.85 / distance_m, FOCAL_PX * 1.65 / distance_m
    center_px = AXIS_COLUMN_PX + FOCAL_PX * x / distance_m
    return LABEL.format(
        frame=frame,
        track=track,
        kind=kind,
        occluded=occluded,
        left=center_px - half_px,
        right=center_px + half_px,
        bottom=AXIS_ROW_PX + below_px,
        top=AXIS_ROW_PX + below_px * (1 - 1.5 / 1.65),
        x=x,
        z=distance_m + 2.0,
        rotation=rotation,
    )


def write_folder(folder: Path, lines: str, frames: int) -> Path:
    """A folder as KITTI tracking's, of one sequence driven at 10 m/s straight on."""
    for name in ("label_02", "calib", "poses"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / "label_02" / "0000.txt").write_text(lines)
    projection = f"{FOCAL_PX} 0 {AXIS_COLUMN_PX} 0 0 {FOCAL_PX} {AXIS_ROW_PX} 0 0 0 1 0"
    (folder / "calib" / "0000.txt").write_text(f"P0: {projection}\nP2: {projection}\n")
    poses = "".join(f"1 0 0 0 0 1 0 0 0 0 1 {k}\n" for k in range(frames))
    (folder / "poses" / "0000.txt").write_text(poses)
    return folder


@pytest.fixture
def approach(tmp_path: Path) -> Path:
    """A car followed from 40 to 25 m, closing at 5 m/s, and one beside the road."""
    lines = "".join(label(k, 40 - 0.5 * k) + label(k, 30, track=2, x=6.0) for k in range(31))
    return write_folder(tmp_path, lines, 31)


def test_the_rear_of_a_vehicle_that_drives_ahead_is_its_near_face(approach: Path) -> None:
    sequence = read_sequence(approach, "0000")
    ahead, beside = sequence.frames[0]
    assert ahead.rear_m == pytest.approx(40.0)
    assert (ahead.heading_rad, ahead.is_measured) == (pytest.approx(0.0), True)
    assert (beside.lateral_m, beside.is_measured) == (pytest.approx(-6.0), False)
    assert sequence.ground_row_px(30.0) == pytest.approx(AXIS_ROW_PX + FOCAL_PX * 1.65 / 30)


@pytest.mark.parametrize(
    "changes",
    [
        {"occluded": 1},
        {"rotation": math.pi / 2},
        {"rotation": 0.0},
        {"distance_m": 90.0},
        {"distance_m": 3.5},
    ],
)
def test_hidden_oncoming_crossing_and_too_near_or_far_vehicles_do_not_count(tmp_path, changes):
    line = label(0, **({"distance_m": 20.0} | changes))
    (vehicle,) = read_sequence(write_folder(tmp_path, line, 2), "0000").frames[0]
    assert not vehicle.is_measured


def test_own_speed_and_yaw_rate_come_from_the_poses(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, label(0, 20.0), 2)
    turn = 0.02  # rad a frame, to the left
    poses = [
        f"{math.cos(k * turn)} 0 {-math.sin(k * turn)} 0 0 1 0 0 "
        f"{math.sin(k * turn)} 0 {math.cos(k * turn)} {1.5 * k}\n"
        for k in range(10)
    ]
    (folder / "poses" / "0000.txt").write_text("".join(poses))
    speed_mps, yaw_rate_radps = read_own_motion(folder, "0000")
    assert speed_mps == pytest.approx(15.0)
    assert yaw_rate_radps == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("label_02/0000.txt", "0 1 Car 0 0\n", r"label_02/0000.txt, line 1: expected 17 fields \(5 found\)"),
        ("label_02/0000.txt", "a" + " 0" * 16, "expected a KITTI tracking label"),
        ("calib/0000.txt", "P0: 1\n", "no line P2"),
        ("calib/0000.txt", "P2:" + " 0" * 12, "line 1: expected a focal length and a scale above 0"),
        ("poses/0000.txt", "1 0 0\n", "line 1: expected 12 fields"),
    ],
)
def test_a_file_that_is_not_as_expected_is_named_with_its_line(approach, file, text, message):
    (approach / file).write_text(text)
    with pytest.raises(UserError, match=message):
        evaluate_distance(approach, ["0000"], 2.0, 0)


def test_a_folder_without_labels_and_a_sequence_that_is_not_there_are_named(approach, tmp_path):
    with pytest.raises(UserError, match="no KITTI tracking labels"):
        sequence_names(tmp_path / "calib")
    with pytest.raises(UserError, match=r"0007.txt: no such sequence; expected one of 0000"):
        sequence_names(approach, ["0007"])


def test_a_sequence_that_is_named_twice_counts_once(approach):
    assert sequence_names(approach, ["0000", "0000"]) == ("0000",)


def test_noise_moves_edges_but_not_beyond_the_border(approach: Path) -> None:
    sequence = read_sequence(approach, "0000")
    rng = np.random.default_rng(0)
    edges = np.array(
        [
            (d.box.x, d.box.y, d.box.right, d.box.bottom)
            for _ in range(400)
            for d in detections_of(sequence.frames[0][:1], sequence.image_size, 2.0, rng)
        ]
    )
    assert edges.std(axis=0) == pytest.approx([2.0, 2.0, 2.0, 3.0], rel=0.15)
    (exact,) = detections_of(sequence.frames[0][:1], sequence.image_size, 0.0, rng)
    assert exact.box == sequence.frames[0][0].box


def test_an_approach_is_measured_well_and_the_same_seed_gives_the_same_result(approach: Path) -> None:
    result = evaluate_distance(approach, ["0000"], 2.0, seed=3)
    assert result == evaluate_distance(approach, ["0000"], 2.0, seed=3)
    assert result != evaluate_distance(approach, ["0000"], 2.0, seed=4)
    assert result.measured == 31
    assert {sample.track for sample in result.samples} == {1}
    assert all(s.true_closing_mps == pytest.approx(5.0) for s in result.samples)
    assert result.errors()["all"].median < 0.1
    assert result.closing_speed_mae_mps() < 2.5


def test_where_there_is_no_sample_a_dash_is_printed(
    approach: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    print_tables(replace(evaluate_distance(approach, ["0000"], 2.0, seed=3), samples=()))
    said = capsys.readouterr().out
    assert "nan" not in said
    assert len(re.findall(r"^ *tracker: median( +-){5} *$", said, re.MULTILINE)) == 1


@pytest.mark.parametrize("cue", get_args(Cue))
def test_each_cue_can_be_left_out_and_its_absence_is_felt(approach: Path, cue) -> None:
    whole = evaluate_distance(approach, ["0000"], 2.0, seed=3)
    without = evaluate_distance(approach, ["0000"], 2.0, seed=3, without=[cue])
    assert without.measured == whole.measured
    assert len(without.samples) > 20
    assert without.samples != whole.samples
    # The boxes are the same; only the tracker does without.
    frames = {sample.frame: sample.row_m for sample in whole.samples}
    assert all(sample.row_m == frames.get(sample.frame, sample.row_m) for sample in without.samples)


def test_without_any_belief_in_sizes_the_interval_is_wider(approach: Path) -> None:
    def width_of_the_interval(without):
        samples = evaluate_distance(approach, ["0000"], 2.0, seed=3, without=without).samples
        return np.median([math.log(sample.high_m / sample.low_m) for sample in samples])

    assert width_of_the_interval(["width"]) > width_of_the_interval([])
    assert width_of_the_interval(["row"]) > width_of_the_interval([])


def test_every_track_weighs_as_much_as_any_other() -> None:
    tracks = np.array([0] * 97 + [1] * 2 + [2])
    weights = track_weights(tracks)
    assert weights.sum() == pytest.approx(1.0)
    assert [weights[tracks == k].sum() for k in range(3)] == pytest.approx([1 / 3] * 3)
    # Two of three tracks are off by a half; 97 of the 100 samples are exact.
    errors = range_errors(np.where(tracks == 0, 0.0, 0.5), tracks, seed=0)
    assert (errors.n, errors.tracks, errors.median, errors.mean) == (100, 3, 0.5, pytest.approx(1 / 3))
    assert errors.median_low == 0.0


def test_quantiles_follow_the_weights() -> None:
    values, weights = np.array([3.0, 1.0, 2.0]), np.array([0.1, 0.7, 0.2])
    assert [weighted_quantile(values, weights, part) for part in (0.5, 0.8, 0.95)] == [1.0, 2.0, 3.0]


def sample(true_m, low_m, high_m, track=1, frame=0):
    return DistanceSample("0000", frame, track, true_m, true_m, low_m, high_m, 5.0, 5.0, 2.0, true_m, true_m)


def test_coverage_counts_the_truths_inside() -> None:
    samples = (sample(10, 9, 11), sample(10, 10.5, 11), sample(20, 19, 21, track=2))
    part, low, high = DistanceEvaluation(samples, (), 3, 2.0, 0).coverage()
    assert part == pytest.approx(0.75)
    assert (low, high) == (0.5, 1.0)


@pytest.mark.slow
def test_intervals_of_simulated_tracks_hold_the_truth_two_times_in_three() -> None:
    coverage = simulate_coverage(150, 0, tracker_settings(2.0, at_tyres=True), 2.0)
    assert coverage.tracks == 150
    # 68 % for a perfect filter; 150 tracks scatter by 3.8 %.
    assert 0.57 <= coverage.part <= 0.79


def test_a_report_shows_the_time_to_collision_with_its_warning(tmp_path: Path) -> None:
    samples = tuple(sample(30 - k, 29 - k, 31 - k, frame=k) for k in range(20))
    paths = write_report(DistanceEvaluation(samples, (("0000", 12, 1),), 20, 2.0, 0), tmp_path)
    assert {path.name for path in paths} == {"error.svg", "coverage.svg", "ttc-0000-1.svg"}
    chart = (tmp_path / "ttc-0000-1.svg").read_text()
    assert chart.count("#f6c7c7") == 1
    assert chart.startswith("<svg")


def test_a_file_that_is_not_tusimples_is_named(tmp_path: Path) -> None:
    path = tmp_path / "gt.json"
    path.write_text('[{"bbox": 1}]')
    with pytest.raises(UserError, match=r"gt.json: not as the TuSimple velocity challenge writes"):
        evaluate_single_boxes(path, 0)
    with pytest.raises(UserError, match="cannot be read"):
        evaluate_single_boxes(tmp_path / "none.json", 0)


def test_kitti_has_the_vehicles_that_are_known(data_dir: Path) -> None:
    folder = data_dir / "kitti-tracking"
    sequences = [read_sequence(folder, name) for name in sequence_names(folder)]
    measured = [
        (sequence.name, vehicle.track_id)
        for sequence in sequences
        for vehicles in sequence.frames
        for vehicle in vehicles
        if vehicle.is_measured
    ]
    assert (len(measured), len(set(measured))) == (1861, 18)


def test_kitti_is_measured_better_than_by_row_or_width_alone(data_dir: Path) -> None:
    # Rows alone take KITTI's calibration for exact, which it is: here the tracker is told so too.
    folder = data_dir / "kitti-tracking"
    exact = RangeModel(calibration_pitch_sigma_rad=0.0)
    result = evaluate_distance(folder, sequence_names(folder), 2.0, seed=0, model=exact)
    assert len(result.samples) > 1800
    tracker, row, width = (result.errors(m) for m in ("estimated_m", "row_m", "width_m"))
    for name in tracker:
        assert tracker[name].median < row[name].median
        assert tracker[name].median < width[name].median
    assert tracker["all"].median < 0.05


def test_single_boxes_of_tusimple_are_measured_better_than_by_row_or_width_alone(data_dir: Path) -> None:
    errors = evaluate_single_boxes(data_dir / "tusimple-velocity" / "gt.json", 0).errors
    assert errors["tracker"].n > 80
    assert errors["tracker"].median < min(errors["row"].median, errors["width"].median)
