"""`fcw demo` on the shipped drive against its truth."""

import contextlib
import dataclasses
import io
import json
import os
import statistics
from pathlib import Path

import pytest
from running.programs import start_program

from fcw.camera.file import read_calibration
from fcw.evaluation.simulated import compare_with_truth
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.records import FrameResult
from fcw.simulation.drive import true_calibration
from fcw.simulation.truth.file import read_truth
from fcw.simulation.truth.truth import FrameTruth, frame_truth
from fcw.simulation.world.scenario import IMAGE_SIZE, load_scenario
from fcw.simulation.world.world import World
from fcw_viz.cli import main
from fcw_viz.commands.demo import demo_folder
from fcw_viz.commands.review import command as review
from fcw_viz.commands.review.options import ReviewCommand

LARGEST_SHIPPED_BYTES = 8_000_000


@dataclasses.dataclass(frozen=True)
class Demo:
    out: Path
    told: str
    reviewed: list[Path]
    results: list[FrameResult]
    truth: list[FrameTruth]


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Demo:
    """One run of the whole demo."""
    out = tmp_path_factory.mktemp("demo") / "out"
    reviewed: list[Path] = []

    def note_review(command: ReviewCommand) -> int:
        reviewed.append(command.path)
        return 0

    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(io.StringIO()) as told:
        patch.setattr(review, "run_review", note_review)  # it serves until Ctrl-C
        assert main(["demo", "--out", str(out)]) == 0
    results = list(DriveLog(out / "drive.mcap").results())
    return Demo(out, told.getvalue(), reviewed, results, read_truth(demo_folder() / "truth.csv"))


@pytest.mark.slow
def test_the_demo_says_where_its_logs_are_and_how_accurate_they_are(demo: Demo) -> None:
    assert str(demo.out / "drive.mcap") in demo.told
    assert f"fcw review {demo.out} --rerun" in demo.told
    comparison = compare_with_truth(demo.results, demo.truth)
    median = statistics.median(map(abs, comparison.lead_errors))
    assert f"off by {median:.1%} (median)" in demo.told
    assert f"{comparison.detection_rate:.1%} of {comparison.vehicles} found" in demo.told
    assert f"came at {comparison.due[0].warned_s:.2f} s" in demo.told


@pytest.mark.slow
def test_the_demo_ends_in_the_review_of_its_drive(demo: Demo) -> None:
    assert demo.reviewed == [demo.out]


@pytest.mark.slow
def test_the_lead_is_followed_and_its_distance_measured(demo: Demo) -> None:
    comparison = compare_with_truth(demo.results, demo.truth)
    assert comparison.frames == len(demo.truth) == 1200
    assert len(comparison.lead_errors) > 0.95 * comparison.lead_frames > 1000
    # As on KITTI tracking, whose labelled boxes are off by 4.3 % (docs/figures/distance.md): the net's are
    # wide here.
    assert statistics.median(map(abs, comparison.lead_errors)) < 0.045
    assert statistics.median(map(abs, comparison.track_errors)) < 0.05


@pytest.mark.slow
def test_the_trees_whose_boxes_are_wider_measure_the_shipped_drive_too(tmp_path: Path) -> None:
    """Compiled for any processor, so that all round alike: by that the lead is off by 3.2 to 4.1 %.

    numba reads what it is told once, so this needs a process of its own.
    """
    folder = demo_folder()
    program = start_program(
        "run", folder / "drive.mp4", "--detector", "acf", "--ego-speed", folder / "drive.speed.csv",
        "--out", tmp_path / "out", env=os.environ | {"NUMBA_CPU_NAME": "generic"},
    )  # fmt: skip
    _, told = program.communicate()
    assert program.returncode == 0, told
    results = list(DriveLog(tmp_path / "out" / "drive.mcap").results())
    comparison = compare_with_truth(results, read_truth(folder / "truth.csv"))
    assert statistics.median(map(abs, comparison.lead_errors)) < 0.035
    assert statistics.median(map(abs, comparison.track_errors)) < 0.04


@pytest.mark.slow
def test_vehicles_seen_from_behind_are_found(demo: Demo) -> None:
    comparison = compare_with_truth(demo.results, demo.truth)
    assert comparison.vehicles > 1500
    assert comparison.detection_rate >= 0.95
    assert comparison.false_positives_per_frame <= 0.1


@pytest.mark.slow
def test_the_braking_lead_is_warned_of_in_time_and_oncoming_vehicles_never(demo: Demo) -> None:
    comparison = compare_with_truth(demo.results, demo.truth)
    (due,) = comparison.due
    assert due.vehicle == "cutting in"
    assert due.in_window
    assert {vehicle.name for frame in demo.truth for vehicle in frame.vehicles if vehicle.oncoming}
    assert comparison.warnings_of_oncoming == 0
    assert comparison.needless == ()
    (first, *others) = [
        warning
        for warning in json.loads((demo.out / "summary.json").read_text())["warnings"]
        if warning["level"] == "warning"
    ]
    assert first["start_s"] == pytest.approx(due.warned_s, abs=0.01)
    assert others == []


@pytest.mark.slow
def test_the_shipped_drive_is_what_its_scenario_says() -> None:
    folder, scenario = demo_folder(), load_scenario("demo")
    truth = read_truth(folder / "truth.csv")
    assert (folder / "drive.mp4").stat().st_size < LARGEST_SHIPPED_BYTES
    assert len(truth) == scenario.frame_count
    camera, offset_m = scenario.camera.camera(), scenario.camera.reference_offset_m
    states = list(zip(World(scenario, seed=0).states(), truth, strict=True))
    for state, frame in states[::5]:  # what is hidden by what takes its time
        now = frame_truth(state, camera, IMAGE_SIZE, offset_m)
        assert [vehicle.name for vehicle in frame.vehicles] == [vehicle.name for vehicle in now.vehicles]
        distances_m = [vehicle.distance_m for vehicle in now.vehicles]
        assert [vehicle.distance_m for vehicle in frame.vehicles] == pytest.approx(distances_m, abs=1e-3)
    shipped, true = read_calibration(folder / "drive.calibration.yaml"), true_calibration(scenario)
    for distance_m in (5.0, 20.0, 80.0):
        assert shipped.row_at(distance_m) == pytest.approx(true.row_at(distance_m), abs=0.01)
