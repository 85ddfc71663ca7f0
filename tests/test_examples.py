"""The examples run as they stand, with the library alone."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from running.demo_cut import cut_demo

from fcw.sources import open_source

ROOT = Path(__file__).parents[1]
FIRST_S, SECONDS = 26, 12
"""Of the shipped drive: its lead brakes, and a warning is due at 32.23 s."""
RUN = """
import json, runpy, sys
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
json.dump(sorted(sys.modules), sys.stderr)
"""


@pytest.fixture(scope="module")
def examples(tmp_path_factory) -> Path:
    """The examples, beside a drive of twelve seconds instead of forty."""
    root = tmp_path_factory.mktemp("checkout")
    cut_demo(root / "recordings" / "demo", FIRST_S, SECONDS)
    return Path(shutil.copytree(ROOT / "examples", root / "examples"))


def run(examples: Path, name: str, *arguments: object, code: str = "") -> subprocess.CompletedProcess[str]:
    """An example as a person runs it; by `code` where that is given."""
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    program = ["-c", code] if code else []
    done = subprocess.run(
        [sys.executable, *program, str(examples / f"{name}.py"), *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": path},
    )
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def first(tmp_path_factory, examples) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """The folder that the first example writes, and what it says."""
    out = tmp_path_factory.mktemp("examples") / "out"
    return out, run(examples, "01_run_a_drive", out, code=RUN)


@pytest.mark.slow
def test_a_drive_is_run_and_read_back_without_the_application(first):
    out, done = first
    packages = {module.split(".")[0] for module in json.loads(done.stderr)}
    assert "fcw" in packages
    assert packages.isdisjoint({"fcw_viz", "viser", "rerun", "rich", "tyro"})

    summary = json.loads((out / "summary.json").read_text())
    counts, *warnings = done.stdout.splitlines()
    assert counts == f"{summary['frames']} frames, a lead vehicle in {summary['frames_with_lead']}"
    # A line for each change of level; an event of the summary lasts from the first of them to the last.
    changes = [re.fullmatch(r"(.+) s: (\w+) about vehicle (\d+) \(.+\)", line) for line in warnings]
    assert summary["warnings"]
    for span in summary["warnings"]:
        within = [
            change[2]
            for change in changes
            if change
            and span["start_s"] - 0.01 <= float(change[1]) <= span["end_s"]
            and int(change[3]) == span["track_id"]
        ]
        assert span["level"] in within
    assert all(changes)
    assert sorted(path.name for path in out.iterdir()) == ["drive.mcap", "summary.json"]


def test_a_calibration_is_asked_for_rows_and_intervals(examples):
    lines = run(examples, "02_calibrate_and_ask").stdout.splitlines()
    # The axis is at row 359.5 and looks 1.7 degrees down, f_y is 1000; the rows are given to 0.1.
    assert float(lines[0].removeprefix("horizon at row ")) == pytest.approx(359.5 - 1000 * 0.02968, abs=0.5)
    assert len(lines) == 6


@pytest.mark.slow
def test_a_detector_of_ones_own_runs_the_drive(examples, first, tmp_path):
    told = run(examples, "03_your_own_detector", first[0], tmp_path / "out").stdout
    assert re.fullmatch(rf"{30 * SECONDS} frames, \d+ warnings\n", told)


@pytest.mark.slow
def test_a_policy_of_ones_own_warns_of_the_braking_lead(examples, tmp_path):
    told = run(examples, "04_your_own_policy", tmp_path / "out").stdout.splitlines()
    starts = [float(line.split()[0]) for line in told]
    assert any(28 < FIRST_S + start < 34 for start in starts)


@pytest.mark.slow
def test_a_log_is_read_into_pandas(examples, first):
    told = run(examples, "05_a_log_in_pandas", first[0]).stdout
    assert "(10, 20]" in told
    assert "median" in told


@pytest.mark.slow
def test_the_worst_moment_becomes_a_video(examples, first, tmp_path):
    video = tmp_path / "worst.mp4"
    told = run(examples, "06_an_overlay_video", first[0], video).stdout
    assert "around warning" in told
    source = open_source(video)
    assert source.frame_count is not None
    assert 280 <= source.frame_count <= 302  # ten seconds


@pytest.mark.slow
def test_a_simulated_danger_is_warned_of(examples, tmp_path):
    told = run(examples, "07_a_simulated_danger", tmp_path / "out").stdout.splitlines()
    assert re.fullmatch(r"\d+% of \d+ vehicles found", told[0])
    assert re.fullmatch(r"lead: a warning was due at \S+ s and came at [\d.]+", told[1])


def test_the_papers_numbers_stand_beside_those_of_its_equations(examples):
    told = run(examples, "08_the_papers_tables").stdout
    assert "ahead of the camera: pitch 1.1036 rad, f 260.9 px, axis at row 733.1" in told  # solved by hand
    assert [float(row) for row in re.findall(r"m taped, (\S+) m by eq. 3", told)] == [5.79, 6.79, 8.86]
    assert len(re.findall(r"row \d+ in the paper, \d+ by eq. 4", told)) == 3
    assert len(re.findall(r"off in the paper; one pixel is", told)) == 6
