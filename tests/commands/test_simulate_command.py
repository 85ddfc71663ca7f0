"""`fcw simulate` as a person uses it."""

from pathlib import Path

import pytest

from fcw.camera.file import read_calibration
from fcw.simulation.truth.file import write_truth
from fcw_viz.cli import main

SCENARIO = """
description: A third of a second behind a standing car.
duration_s: 0.3
ego: {speed_kmh: 20}
road: {marks_m: [5, 12, 33]}
vehicles:
  - {name: ahead, gap_m: 20}
"""


@pytest.mark.slow
def test_it_writes_the_drive_and_says_where_the_marks_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario, out = tmp_path / "mine.yaml", tmp_path / "out"
    scenario.write_text(SCENARIO)
    assert main(["simulate", str(scenario), "--out", str(out), "--seed", "3"]) == 0
    told = capsys.readouterr()
    assert "5, 12, 33 m from the front bumper" in told.out
    assert str(out / "drive.mp4") in told.out
    assert told.err == ""
    assert (out / "truth.mcap").is_file()
    points = read_calibration(out / "drive.calibration.yaml").points
    assert [point.distance_m for point in points] == [5, 12, 33]


@pytest.mark.slow
def test_an_earlier_simulated_drive_is_replaced_also_one_without_a_log(tmp_path: Path) -> None:
    scenario, out = tmp_path / "mine.yaml", tmp_path / "out"
    scenario.write_text(SCENARIO)
    simulate = ["simulate", str(scenario), "--out", str(out)]
    assert main([*simulate, "--seed", "3"]) == 0
    first = (out / "drive.mp4").read_bytes()
    (out / "truth.mcap").unlink()
    assert main([*simulate, "--seed", "4"]) == 0
    assert (out / "drive.mp4").read_bytes() != first
    assert (out / "truth.mcap").is_file()


@pytest.mark.parametrize("name", ["drive.mp4", "drive.calibration.yaml", "truth.csv", "truth.mcap"])
def test_a_file_that_is_no_simulated_drives_is_refused_and_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    (tmp_path / name).write_text("mine")
    assert main(["simulate", "demo", "--out", str(tmp_path)]) == 2
    assert f"{name}: would be replaced, and is of no drive that `fcw simulate`" in capsys.readouterr().err
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [(name, "mine")]


def test_the_scenario_is_not_replaced_by_the_drives_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario = tmp_path / "drive.calibration.yaml"
    scenario.write_text(SCENARIO)
    write_truth(tmp_path / "truth.csv", [])
    assert main(["simulate", str(scenario), "--out", str(tmp_path)]) == 2
    assert "this is the scenario, and would be overwritten" in capsys.readouterr().err
    assert scenario.read_text() == SCENARIO


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["storm"], "scenario storm: cannot be read"),
        (["demo", "--seed", "-1"], "--seed -1: expected a whole number of at least 0"),
    ],
)
def test_mistakes_exit_with_2_and_one_message(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert main(["simulate", *arguments, "--out", str(tmp_path / "out")]) == 2
    told = capsys.readouterr()
    assert message in told.err
    assert told.out == ""
    assert not (tmp_path / "out").exists()
