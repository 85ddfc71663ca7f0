"""`fcw demo` on the shipped drive against its truth, and `fcw bench` on a short one."""

import csv
import json
import statistics
from pathlib import Path

import pytest

from fcw.logs.mcap_reader import DriveLog
from fcw.simulation.plain_drive import write_plain_drive
from fcw_viz.benchmark import DECODE, ENCODED, FULL, PRIOR, RELAYED
from fcw_viz.cli import main
from fcw_viz.commands.demo import demo_folder


def test_the_demo_follows_the_lead_and_warns_while_it_brakes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["demo", "--no-serve", "--out", str(out)]) == 0
    told = capsys.readouterr().out
    assert str(out / "drive.mcap") in told
    assert f"rerun {out / 'drive.rrd'}" in told

    with (demo_folder() / "truth.csv").open() as file:
        truth = {int(row["frame"]): row for row in csv.DictReader(file) if row["vehicle"] == "lead"}
    results = list(DriveLog(out / "drive.mcap").results())
    assert len(results) == len(truth)
    errors = [
        abs(result.lead.distance_m / float(truth[result.index]["distance_m"]) - 1)
        for result in results
        if result.lead
    ]
    assert len(errors) > 0.95 * len(results)
    assert statistics.median(errors) < 0.04

    (first, *_) = [
        warning
        for warning in json.loads((out / "summary.json").read_text())["warnings"]
        if warning["level"] == "warning"
    ]
    at_warning = truth[round(first["start_s"] * 30)]
    assert float(at_warning["closing_speed_mps"]) > 3  # only once the gap really closes
    assert float(at_warning["distance_m"]) > 10


def test_bench_reports_every_case_and_its_ratios(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_plain_drive(tmp_path, seed=1, duration_s=1)
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
