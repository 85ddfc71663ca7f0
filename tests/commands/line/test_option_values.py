"""Values on the command line: one message for what is none, whichever command takes it."""

import pytest

from fcw_viz.cli import RUNNERS, main
from fcw_viz.commands.export import ExportCommand

EXPORT = ["export", "x", "--format", "csv", "--out", "o"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "x.mp4", "--frame-rate", "22,5"], "--frame-rate 22,5: expected a number with a point: 22.5"),
        (["calibrate", "--speed=-1,2"], "--speed -1,2: expected a number with a point: -1.2"),
        (
            ["train", "--data", "d", "--out", "o", "--score-threshold", "inf"],
            "--score-threshold inf: expected",
        ),
        (
            ["batch", "x.mp4", "--out", "o", "--piece-minutes", "nan"],
            "--piece-minutes nan: expected a finite",
        ),
        (["evaluate", "motion", "x", "--frame-rate", "ten"], "--frame-rate ten: expected a finite number"),
        (["batch", "x", "--out", "o", "--workers", "two"], "--workers two: expected a whole number"),
        (["review", "x", "--port", "80x"], "--port 80x: expected a whole number"),
        (["train", "--data", "d", "--out", "o", "--seed", "1.5"], "--seed 1.5: expected a whole number"),
        ([*EXPORT, "--between", "1"], "--between 1: expected two numbers"),
        ([*EXPORT, "--between", "1", "2", "3"], "--between 1 2 3: expected two numbers"),
        ([*EXPORT, "--between", "1", "b"], "--between b: expected a finite number"),
        (
            ["calibrate", "--export", "camera_info"],
            "--export camera_info: expected camera_info or kalibr, and",
        ),
        (["calibrate", "--export", "ros", "x.yaml"], "--export ros x.yaml: expected camera_info or kalibr"),
        (["run", "x.mp4", "--out", ""], '--out "": expected a file or folder'),
        (["calibrate", "--export", "kalibr", ""], '--export kalibr "": expected a file or folder'),
        (
            ["train", "--data", "a", "--data=b", "--out", "m.npz"],
            "--data: given 2 times; give it once, with all",
        ),
        (["calibrate", "--export", "kalibr", "a", "--export", "kalibr", "b"], "--export: given 2 times"),
        (["evaluate", "detection", "l", "--only", "a=1", "--only", "b=1"], "--only: given 2 times"),
        (["train", "--data", "nowhere", "--out", "", "--out", "m.npz"], "--data nowhere: no such folder"),
        (["train", "--data", "a", "--out", "m.npz", "--seed", "-1"], "--seed -1: expected a whole number"),
        (
            ["export", "x", "--format", "csv", "--out", "-"],
            "--out -: standard input and output are not supported",
        ),
        (
            ["evaluate", "detection", "l", "--images", "i", "--calibration", "c", "--at-fppi", "x"],
            "--at-fppi x: expected a finite number",
        ),
    ],
)
def test_what_is_no_value_of_its_option_is_told_in_one_line_that_names_the_option(arguments, message, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""


@pytest.mark.parametrize("between", [[], ["--between", "1.5", "4"]])
def test_pairs_and_numbers_are_read(between, monkeypatch):
    read = []
    monkeypatch.setitem(RUNNERS, ExportCommand, lambda command: read.append(command) or 0)
    assert main([*EXPORT, "--every", "3", *between]) == 0
    assert (read[0].every, read[0].between) == (3, (1.5, 4.0) if between else None)


@pytest.mark.parametrize(
    ("command", "mend"),
    [
        (
            "run",
            "`fcw batch` runs several, each for itself, and `fcw run FOLDER` the videos of a folder as one",
        ),
        ("calibrate", "calibrate with one of them"),
    ],
)
def test_the_many_files_of_a_dash_camera_are_no_options(command, mend, tmp_path, capsys):
    first, second = (tmp_path / f"DR_000{i}.MP4" for i in (1, 2))
    second.write_bytes(b"")
    assert main([command, str(first), str(second)]) == 2
    captured = capsys.readouterr()
    assert captured.err == f"fcw: {second}: a second drive after {first}; expected one drive: {mend}\n"
    with pytest.raises(SystemExit):
        main([command, str(first), "--no-such-option"])
    assert "Unrecognized options: --no-such-option" in capsys.readouterr().err
