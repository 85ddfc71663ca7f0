"""`fcw export`: the right files with the right content."""

import csv
import json
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from browser_page import PATIENCE_S
from drives.rrd_files import read_frame_times
from marked_drives import FRAMES, GREY, RATE_HZ, box_of, export, read_video
from numpy.typing import NDArray
from rerun.chunk import RrdReader

from fcw.box import Box
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.overlay import LEVEL_COLORS
from fcw.warning.types import WarningLevel
from fcw_viz.cli import main

MADE = {"rerun.controls.RowId", "RecordingInfo:start_time"}
"""What tells one recording from another of the same drive."""


@pytest.mark.slow
def test_a_drive_as_csv_has_a_row_for_each_frame(drives, tmp_path, capsys):
    assert export(drives / "monday", "--format", "csv", "--out", tmp_path / "t.csv") == 0
    table: Any = pd.read_csv(tmp_path / "t.csv")
    assert table["frame"].tolist() == list(range(FRAMES))
    assert table["time_s"].tolist() == [index / 25 for index in range(FRAMES)]
    assert table["track_id"].isna().sum() == 10
    assert (table["warning_level"] == "warning").sum() == 21
    assert (
        capsys.readouterr().out
        == f"{tmp_path / 't.csv'}: 60 rows of 1 drive, 50 boxes and 10 frames without one\n"
    )


@pytest.mark.parametrize(("form", "name"), [("csv", "tracks.csv"), ("parquet", "tracks.parquet")])
def test_many_drives_are_one_table(drives, tmp_path, form: str, name: str):
    assert export(drives, "--format", form, "--out", tmp_path / "tables") == 0
    path = tmp_path / "tables" / name
    table = pd.read_csv(path) if form == "csv" else pq.read_table(path).to_pandas()
    assert table.groupby("drive").size().to_dict() == {"monday": 60, "tuesday": 60}


@pytest.mark.parametrize(
    ("form", "suffix"), [("kitti", "txt"), ("mot", "txt"), ("mcap", "mcap"), ("rrd", "rrd")]
)
def test_other_formats_are_a_file_a_drive(drives, tmp_path, form: str, suffix: str):
    assert export(drives / "monday", drives / "tuesday", "--format", form, "--out", tmp_path / "out") == 0
    files = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert files == [f"monday.{suffix}", f"tuesday.{suffix}"]


def test_events_of_many_drives_are_one_table(drives, tmp_path, capsys):
    assert export(drives, "--events", "--format", "csv", "--out", tmp_path / "e.csv") == 0
    with (tmp_path / "e.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["drive"], row["kind"], row["track_id"]) for row in rows] == [
        ("monday", "warning", "4"),
        ("tuesday", "warning", "4"),
    ]
    assert (float(rows[0]["start_s"]), float(rows[0]["end_s"])) == (0.8, 1.6)
    assert float(rows[0]["min_distance_m"]) == 15.0
    assert float(rows[0]["min_ttc_s"]) == pytest.approx(15 / 9)
    assert "2 events of 2 drives" in capsys.readouterr().out
    assert export(drives, "--events", "--format", "parquet", "--out", tmp_path / "e.parquet") == 0
    table = pq.read_table(tmp_path / "e.parquet")
    assert table.column("start_s").to_pylist() == [0.8, 0.8]
    assert table.column("note").to_pylist() == [None, None]


def test_a_line_break_in_a_name_breaks_no_line_of_what_is_printed(drives, tmp_path, capsys):
    shutil.copytree(drives / "monday", tmp_path / "sun\nday")
    assert export(tmp_path / "sun\nday", "--format", "mot", "--out", tmp_path / "out") == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith(str(tmp_path / "out" / r"sun\nday.txt: "))


def test_events_of_a_range_are_those_that_touch_it(drives, tmp_path):
    for number, (between, count) in enumerate([(("1.6", "2"), 1), (("1.64", "2"), 0), (("0", "0.8"), 1)]):
        path = tmp_path / f"{number}.csv"
        arguments = ("--events", "--format", "csv", "--out", path, "--between", *between)
        assert export(drives / "monday", *arguments) == 0
        assert len(pd.read_csv(path)) == count


def test_a_cut_says_that_it_starts_at_its_keyframe(drives, entries, tmp_path, capsys):
    arguments = ("--format", "mcap", "--out", tmp_path / "cut.mcap", "--between", "1.4", "2")
    assert export(drives / "monday", *arguments) == 0
    assert "cut.mcap: starts 0.40 s earlier, at the keyframe" in capsys.readouterr().err
    assert list(DriveLog(tmp_path / "cut.mcap").entries()) == entries[25:51]


def recorded(path: Path) -> dict[str, str]:
    """All rows of a recording by entity, as text, for NaN equals nothing; but for when it was made."""
    rows: dict[str, list[dict[str, Any]]] = {}
    for chunk in RrdReader(path).stream():
        for row in chunk.to_record_batch().to_pylist():
            kept = {name: value for name, value in row.items() if name not in MADE}
            rows.setdefault(str(chunk.entity_path), []).append(kept)
    return {entity: repr(each) for entity, each in rows.items()}


def test_the_recording_made_of_a_log_is_the_one_that_the_run_wrote(drives, tmp_path):
    assert export(drives / "monday", "--format", "rrd", "--out", tmp_path / "out.rrd") == 0
    assert read_frame_times(tmp_path / "out.rrd") == read_frame_times(drives / "monday" / "drive.rrd")
    made, original = recorded(tmp_path / "out.rrd"), recorded(drives / "monday" / "drive.rrd")
    assert made == original
    verified = subprocess.run(
        [Path(sys.executable).with_name("rerun"), "rrd", "verify", tmp_path / "out.rrd"], check=False
    )
    assert verified.returncode == 0


def edges_in(strength: NDArray[np.float64], box: Box) -> list[float]:
    """The middle of the lines that are drawn near a box's left, right, top and bottom edge."""
    row, column = round(box.y + box.h / 2), round(box.center_x)
    found = []
    for edge, profile in (
        (box.x, strength[row]),
        (box.right, strength[row]),
        (box.y, strength[:, column]),
        (box.bottom, strength[:, column]),
    ):
        near = np.arange(round(edge) - 5, round(edge) + 6)
        found.append(float((profile[near] * near).sum() / profile[near].sum()))
    return found


@pytest.mark.slow
def test_boxes_in_the_video_are_within_a_pixel_of_the_drawn_marks(drives, tmp_path):
    assert export(drives / "monday", "--format", "mp4", "--out", tmp_path / "out.mp4") == 0
    assert export(drives / "monday", "--format", "mp4", "--out", tmp_path / "own.mp4", "--no-overlay") == 0
    pictures, bare = read_video(tmp_path / "out.mp4"), read_video(tmp_path / "own.mp4")
    assert len(pictures) == len(bare) == FRAMES
    for index in (0, 13, 25, 40):
        color = np.ptp(pictures[index].astype(float), axis=2)  # picture and marks have none
        marks = edges_in(GREY - bare[index].astype(float).mean(axis=2).clip(0, GREY), box_of(index))
        box = box_of(index)
        assert marks == pytest.approx([box.x, box.right, box.y, box.bottom], abs=0.5)
        assert edges_in(color, box) == pytest.approx(marks, abs=1)
    banner = pictures[30][4, 100:1200].mean(axis=0)
    assert banner == pytest.approx(LEVEL_COLORS[WarningLevel.WARNING][::-1], abs=12)


@pytest.fixture
def served(tmp_path: Path) -> Iterator[str]:
    handler = partial(SimpleHTTPRequestHandler, directory=str(tmp_path))
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


PLAY = """async ([rateHz, patienceMs]) => {
  const video = document.createElement("video");
  video.muted = true;
  // The test's server gives no parts of files, which seeking needs; memory does.
  video.src = URL.createObjectURL(await (await fetch("out.mp4")).blob());
  const event = (name) => new Promise((resolve, reject) => {
    video.addEventListener(name, resolve, { once: true });
    video.addEventListener("error", () => reject(new Error(video.error.message)), { once: true });
    setTimeout(() => reject(new Error(`no ${name} at ${video.currentTime} s`)), patienceMs);
  });
  document.body.append(video);
  await event("loadeddata");
  // A picture may be drawn after its place was found, and only who asked before that is told, once. So one
  // that nobody was told of is left, and sought again.
  const drawn = (time_s) => new Promise((resolve) => {
    video.requestVideoFrameCallback((now, { mediaTime }) => resolve(mediaTime));
    setTimeout(resolve, 1000, NaN);
    video.currentTime = time_s;
  });
  const pixel = async (time_s, x, y) => {
    const end = performance.now() + patienceMs;
    for (let drawn_s; !(drawn_s <= time_s && time_s < drawn_s + 1 / rateHz); drawn_s = await drawn(time_s)) {
      if (performance.now() > end) throw new Error(`no picture of ${time_s} s`);
      await drawn(0);
    }
    const canvas = document.createElement("canvas");
    canvas.width = video.videoWidth;
    canvas.height = video.videoHeight;
    const context = canvas.getContext("2d");
    context.drawImage(video, 0, 0);
    return [...context.getImageData(x, y, 1, 1).data].slice(0, 3);
  };
  const warned = await pixel(1.02, 700, 4);
  const grey = await pixel(2.22, 700, 200);
  const ended = event("ended");
  video.playbackRate = 4;
  await Promise.all([video.play(), ended]);
  return { width: video.videoWidth, height: video.videoHeight, duration_s: video.duration, warned, grey };
}"""


@pytest.mark.slow
@pytest.mark.parametrize("options", [(), ("--no-overlay",)], ids=["overlay", "relayed"])
def test_a_browser_plays_the_video_to_its_end(chromium, drives, tmp_path, served, options):
    assert export(drives / "monday", "--format", "mp4", "--out", tmp_path / "out.mp4", *options) == 0
    (tmp_path / "page.html").write_text("<!doctype html><title>video</title>")
    with chromium.new_page() as page:
        page.goto(f"{served}/page.html", timeout=PATIENCE_S * 1000)
        found = page.evaluate(PLAY, [RATE_HZ, PATIENCE_S * 1000])
    assert (found["width"], found["height"]) == (1280, 720)
    assert found["duration_s"] == pytest.approx(FRAMES / RATE_HZ, abs=0.001)
    assert found["grey"] == pytest.approx([GREY] * 3, abs=6)
    if not options:
        assert found["warned"] == pytest.approx(LEVEL_COLORS[WarningLevel.WARNING], abs=4)


@pytest.mark.slow
def test_coco_with_pictures_goes_into_training_and_evaluation(drives, tmp_path, capsys):
    out = tmp_path / "labelled"
    assert export(drives, "--format", "coco", "--pictures", "--every", "10", "--out", out) == 0
    names = sorted(str(path.relative_to(out)) for path in out.rglob("*") if path.is_file())
    assert names[0] == "calibration/monday.yaml"
    assert "images/tuesday/000050.jpg" in names
    assert len(names) == 2 + 2 * 6 + 1
    capsys.readouterr()
    arguments = ["--images", str(out / "images"), "--calibration", str(out / "calibration"), "--json"]
    assert main(["evaluate", "detection", str(out / "labels.json"), *arguments]) == 0
    assert json.loads(capsys.readouterr().out)["vehicles"] == 2 * 5


@pytest.mark.slow
def test_a_log_whose_writer_was_killed_is_exported_with_a_note(entries, header, tmp_path, capsys):
    sink = McapSink(tmp_path / "writing.mcap")
    sink.open(header)
    for result, packets in entries:
        sink.write(result, packets)
    (tmp_path / "drive.mcap").write_bytes((tmp_path / "writing.mcap").read_bytes())
    sink.close()
    assert export(tmp_path / "drive.mcap", "--format", "csv", "--out", tmp_path / "t.csv") == 0
    assert "drive.mcap: the run that wrote it was stopped early" in capsys.readouterr().err
    assert 45 <= len(pd.read_csv(tmp_path / "t.csv")) <= FRAMES
    assert export(tmp_path / "drive.mcap", "--format", "mp4", "--out", tmp_path / "o.mp4") == 0
    assert "`fcw recover`" in capsys.readouterr().err
    assert main(["recover", str(tmp_path / "drive.mcap")]) == 0
    assert export(tmp_path / "drive.mcap", "--format", "csv", "--out", tmp_path / "u.csv") == 0
    assert f"{tmp_path / 'drive.recovered.mcap'} is the repaired log" in capsys.readouterr().err
    assert len(read_video(tmp_path / "o.mp4")) >= 25


def test_a_drive_without_frames_among_others_is_left_out_with_a_note(drives, header, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    sink = McapSink(tmp_path / "empty" / "drive.mcap")
    sink.open(header)
    sink.close()
    arguments = ("--format", "csv", "--out", tmp_path / "t.csv")
    assert export(tmp_path / "empty", drives / "monday", *arguments) == 0
    assert "left out: " in capsys.readouterr().err
    assert set(pd.read_csv(tmp_path / "t.csv")["drive"]) == {"monday"}


def test_distances_in_feet_where_the_drive_is_imperial(entries, header, tmp_path):
    """Words in the picture only: tables stay in metres."""
    sink = McapSink(tmp_path / "drive.mcap")
    sink.open(replace(header, imperial=True))
    for result, packets in entries[:3]:
        sink.write(result, packets)
    sink.close()
    assert export(tmp_path / "drive.mcap", "--format", "csv", "--out", tmp_path / "t.csv") == 0
    assert pd.read_csv(tmp_path / "t.csv")["distance_m"].tolist() == [15.0] * 3
