"""`fcw run` on MCAP files that others made, and on this program's own logs."""

import json
import math
from pathlib import Path
from types import SimpleNamespace

import pytest
from drives.rrd_files import read_frame_times
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_files import (
    DELAY_NS,
    DEMO,
    demo_frames,
    foxglove_images,
    foxglove_video,
    ros_file,
    ros_header,
    ros_jpeg,
    ros_twist,
    stamp_ns,
)

from fcw.camera.calibration import Calibration
from fcw.camera.file import read_calibration, write_calibration
from fcw.logs.mcap.reader import DriveLog
from fcw.motion.state import SpeedSource
from fcw_viz.cli import main

pytestmark = pytest.mark.slow

CALIBRATION = DEMO / "drive.calibration.yaml"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
TWIST = "geometry_msgs/msg/TwistStamped"


def run(path: Path, out: Path, *more: str) -> int:
    return main(["run", str(path), "--out", str(out), "--calibration", str(CALIBRATION), *more])


@pytest.mark.parametrize("kind", ["foxglove images", "foxglove video", "ros images"])
def test_a_foreign_file_runs_end_to_end(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = demo_frames(15)
    path, out = tmp_path / "drive.mcap", tmp_path / "out"
    if kind == "foxglove images":
        foxglove_images(path, frames)
    elif kind == "foxglove video":
        foxglove_video(path, [(stamp_ns(f), packet.data) for f in frames for packet in f.packets])
    else:
        images = [("/camera", COMPRESSED, stamp_ns(f) + DELAY_NS, ros_jpeg(f)) for f in frames]
        speeds = [("/twist", TWIST, stamp_ns(f) + DELAY_NS, ros_twist(stamp_ns(f), 21.5)) for f in frames]
        ros_file(path, images + speeds)
    assert run(path, out, "--json") == 0
    summary, told = capsys.readouterr()
    log = DriveLog(out / "drive.mcap")
    results = list(log.results())
    expected = [(frame.index, stamp_ns(frame)) for frame in frames]
    assert [(result.index, result.time_ns) for result in results] == expected
    assert read_frame_times(out / "drive.rrd") == expected
    assert log.header.relays_video == (kind == "foxglove video")
    assert sum(bool(result.detections) for result in results) > 10
    assert json.loads(summary)["duration_s"] == pytest.approx(14 / 30)
    if kind == "ros images":
        assert [result.ego_speed_mps for result in results] == pytest.approx([21.5] * 15)
        assert "own speed from /twist" in told
    else:
        # Nobody gave a speed: what is known of it is the picture's.
        sources = {result.own_motion.speed_source for result in results if result.own_motion is not None}
        assert SpeedSource.GIVEN not in sources
        assert "own speed from" not in told


def test_a_speed_that_is_given_is_preferred_to_that_in_the_file(tmp_path: Path) -> None:
    frames = demo_frames(3)
    images = [("/camera", COMPRESSED, stamp_ns(f), ros_jpeg(f)) for f in frames]
    path = ros_file(
        tmp_path / "a.mcap", images + [("/v", TWIST, stamp_ns(f), ros_twist(stamp_ns(f), 9)) for f in frames]
    )
    assert run(path, tmp_path / "out", "--ego-speed", "30") == 0
    assert {r.ego_speed_mps for r in DriveLog(tmp_path / "out" / "drive.mcap").results()} == {30.0}


def test_several_cameras_are_asked_for_and_one_can_be_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = foxglove_images(tmp_path / "two.mcap", demo_frames(3), ["/front/image", "/rear/image"])
    assert run(path, tmp_path / "out") == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "/front/image (foxglove.CompressedImage); /rear/image (foxglove.CompressedImage)" in err
    assert "--topic" in err
    assert not (tmp_path / "out").exists()
    points = ["--points", "6:640", "15:520", "30:480", "--height", "1.25", "--save", str(tmp_path / "c.yaml")]
    assert main(["calibrate", str(path), *points]) == 2
    assert "--topic" in capsys.readouterr().err
    assert main(["calibrate", str(path), "--topic", "/rear/image", *points]) == 0
    assert run(path, tmp_path / "out", "--topic", "/front/image") == 0
    assert len(list(DriveLog(tmp_path / "out" / "drive.mcap").results())) == 3
    assert "taken as that of" not in capsys.readouterr().err
    (tmp_path / "two.calibration.yaml").write_bytes(CALIBRATION.read_bytes())
    assert main(["run", str(path), "--topic", "/rear/image", "--out", str(tmp_path / "rear")]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "two.calibration.yaml: taken as that of /rear/image; the file has /front/image as well" in told


def test_a_camera_info_says_what_it_is_good_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (frame,) = demo_frames(1)
    height, width = frame.image.shape[:2]
    k = [width / 2 / math.tan(math.radians(31)), 0.0, width / 2, 0.0, 900.0, height / 2, 0.0, 0.0, 1.0]
    info = SimpleNamespace(
        header=ros_header(stamp_ns(frame)),
        height=height,
        width=width,
        distortion_model="plumb_bob",
        d=[-0.1, 0.0, 0.0, 0.0, 0.0],
        k=k,
        r=[0.0] * 9,
        p=[0.0] * 12,
    )
    path = ros_file(
        tmp_path / "drive.mcap",
        [
            ("/camera", COMPRESSED, stamp_ns(frame), ros_jpeg(frame)),
            ("/camera_info", "sensor_msgs/msg/CameraInfo", stamp_ns(frame), info),
        ],
    )
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    assert "drive.calibration.yaml: no calibration" in message
    assert "/camera_info does not say where the camera is" in message
    assert "--field-of-view 62.0" in message
    assert run(path, tmp_path / "out", "--no-rerun-log") == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "by /camera_info the lens moves the picture's corners by" in told
    assert "the calibration has no lens" in told


def video_of_demo(folder: Path, count: int) -> Path:
    """The first pictures of the shipped drive as others record them."""
    packets = [(stamp_ns(frame), packet.data) for frame in demo_frames(count) for packet in frame.packets]
    return foxglove_video(folder / "video.mcap", packets)


def test_an_own_log_runs_anew_with_its_calibration_and_speed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    video = video_of_demo(tmp_path, 12)
    assert run(video, tmp_path / "first", "--ego-speed", "17.5") == 0
    capsys.readouterr()
    first = tmp_path / "first" / "drive.mcap"
    assert main(["run", str(first), "--out", str(tmp_path / "second")]) == 0
    told = capsys.readouterr().err
    assert "calibration from the file itself" in told
    assert "own speed from /fcw/frame" in told
    before, after = DriveLog(first), DriveLog(tmp_path / "second" / "drive.mcap")
    assert list(after.entries()) == list(before.entries())
    assert after.header.calibration == before.header.calibration == read_calibration(CALIBRATION)


def test_what_a_log_found_of_the_own_speed_is_not_given_to_the_next_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    video = video_of_demo(tmp_path, 45)
    assert run(video, tmp_path / "first") == 0
    first = tmp_path / "first" / "drive.mcap"
    found = [result.own_motion.speed_source for result in DriveLog(first).results() if result.own_motion]
    assert SpeedSource.PICTURE in found
    capsys.readouterr()
    assert main(["run", str(first), "--out", str(tmp_path / "second")]) == 0
    assert "own speed from" not in capsys.readouterr().err
    after = DriveLog(tmp_path / "second" / "drive.mcap")
    assert list(after.entries()) == list(DriveLog(first).entries())


def test_of_two_logs_that_were_merged_either_camera_is_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    video = video_of_demo(tmp_path, 12)
    assert run(video, tmp_path / "first") == 0
    merged = merge_twice(tmp_path / "first" / "drive.mcap", tmp_path / "merged.mcap", ("/front", "/rear"))
    capsys.readouterr()
    assert run(merged, tmp_path / "out") == 2
    told = capsys.readouterr().err
    assert "name the camera that looks ahead with --topic" in told
    topic = next(word for word in told.split() if word.startswith("/front"))
    assert run(merged, tmp_path / "out", "--topic", topic) == 0
    assert len(list(DriveLog(tmp_path / "out" / "drive.mcap").results())) == 12


def merge_twice(log: Path, merged: Path, prefixes: tuple[str, ...]) -> Path:
    """All messages of a log under each prefix, as a tool that merges recordings does it."""
    with merged.open("wb") as target, log.open("rb") as source:
        writer, known = Writer(target), {}
        writer.start()
        for schema, channel, message in make_reader(source).iter_messages():
            assert schema is not None
            for prefix in prefixes:
                topic = prefix + channel.topic
                if topic not in known:
                    number = writer.register_schema(schema.name, schema.encoding, schema.data)
                    known[topic] = writer.register_channel(topic, channel.message_encoding, number)
                writer.add_message(known[topic], message.log_time, message.data, message.publish_time)
        writer.finish()
    return merged


def test_a_log_is_never_replaced_by_the_one_made_from_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = foxglove_images(tmp_path / "drive.mcap", demo_frames(2))
    before = source.read_bytes()
    assert run(source, tmp_path) == 2
    assert "would replace" in capsys.readouterr().err
    assert source.read_bytes() == before


def test_a_calibration_beside_the_file_is_preferred_to_the_one_in_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(foxglove_images(tmp_path / "a.mcap", demo_frames(2)), tmp_path / "first") == 0
    other = tmp_path / "first" / "drive.calibration.yaml"
    shipped = read_calibration(CALIBRATION)
    write_calibration(
        Calibration.from_camera(shipped.camera, shipped.image_size, reference_offset_m=1.5), other
    )
    capsys.readouterr()
    assert main(["run", str(tmp_path / "first" / "drive.mcap"), "--out", str(tmp_path / "second")]) == 0
    assert "from the file itself" not in capsys.readouterr().err
    assert DriveLog(tmp_path / "second" / "drive.mcap").header.calibration.reference_offset_m == 1.5
