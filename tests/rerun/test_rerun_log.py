"""What a drive's rerun recording holds, read back with rerun's own reader."""

import math
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pyarrow as pa
import pytest
from drives.rrd_files import read_frame_times
from rerun.chunk import RrdReader
from rerun_drives import (
    CALIBRATION,
    CAMERA,
    CAUTION,
    HEADER,
    QUIET,
    TRACK,
    entities,
    ntsc_time_ns,
    only_row,
    packet,
    result,
    rows,
    values,
    video_samples,
    write_drive,
)

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.file import parse_calibration
from fcw.errors import UserError
from fcw.logs.drive_folder import drive_folder
from fcw.sources import open_source
from fcw.warning.describe import describe
from fcw_viz.rerun import blueprint as scene
from fcw_viz.rerun import log as rerun_log
from fcw_viz.rerun.log import FRAMES_PER_BATCH, RerunSink

HERE = Path(__file__).parent


def verify(path: Path) -> None:
    command = [sys.executable, "-m", "rerun_cli", "rrd", "verify", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    # rerun's module drops the exit code of its program: its words count.
    assert "verified without error" in done.stdout + done.stderr


@pytest.mark.parametrize("count", [1, FRAMES_PER_BATCH, 2 * FRAMES_PER_BATCH + 3])
def test_every_frame_leaves_one_row_with_its_exact_time(tmp_path, count):
    results = [result(index, [TRACK] if index % 3 else []) for index in range(count)]
    path = write_drive(tmp_path / "drive.rrd", results)
    assert read_frame_times(path) == [(index, ntsc_time_ns(index)) for index in range(count)]


def test_a_run_takes_its_recordings_for_its_own_whole_or_killed(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    whole = write_drive(out / "drive.rrd", [result(0)])
    sink = RerunSink(tmp_path / "drive.rrd")
    sink.open(HEADER)
    partial = Path(shutil.copy(tmp_path / "drive.partial.rrd", out))
    sink.close()
    with drive_folder(out, []):
        assert not whole.exists()
        assert not partial.exists()


def test_times_are_the_sources_also_where_they_begin_late_and_jump(tmp_path):
    times_ns = [123_456_789_012_345, 123_456_789_012_346, 999_999_999_999_999_999]
    results = [replace(result(index), time_ns=time_ns) for index, time_ns in enumerate(times_ns)]
    path = write_drive(tmp_path / "drive.rrd", results)
    assert read_frame_times(path) == list(enumerate(times_ns))


def test_a_clock_that_counts_from_1970_is_shown_as_day_and_hour(tmp_path):
    start_ns = 1_760_000_000_123_456_789
    results = [replace(result(index), time_ns=start_ns + ntsc_time_ns(index)) for index in range(3)]
    path = write_drive(tmp_path / "drive.rrd", results)
    assert read_frame_times(path) == [(each.index, each.time_ns) for each in results]
    (chunk,) = RrdReader(path).stream().filter(content=f"/{scene.FRAMES}")
    assert pa.types.is_timestamp(chunk.to_record_batch().schema.field(scene.TIME_TIMELINE).type)


def test_frame_rows_hold_the_warning(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [result(0), result(1, [TRACK], CAUTION)])
    quiet, caution = (values(row, "fcw.Frame") for row in rows(path, scene.FRAMES))
    assert quiet["warning_level"] == "none"
    assert quiet["ttc_s"] is None
    assert caution["warning_level"] == "caution"
    assert caution["rule"] == "ttc"
    assert caution["ttc_s"] == 2.5
    assert caution["lead_id"] == 7
    assert caution["time_ns"] == ntsc_time_ns(1)


def test_rerun_itself_finds_no_fault(tmp_path):
    verify(write_drive(tmp_path / "drive.rrd", [result(0), result(1, [TRACK], CAUTION)]))


def test_a_drive_without_frames_is_a_whole_file(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [])
    verify(path)
    assert read_frame_times(path) == []


def test_a_drive_without_vehicles_holds_every_entity(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [result(0)])
    expected = {
        scene.FRAMES,
        scene.EGO,
        scene.EGO_BODY,
        scene.PATH,
        scene.DISTANCES,
        scene.VEHICLES,
        scene.CAMERA,
        scene.IMAGE,
        scene.VIDEO,
        scene.IMAGE_VEHICLES,
        scene.IMAGE_DETECTIONS,
        scene.IMAGE_ROWS,
        scene.PLOT_DISTANCE,
        scene.PLOT_TTC,
        scene.PLOT_SPEED,
        scene.LEVEL,
        scene.DRIVE,
    }
    assert expected <= entities(path)


def test_closing_twice_or_without_opening_does_nothing(tmp_path):
    RerunSink(tmp_path / "never.rrd").close()
    sink = RerunSink(tmp_path / "drive.rrd")
    sink.open(HEADER)
    sink.write(result(0), [packet(0)])
    sink.close()
    sink.close()
    assert [path.name for path in tmp_path.iterdir()] == ["drive.rrd"]
    assert len(read_frame_times(tmp_path / "drive.rrd")) == 1


def test_an_older_drive_stays_until_the_new_one_is_whole(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [result(0)])
    sink = RerunSink(path)
    sink.open(HEADER)
    for index in range(3):
        sink.write(result(index), [])
    assert len(read_frame_times(path)) == 1
    sink.close()
    assert len(read_frame_times(path)) == 3


@pytest.mark.slow
def test_a_killed_run_leaves_all_but_the_last_batch_readable(tmp_path):
    script = f"""
import os, sys, time, warnings
sys.path[:0] = {[str(HERE), str(HERE.parent / "helpers"), str(HERE.parents[1])]!r}
from test_rerun_log import *
sink = RerunSink(Path({str(tmp_path / "drive.rrd")!r}))
sink.open(HEADER)
for index in range(2 * FRAMES_PER_BATCH + 5):
    sink.write(result(index, [TRACK]), [packet(index)])
warnings.simplefilter("ignore")  # no footer yet
while len(read_frame_times(Path({str(tmp_path / "drive.partial.rrd")!r}))) < 2 * FRAMES_PER_BATCH:
    time.sleep(0.02)  # rerun writes in a thread of its own
os.kill(os.getpid(), 9)
"""
    killed = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=120
    )
    assert killed.returncode == -9, killed.stderr
    assert not (tmp_path / "drive.rrd").exists()
    with pytest.warns(Warning, match="no footer"):
        times = read_frame_times(tmp_path / "drive.partial.rrd")
    assert times == [(index, ntsc_time_ns(index)) for index in range(2 * FRAMES_PER_BATCH)]


def test_a_folder_that_is_not_there_is_the_users_mistake(tmp_path):
    with pytest.raises(UserError, match=r"nowhere/drive\.rrd: cannot write.*folder that exists"):
        RerunSink(tmp_path / "nowhere" / "drive.rrd").open(HEADER)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere all names are Unicode")
def test_a_name_that_is_not_utf8_is_the_users_mistake(tmp_path):
    folder = tmp_path / os.fsdecode(b"\xff")
    folder.mkdir()
    with pytest.raises(UserError, match="cannot write the recording"):
        RerunSink(folder / "drive.rrd").open(HEADER)


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts threads as Linux tells them")
def test_a_recording_that_is_closed_leaves_no_thread(tmp_path):
    script = f"""
import sys, time
sys.path[:0] = {sys.path!r}
from pathlib import Path
from rerun_drives import result, write_drive

def threads_after_a_drive():
    write_drive(Path({str(tmp_path)!r}) / "drive.rrd", [result(0)])
    return len(list(Path("/proc/self/task").iterdir()))

most = threads_after_a_drive()
for _ in range(3):
    while threads_after_a_drive() > most:  # one more may just be ending
        time.sleep(0.01)
"""
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


def write_batch(sink: RerunSink) -> None:
    for index in range(FRAMES_PER_BATCH):
        sink.write(result(index), [packet(index)])


def test_a_full_disk_is_told_and_leaves_no_file_that_looks_whole(tmp_path, monkeypatch):
    resource = pytest.importorskip("resource", reason="needs a limit on the size of files, as POSIX has it")
    monkeypatch.setattr(rerun_log, "WRITE_TIMEOUT_S", 2.0)
    sink = RerunSink(tmp_path / "drive.rrd")
    sink.open(HEADER)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, ((tmp_path / "drive.partial.rrd").stat().st_size, limits[1]))
    try:
        with pytest.raises(UserError, match=r"drive\.rrd: .* not be written whole .*make room on the disk"):
            write_batch(sink)
        with pytest.raises(UserError, match="not be written whole"):
            sink.close()
        sink.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert [path.name for path in tmp_path.iterdir()] == ["drive.partial.rrd"]


def test_packets_that_are_not_shown_are_marked_and_have_no_frame(tmp_path):
    hidden = [packet(-2, shown=False), packet(-1, shown=False)]
    sink = RerunSink(tmp_path / "drive.rrd")
    sink.open(HEADER)
    sink.write(result(0), [*hidden, packet(0)])
    sink.write(result(1), [packet(1)])
    sink.close()
    samples = video_samples(tmp_path / "drive.rrd")
    assert [row["drive_time"] for row in samples] == [ntsc_time_ns(index) for index in (-2, -1, 0, 1)]
    assert [values(row, "fcw.Packet")["shown"] for row in samples] == [False, False, True, True]
    assert [row.get("frame") for row in samples] == [None, None, 0, 1]
    data = [bytes(row["VideoStream:sample"][0]) for row in samples]  # pyright: ignore[reportIndexIssue]
    assert data == [f"picture {index}".encode() for index in (-2, -1, 0, 1)]
    assert read_frame_times(tmp_path / "drive.rrd") == [(0, 0), (1, ntsc_time_ns(1))]


def test_each_frame_shows_its_own_vehicles_and_no_older_ones(tmp_path):
    other = replace(TRACK, track_id=9, distance_m=35.0)
    counts = [2, 0, 1] * FRAMES_PER_BATCH
    results = [result(index, [TRACK, other][:count]) for index, count in enumerate(counts)]
    path = write_drive(tmp_path / "drive.rrd", results)
    for entity, column in (
        (scene.IMAGE_VEHICLES, "Boxes2D:half_sizes"),
        (scene.IMAGE_VEHICLES, "fcw.Track:values"),
        (scene.IMAGE_DETECTIONS, "Boxes2D:centers"),
        (scene.VEHICLES, "Boxes3D:half_sizes"),
    ):
        assert [len(row[column]) for row in rows(path, entity)] == counts  # pyright: ignore[reportArgumentType]


def test_boxes_are_shifted_to_reruns_pixel_coordinates(tmp_path):
    # A box from -0.5 to 9.5 covers the first ten pixels, which for rerun reach from 0 to 10.
    track = replace(TRACK, box=Box(x=-0.5, y=-0.5, w=10.0, h=20.0))
    row = only_row(write_drive(tmp_path / "drive.rrd", [result(0, [track])]), scene.IMAGE_VEHICLES)
    assert row["Boxes2D:centers"] == [[5.0, 10.0]]
    assert row["Boxes2D:half_sizes"] == [[5.0, 10.0]]


def test_labels_and_numbers_of_a_vehicle(tmp_path):
    row = only_row(write_drive(tmp_path / "drive.rrd", [result(0, [TRACK])]), scene.IMAGE_VEHICLES)
    assert row["Boxes2D:labels"] == ["20 m  2.5 s"]
    assert values(row, "fcw.Track")["distance_low_m"] == 19.0
    assert values(row, "fcw.Track")["closing_speed_mps"] == 8.0


def test_camera_pose_and_pinhole_put_the_road_where_the_calibration_does(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [result(0)])
    pose, pinhole = only_row(path, scene.CAMERA), only_row(path, scene.IMAGE)
    position = np.array(pose["Transform3D:translation"][0])  # pyright: ignore[reportIndexIssue]
    # rerun keeps matrices column by column.
    rotation = np.reshape(pose["Transform3D:mat3x3"][0], (3, 3), order="F")  # pyright: ignore[reportIndexIssue]
    intrinsics = np.reshape(pinhole["Pinhole:image_from_camera"][0], (3, 3), order="F")  # pyright: ignore[reportIndexIssue]
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    for distance_m, lateral_m in ((4.0, 0.0), (12.0, 2.5), (60.0, -3.5)):
        seen = intrinsics @ rotation.T @ (np.array((distance_m, lateral_m, 0.0)) - position)
        column, row = seen[:2] / seen[2] - 0.5
        assert row == pytest.approx(CALIBRATION.row_at(distance_m), abs=1e-2)
        assert column == pytest.approx(CALIBRATION.column_at(lateral_m, distance_m), abs=1e-2)


def test_a_rear_on_the_road_has_the_size_that_its_box_spans(tmp_path):
    level = Calibration.from_camera(replace(CAMERA, pitch_rad=0.0), CALIBRATION.image_size, 1.9)
    box = level.ground_box(distance_m=20.0, lateral_m=0.5, width_m=1.8, height_m=1.4)
    header = replace(HEADER, calibration=level)
    row = only_row(
        write_drive(tmp_path / "drive.rrd", [result(0, [replace(TRACK, box=box)])], header), scene.VEHICLES
    )
    center, half = np.array(row["Boxes3D:centers"][0]), np.array(row["Boxes3D:half_sizes"][0])  # pyright: ignore[reportIndexIssue]
    assert half[1:] * 2 == pytest.approx((1.8, 1.4), rel=1e-5)
    assert center - half == pytest.approx((20.0, 0.5 - 0.9, 0.0), abs=1e-4)


def test_an_interval_without_an_end_is_drawn_to_a_finite_one(tmp_path):
    track = replace(TRACK, distance_high_m=math.inf)
    path = write_drive(tmp_path / "drive.rrd", [result(0, [track])])
    (strip,) = only_row(path, scene.VEHICLES)["LineStrips3D:strips"]  # pyright: ignore[reportGeneralTypeIssues]
    assert strip[0] == [19.0, 0.5, 0.0]
    assert np.isfinite(strip[1]).all()
    assert values(only_row(path, scene.IMAGE_VEHICLES), "fcw.Track")["distance_high_m"] == math.inf


def plotted(path: Path, entity: str) -> list[list[float]]:
    return [row["Scalars:scalars"] for row in rows(path, entity) if "Scalars:scalars" in row]  # pyright: ignore[reportReturnType]


def test_plots_follow_the_lead_and_break_without_one(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [result(0, [TRACK]), result(1)])
    assert plotted(path, scene.PLOT_DISTANCE)[0] == [20.0, 19.0, 22.0]
    assert plotted(path, scene.PLOT_SPEED)[0] == [8.0, 7.5, 8.5]
    assert plotted(path, scene.PLOT_TTC)[0] == [2.5]
    for entity in (scene.PLOT_DISTANCE, scene.PLOT_SPEED, scene.PLOT_TTC):
        assert np.isnan(plotted(path, entity)[1]).all()


def test_plots_are_in_feet_and_miles_an_hour_where_asked_for(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [result(0, [TRACK])], replace(HEADER, imperial=True))
    assert plotted(path, scene.PLOT_DISTANCE)[0] == pytest.approx([20 / 0.3048, 19 / 0.3048, 22 / 0.3048])
    assert plotted(path, scene.PLOT_SPEED)[0][0] == pytest.approx(8.0 * 3600 / 1609.344)
    assert only_row(path, scene.IMAGE_VEHICLES)["Boxes2D:labels"] == ["66 ft  2.5 s"]
    assert values(only_row(path, scene.IMAGE_VEHICLES), "fcw.Track")["distance_m"] == 20.0


def test_only_changes_of_the_level_are_told_with_their_reason(tmp_path):
    first_loud, first_quiet_again = FRAMES_PER_BATCH - 1, FRAMES_PER_BATCH + 2
    results = [
        result(index, [TRACK], CAUTION if first_loud <= index < first_quiet_again else QUIET)
        for index in range(FRAMES_PER_BATCH + 5)
    ]
    path = write_drive(tmp_path / "drive.rrd", results)
    told = list(rows(path, scene.LOG))
    assert [row["frame"] for row in told] == [first_loud, first_quiet_again]
    assert told[0]["TextLog:text"] == [describe(result(0, [TRACK], CAUTION).told_warning)]
    assert told[0]["TextLog:level"] == ["WARN"]
    states = [row for row in rows(path, scene.LEVEL) if "frame" in row]
    assert [row["StateChange:state"] for row in states] == [["none"], ["caution"], ["none"]]
    assert [row["frame"] for row in states] == [0, first_loud, first_quiet_again]


def test_a_drive_that_begins_with_a_warning_tells_it(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [result(0, [TRACK], CAUTION)])
    assert [row["frame"] for row in rows(path, scene.LOG)] == [0]


def test_the_calibration_comes_back_from_the_file(tmp_path):
    path = write_drive(tmp_path / "drive.rrd", [])
    properties = only_row(path, "__properties/drive")
    (text,) = properties["fcw.Drive:calibration"]  # pyright: ignore[reportGeneralTypeIssues]
    assert parse_calibration(text, "drive.rrd") == CALIBRATION
    assert properties["fcw.Drive:facts"][0]["model_sha256"] == "ab" * 32  # pyright: ignore[reportIndexIssue]
    (shown,) = only_row(path, scene.DRIVE)["TextDocument:text"]  # pyright: ignore[reportGeneralTypeIssues]
    assert "0.1.0" in shown


@pytest.mark.parametrize("clip", ["udacity_test_small2.mp4", "tmo_seattlestreet2.mp4", "solidWhiteRight.mp4"])
def test_relayed_video_of_a_real_drive_decodes_to_its_pictures(tmp_path, data_dir, clip):
    source = open_source(data_dir / "clips" / clip)
    calibration = Calibration.from_camera(CAMERA, source.image_size)
    sink = RerunSink(tmp_path / "drive.rrd")
    sink.open(replace(HEADER, image_size=source.image_size, calibration=calibration))
    times, middles = [], []
    for frame in source.frames():
        sink.write(replace(result(frame.index), time_ns=frame.time_ns), frame.packets)
        times.append((frame.index, frame.time_ns))
        middles.append(frame.image[source.image_size.height // 2].astype(int))
    sink.close()
    assert source.relays_video
    assert read_frame_times(tmp_path / "drive.rrd") == times

    decoder = av.CodecContext.create("h264", "r")
    samples = video_samples(tmp_path / "drive.rrd")
    shown = [values(row, "fcw.Packet")["shown"] for row in samples]
    encoded = [av.Packet(bytes(row["VideoStream:sample"][0])) for row in samples]  # pyright: ignore[reportIndexIssue]
    pictures = [picture for each in (*encoded, None) for picture in decoder.decode(each)]  # pyright: ignore[reportAttributeAccessIssue]
    assert len(pictures) == len(samples)
    decoded = [picture for picture, is_shown in zip(pictures, shown, strict=True) if is_shown]
    assert len(decoded) == len(times)
    for picture, middle in zip(decoded, middles, strict=True):
        row = picture.to_ndarray(format="bgr24")[source.image_size.height // 2].astype(int)
        assert np.abs(row - middle).max() <= 2  # converters round colours differently
