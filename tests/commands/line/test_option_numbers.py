"""Numbers on the command line: one message for what is none, whichever command takes it."""

import pytest

from fcw_viz.cli import main


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
    ],
)
def test_what_is_no_finite_number_is_told_in_one_line_that_names_the_option(arguments, message, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
