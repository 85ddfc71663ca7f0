"""`fcw bench` on a short drive."""

import contextlib
import io
import json
import statistics
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import av
import cv2
import numpy as np
import pytest
from running.demo_cut import cut_demo
from running.tiny_nets import write_net

from fcw.errors import UserError
from fcw.job import DriveJob
from fcw.sources import open_source
from fcw_viz.benchmark.against import EarlierFigures
from fcw_viz.benchmark.drive_cases import DECODE, ENCODED, ONE_THREAD, RELAYED, TWO_THREADS
from fcw_viz.benchmark.figures import Figures
from fcw_viz.benchmark.long_drive import repeat_packets
from fcw_viz.benchmark.picture_cases import (
    CHANNELS,
    FARTHEST_M,
    FULL,
    LUV,
    NET,
    PITCH_TOLERANCES_DEG,
    PRIOR,
    PRIOR_NEAR,
    prior_name,
)
from fcw_viz.benchmark.report import write_report
from fcw_viz.benchmark.stages import (
    DECODING,
    DETECTION_REST,
    ENCODING,
    GLANCE,
    LOGGING,
    LOOK,
    RERUN_LOGGING,
    STAGES,
    TRACKING,
    stage_times,
)
from fcw_viz.cli import main


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The figures of `fcw bench` on a short drive with a net beside the own detectors, and the report."""
    folder = tmp_path_factory.mktemp("bench")
    drive = cut_demo(folder, 30, 0.5)
    net = write_net(folder / "tiny.onnx", np.zeros((1, 300, 6), np.float32), (192, 320))
    arguments = ["bench", str(drive), "--rounds", "2", "--detector-frames", "2", "--json"]
    arguments += ["--shortest", "1"]
    with contextlib.redirect_stdout(io.StringIO()) as told:
        assert main([*arguments, "--onnx", str(net), "--report", str(folder / "report")]) == 0
    return json.loads(told.getvalue()) | {"folder": folder / "report"}


@pytest.mark.slow
def test_bench_reports_every_case_in_every_round(bench: dict[str, Any]) -> None:
    times = bench["ms_per_frame"]
    assert {DECODE, RELAYED, ENCODED, ONE_THREAD, TWO_THREADS} < set(times)
    assert {LUV, CHANNELS, NET, PRIOR, PRIOR_NEAR, FULL, "onnx:tiny.onnx"} < set(times)
    assert all(len(values) == 2 and min(values) > 0 for values in times.values())


@pytest.mark.slow
def test_bench_repeats_a_short_drive(bench: dict[str, Any]) -> None:
    (drive,) = bench["folder"].parent.glob("*.mp4")
    frames = open_source(drive).frame_count
    assert frames is not None
    assert f"{2 * frames} frames of the whole drive" in bench["heading"]


@pytest.mark.slow
def test_ratios_are_those_of_the_same_round(bench: dict[str, Any]) -> None:
    times, ratios = bench["ms_per_frame"], bench["ratios"]
    expected = {
        "distance prior 4-80 m / plain ACF at the same scales": (PRIOR, FULL),
        "channels of the whole picture / cv2 BGR to Luv": (CHANNELS, LUV),
        "detector net / cv2 BGR to Luv": (NET, LUV),
        "rate of two threads / one": (ONE_THREAD, TWO_THREADS),
        "rate of the whole job, video relayed / decoding": (DECODE, RELAYED),
    }
    for name, (case, to) in expected.items():
        each = [a / b for a, b in zip(times[case], times[to], strict=True)]
        assert ratios[name] == pytest.approx(sum(each) / 2)  # the median of two


@pytest.mark.slow
def test_the_prior_looks_at_more_windows_the_farther_and_the_less_sure_of_the_pitch(bench: dict[str, Any]):
    windows = bench["windows_per_frame"]
    for deg in PITCH_TOLERANCES_DEG:
        counts = [windows[prior_name(farthest_m, deg)] for farthest_m in FARTHEST_M]
        assert 1000 < counts[0] < counts[1] < counts[2] < windows[FULL]
    for farthest_m in FARTHEST_M:
        counts = [windows[prior_name(farthest_m, deg)] for deg in PITCH_TOLERANCES_DEG]
        assert counts == sorted(set(counts))


@pytest.mark.slow
def test_the_report_holds_the_tables_the_figures_and_two_pictures(bench: dict[str, Any]) -> None:
    folder = bench["folder"]
    text = (folder / "bench.txt").read_text()
    assert all(case in text for case in bench["ms_per_frame"])
    assert all(f"{ratio:.2f}" in text for ratio in bench["ratios"].values())
    assert json.loads((folder / "bench.json").read_text())["ratios"] == bench["ratios"]
    dots = ElementTree.parse(folder / "speed-windows.svg").findall(".//{*}circle")
    assert len(dots) == len(bench["windows_per_frame"])
    lines = ElementTree.parse(folder / "speed-pitch.svg").findall(".//{*}polyline")
    assert len(lines) == len(FARTHEST_M)


@pytest.mark.slow
def test_every_stage_of_a_frame_has_its_part_of_the_bar(bench: dict[str, Any]) -> None:
    assert tuple(bench["stages_ms"]) == tuple(stage for stage in STAGES if stage != ENCODING)  # it is relayed
    assert all(len(values) == 2 and min(values) >= 0 for values in bench["stages_ms"].values())
    looks = (GLANCE, LOOK, DETECTION_REST)
    for stage in (DECODING, *looks, TRACKING, LOGGING, RERUN_LOGGING):
        assert min(bench["stages_ms"][stage]) > 0
    bars = ElementTree.parse(bench["folder"] / "speed-stages.svg").findall(".//{*}rect")
    widths = [float(bar.attrib["width"]) for bar in bars[::2]]  # each is followed by the one beside its name
    medians = [statistics.median(values) for values in bench["stages_ms"].values()]
    assert [width / sum(widths) for width in widths] == pytest.approx(
        [ms / sum(medians) for ms in medians], abs=1e-3
    )


@pytest.mark.slow
def test_encoding_is_a_stage_of_a_drive_whose_video_cannot_be_relayed(tmp_path: Path) -> None:
    drive = cut_demo(tmp_path, 30, 0.2)
    (tmp_path / "pictures").mkdir()
    for frame in open_source(drive).frames():
        cv2.imwrite(str(tmp_path / "pictures" / f"{frame.index}.png"), frame.image)
    calibration = tmp_path / "drive.calibration.yaml"
    job = DriveJob(source=tmp_path / "pictures", out=tmp_path, calibration=calibration, frame_rate_hz=30.0)
    stages_ms = stage_times(job, 0.2)
    assert tuple(stages_ms) == STAGES
    assert stages_ms[ENCODING] > 0


@pytest.mark.slow
def test_a_run_against_itself_changes_nothing(bench: dict[str, Any]) -> None:
    figures = Figures("", bench["ms_per_frame"], {}, bench["stages_ms"], bench["windows_per_frame"])
    changes = EarlierFigures.load(bench["folder"] / "bench.json").as_json(figures)
    assert {"detector net / cv2 BGR to Luv", f"{PRIOR} / Luv", f"stage {LOOK} / Luv"} < set(changes)
    assert all(change["ratio"] == pytest.approx(1.0) for change in changes.values())
    twice = Figures(
        "",
        {**bench["ms_per_frame"], PRIOR: [2 * ms for ms in bench["ms_per_frame"][PRIOR]]},
        {},
        {},
        bench["windows_per_frame"],
    )
    changes = EarlierFigures.load(bench["folder"] / "bench.json").as_json(twice)
    assert changes[f"{PRIOR} / Luv"]["ratio"] == pytest.approx(2.0)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"ratios": {}}',
        '{"heading": "", "ms_per_frame": {"cv2 BGR to Luv": []}}',
        '{"heading": "", "ratios": {}, "ms_per_frame": {"cv2 BGR to Luv": [0], "a": [1]}, '
        '"windows_per_frame": {"a": 1}}',
    ],
)
def test_bench_refuses_another_files_figures(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "old.json").write_text(text)
    assert main(["bench", "--against", str(tmp_path / "old.json")]) == 2
    told = capsys.readouterr()
    assert "old.json: not the figures of a benchmark" in " ".join(told.err.split())
    assert told.out == ""
    assert main(["bench", "--against", str(tmp_path / "none.json")]) == 2
    assert "none.json: cannot be read" in " ".join(capsys.readouterr().err.split())


def test_bench_refuses_no_rounds(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--rounds", "0"]) == 2
    assert "--rounds" in capsys.readouterr().err


@pytest.mark.parametrize("seconds", ["-1", "inf", "nan"])
def test_bench_refuses_what_is_no_duration(seconds: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--shortest", seconds]) == 2
    assert f"--shortest {seconds}" in capsys.readouterr().err


def test_bench_refuses_a_report_that_cannot_be_written_before_it_measures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    # Without the folder's check the missing video would be told of.
    assert main(["bench", str(tmp_path / "none.mp4"), "--report", str(tmp_path / "file")]) == 2
    assert "cannot make this folder" in " ".join(capsys.readouterr().err.split())


def test_a_report_writes_names_as_they_are(tmp_path: Path) -> None:
    names = [LUV, FULL, *(prior_name(far_m, deg) for far_m in FARTHEST_M for deg in PITCH_TOLERANCES_DEG)]
    windows = dict.fromkeys(names[1:], 1000)
    figures = Figures("drive [cut] :car:.mp4, 1280x720", {name: [1.0] for name in names}, {}, {}, windows)
    write_report(figures, tmp_path)
    assert (tmp_path / "bench.txt").read_text().startswith("drive [cut] :car:.mp4, 1280x720\n")


def test_a_video_of_one_picture_cannot_be_repeated(tmp_path: Path) -> None:
    clip = tmp_path / "one.mp4"
    with av.open(str(clip), "w") as file:
        stream = file.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 64, "yuv420p"
        picture = av.VideoFrame.from_ndarray(np.zeros((64, 64, 3), np.uint8), format="bgr24")
        file.mux([*stream.encode(picture), *stream.encode()])
    with pytest.raises(UserError, match=r"one\.mp4: cannot be repeated to 5 s .*--shortest 0"):
        repeat_packets(clip, tmp_path / "long.mp4", 5.0)


def test_bench_refuses_classes_without_a_net(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--detector-classes", "car"]) == 2
    assert "--onnx" in capsys.readouterr().err
