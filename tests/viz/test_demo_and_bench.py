"""`fcw demo` on the shipped drive against its truth, and `fcw bench` on a short one."""

import contextlib
import dataclasses
import io
import json
import statistics
from pathlib import Path

import pytest

from fcw.camera.calibration import Calibration
from fcw.evaluation.simulated import compare_with_truth
from fcw.logs.mcap_reader import DriveLog
from fcw.logs.records import FrameResult
from fcw.simulation.drive import true_calibration, write_drive
from fcw.simulation.scenario import IMAGE_SIZE, load_scenario
from fcw.simulation.truth import FrameTruth, frame_truth
from fcw.simulation.truth_file import read_truth
from fcw.simulation.world import World
from fcw_viz.benchmark import DECODE, ENCODED, FULL, PRIOR, RELAYED
from fcw_viz.cli import main
from fcw_viz.commands import review
from fcw_viz.commands.demo import demo_folder
from fcw_viz.commands.review import ReviewCommand

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


def test_the_demo_says_where_its_logs_are_and_what_it_is_worth(demo: Demo) -> None:
    assert str(demo.out / "drive.mcap") in demo.told
    assert f"fcw review {demo.out} --rerun" in demo.told
    comparison = compare_with_truth(demo.results, demo.truth)
    median = statistics.median(map(abs, comparison.lead_errors))
    assert f"off by {median:.1%} (median)" in demo.told
    assert f"{comparison.detection_rate:.1%} of {comparison.vehicles} found" in demo.told
    assert f"came at {comparison.due[0].warned_s:.2f} s" in demo.told


def test_the_demo_ends_in_the_review_of_its_drive(demo: Demo) -> None:
    assert demo.reviewed == [demo.out]


def test_the_lead_is_followed_and_its_distance_measured(demo: Demo) -> None:
    comparison = compare_with_truth(demo.results, demo.truth)
    assert comparison.frames == len(demo.truth) == 1200
    assert len(comparison.lead_errors) > 0.95 * comparison.lead_frames > 1000
    assert statistics.median(map(abs, comparison.lead_errors)) < 0.035
    assert statistics.median(map(abs, comparison.track_errors)) < 0.04


def test_vehicles_seen_from_behind_are_found(demo: Demo) -> None:
    comparison = compare_with_truth(demo.results, demo.truth)
    assert comparison.vehicles > 1500
    assert comparison.detection_rate >= 0.95
    assert comparison.false_positives_per_frame <= 0.1


def test_the_braking_lead_is_warned_of_in_time_and_oncoming_vehicles_never(demo: Demo) -> None:
    comparison = compare_with_truth(demo.results, demo.truth)
    (due,) = comparison.due
    assert due.vehicle == "cutting in"
    assert due.in_time
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


def test_the_shipped_drive_is_what_its_scenario_says(demo: Demo) -> None:
    folder, scenario = demo_folder(), load_scenario("demo")
    assert (folder / "drive.mp4").stat().st_size < LARGEST_SHIPPED_BYTES
    assert len(demo.truth) == scenario.frame_count
    camera, offset_m = scenario.camera.camera(), scenario.camera.reference_offset_m
    for state, frame in zip(World(scenario, seed=0).states(), demo.truth, strict=True):
        now = frame_truth(state, camera, IMAGE_SIZE, offset_m)
        assert [vehicle.name for vehicle in frame.vehicles] == [vehicle.name for vehicle in now.vehicles]
        distances_m = [vehicle.distance_m for vehicle in now.vehicles]
        assert [vehicle.distance_m for vehicle in frame.vehicles] == pytest.approx(distances_m, abs=1e-3)
    shipped, true = Calibration.load(folder / "drive.calibration.yaml"), true_calibration(scenario)
    for distance_m in (5.0, 20.0, 80.0):
        assert shipped.row_at(distance_m) == pytest.approx(true.row_at(distance_m), abs=1e-6)


def test_bench_reports_every_case_and_its_ratios(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_drive(dataclasses.replace(load_scenario("braking"), duration_s=1.0), tmp_path, seed=1)
    arguments = ["bench", str(tmp_path / "drive.mp4"), "--rounds", "1", "--detector-frames", "2", "--json"]
    assert main(arguments) == 0
    figures = json.loads(capsys.readouterr().out)
    assert set(figures["ms_per_frame"]) == {DECODE, RELAYED, ENCODED, PRIOR, FULL}
    assert all(value > 0 for values in figures["ms_per_frame"].values() for value in values)
    decode_ms, whole_ms = (figures["ms_per_frame"][case][0] for case in (DECODE, RELAYED))
    assert figures["rate_of_whole_job_to_decoding"][RELAYED] == pytest.approx(decode_ms / whole_ms)
    assert figures["windows_per_frame"][PRIOR] > 1000


def test_bench_refuses_no_rounds(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--rounds", "0"]) == 2
    assert "--rounds" in capsys.readouterr().err
