"""The MCAP log: everything comes back, others can read it, and what is drawn is where it should be."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial.transform import Rotation
from searching import examples

from fcw.errors import UserError
from fcw.frame import VideoPacket
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.messages import result_from_message, result_message
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.overlay import LEVEL_COLORS, OTHER_TRACK_COLOR
from fcw.logs.records import DriveHeader, FrameResult
from fcw.sources import open_source
from fcw.warning.types import WarningLevel, WarningState

Drive = list[tuple[FrameResult, tuple[VideoPacket, ...]]]
SCHEMAS = {
    "/camera/image": "foxglove.CompressedVideo",
    "/camera/calibration": "foxglove.CameraCalibration",
    "/camera/annotations": "foxglove.ImageAnnotations",
    "/scene": "foxglove.SceneUpdate",
    "/tf": "foxglove.FrameTransforms",
    "/log": "foxglove.Log",
    "/fcw/frame": "fcw.FrameResult",
    "/fcw/lead": "fcw.Track",
    "/fcw/warning": "fcw.WarningState",
    "/fcw/video_index": "fcw.VideoPacket",
}


def write_log(path: Path, header: DriveHeader, drive: Drive) -> DriveLog:
    sink = McapSink(path)
    sink.open(header)
    for result, packets in drive:
        sink.write(result, packets)
    sink.close()
    return DriveLog(path)


def foreign_read(path: Path, *topics: str) -> list[tuple[str, str, int, Any]]:
    """Topic, schema, log time and message as any protobuf reader of MCAP sees them."""
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [
            (channel.topic, schema.name if schema else "", message.log_time, decoded)
            for schema, channel, message, decoded in reader.iter_decoded_messages(topics or None)
        ]


@given(data=st.data())
def test_results_come_back_bit_for_bit_from_their_messages(any_frame_result, data):
    result = data.draw(any_frame_result)
    back = result_from_message(result_message(result).SerializeToString())
    assert back == result
    assert repr(back) == repr(result)  # tells 0.0 from -0.0, an int from a float, a level from its number


@examples(25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_log_gives_back_all_it_was_given(any_frame_result, header, tmp_path, data):
    drawn = data.draw(st.lists(any_frame_result, max_size=4))
    results = [replace(result, index=index) for index, result in enumerate(drawn)]
    packet = st.builds(
        VideoPacket, st.binary(max_size=30), st.integers(-(2**62), 2**62), st.booleans(), st.booleans()
    )
    drive = [(result, tuple(data.draw(st.lists(packet, max_size=3)))) for result in results]
    log = write_log(tmp_path / "drive.mcap", header, drive)
    assert log.complete
    assert list(log.entries()) == drive
    assert repr(list(log.results())) == repr(results)
    assert list(log.video_packets()) == [packet for _, packets in drive for packet in packets]


@pytest.mark.parametrize("imperial", [True, False])
def test_the_header_comes_back(header, short_drive, tmp_path, imperial: bool):
    fields = {name: getattr(header, name) for name in DriveHeader.__dataclass_fields__}
    zero_utc_ns = 1_622_530_320 * 10**9
    dated = {"zero_utc_ns": zero_utc_ns, "gpx": b"<gpx/>", "gpx_begins_ns": -5} if imperial else {}
    header = DriveHeader(**{**fields, **dated, "imperial": imperial, "relays_video": imperial})
    assert write_log(tmp_path / "drive.mcap", header, short_drive[:3]).header == header


def test_a_log_of_no_frames_is_a_log(header, tmp_path):
    log = write_log(tmp_path / "drive.mcap", header, [])
    assert log.complete
    assert log.header == header
    assert list(log.entries()) == []


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="needs Linux's disk that is always full")
def test_a_full_disk_is_said_with_what_to_do(header, short_drive):
    with pytest.raises(UserError, match="No space left on device\\); make room on the disk and run again"):
        write_log(Path("/dev/full"), header, short_drive)


def test_others_see_every_topic_with_its_schema_and_rising_times(header, short_drive, tmp_path):
    path = tmp_path / "drive.mcap"
    write_log(path, header, short_drive)
    seen = foreign_read(path)
    assert {topic: schema for topic, schema, _, _ in seen} == SCHEMAS
    times = [time for _, _, time, _ in seen]
    assert times == sorted(times)
    counts = {topic: sum(other == topic for other, *_ in seen) for topic in SCHEMAS}
    assert counts["/fcw/frame"] == counts["/fcw/warning"] == counts["/camera/annotations"] == 100
    assert counts["/camera/image"] == counts["/fcw/video_index"] == 102
    assert counts["/log"] == 3
    with path.open("rb") as file:
        reader = make_reader(file)
        attachment, series = reader.iter_attachments()
        records = {record.name: record.metadata for record in reader.iter_metadata()}
    assert (attachment.name, series.name) == ("calibration.yaml", "drive.series")
    assert b"reference_offset_m: 1.7" in attachment.data
    assert records["fcw.versions"] == header.versions
    assert records["fcw.drive"]["model_sha256"] == header.model_sha256


def test_every_message_has_the_time_of_its_frame(header, short_drive, tmp_path):
    path = tmp_path / "drive.mcap"
    write_log(path, header, short_drive)
    for topic, _, log_time, message in foreign_read(path):
        if topic in ("/camera/image", "/camera/calibration", "/log"):
            assert message.timestamp.ToNanoseconds() == log_time
        elif topic == "/camera/annotations":
            stamps = [item.timestamp.ToNanoseconds() for item in (*message.points, *message.texts)]
            assert set(stamps) == {log_time}
        elif topic == "/scene":
            assert {item.timestamp.ToNanoseconds() for item in message.entities} == {log_time}
        elif topic == "/fcw/frame":
            assert message.time_ns == log_time


def test_packets_before_the_first_frame_are_kept_in_order_and_marked(header, short_drive, tmp_path):
    path = tmp_path / "drive.mcap"
    write_log(path, header, short_drive)
    images = [(time, message.data) for _, _, time, message in foreign_read(path, "/camera/image")]
    assert images[:4] == [(0, b"feed -2"), (0, b"feed -1"), (0, b"picture 0"), (10**8, b"picture 1")]
    index = [message for *_, message in foreign_read(path, "/fcw/video_index")]
    assert [(m.time_ns, m.keyframe, m.shown, m.frame_index) for m in index[:4]] == [
        (-200_000_000, True, False, 0),
        (-100_000_000, False, False, 0),
        (0, True, True, 0),
        (100_000_000, False, True, 1),
    ]


def test_boxes_and_rows_are_drawn_where_they_are(header, short_drive, tmp_path):
    path = tmp_path / "drive.mcap"
    write_log(path, header, short_drive[:1])
    ((*_, message),) = foreign_read(path, "/camera/annotations")
    other, lead, rows = message.points
    # Foxglove counts from the corner of the top-left pixel, we from its centre.
    assert [(p.x, p.y) for p in lead.points] == [
        (600.5, 380.5),
        (680.5, 380.5),
        (680.5, 440.5),
        (600.5, 440.5),
    ]
    assert lead.type == other.type == lead.LINE_LOOP
    assert lead.thickness > other.thickness
    labels = [text.text for text in message.texts]
    assert labels[0] == "20 m  2.5 s"  # the other one is no rival of the lead
    distances_m = [float(label.split()[0]) for label in labels[1:]]
    assert distances_m[0] == 5
    expected = [header.calibration.row_at(distance_m) + 0.5 for distance_m in distances_m]
    assert [point.y for point in rows.points] == pytest.approx(np.repeat(expected, 2), abs=1 / 32)
    assert {point.x for point in rows.points} == {0, 1280}


def test_the_road_meets_the_picture_through_the_transform_and_the_calibration(header, short_drive, tmp_path):
    path = tmp_path / "drive.mcap"
    write_log(path, header, short_drive[:1])
    ((*_, transforms),) = foreign_read(path, "/tf")
    ((*_, camera),) = foreign_read(path, "/camera/calibration")
    (mount,) = transforms.transforms
    assert (mount.parent_frame_id, mount.child_frame_id, camera.frame_id) == ("ego", "camera", "camera")
    q, t = mount.rotation, mount.translation
    to_camera = Rotation.from_quat([q.x, q.y, q.z, q.w]).inv()
    matrix = np.reshape(list(camera.K), (3, 3))
    assert (camera.width, camera.height) == (1280, 720)
    for distance_m, lateral_m in ((5.0, 0.0), (12.0, 1.8), (40.0, -3.5), (150.0, 6.0)):
        ray = to_camera.apply(np.array([distance_m, lateral_m, 0.0]) - [t.x, t.y, t.z])
        column, row, _ = matrix @ ray / ray[2]
        assert row == pytest.approx(header.calibration.row_at(distance_m), abs=1e-6)
        assert column == pytest.approx(header.calibration.column_at(lateral_m, distance_m), abs=1e-6)


def test_vehicles_stand_on_the_road_at_their_distance(header, short_drive, tmp_path):
    path = tmp_path / "drive.mcap"
    write_log(path, header, short_drive[20:21])
    ((*_, scene),) = foreign_read(path, "/scene")
    vehicles, ego = scene.entities
    assert vehicles.frame_id == ego.frame_id == "ego"
    other, lead = vehicles.cubes
    for cube, distance_m, lateral_m in ((other, 30.0, 5.0), (lead, 20.0, 0.25)):
        assert cube.pose.position.x - cube.size.x / 2 == pytest.approx(distance_m)
        assert cube.pose.position.y == pytest.approx(lateral_m)
        assert cube.pose.position.z == pytest.approx(cube.size.z / 2, abs=1e-3)
    # 80 px wide at 20 m from the bumper, 21.7 m from the camera, f 1000 px, 2 degrees down.
    depth_m = 21.7 * math.cos(0.035) + 1.4 * math.sin(0.035)
    assert lead.size.y == pytest.approx(80 * depth_m / 1000, abs=1e-3)
    assert [text.text for text in vehicles.texts] == ["7: 20 m  2.5 s"]
    colors = [
        tuple(round(255 * c) for c in (cube.color.r, cube.color.g, cube.color.b)) for cube in (other, lead)
    ]
    assert colors == [OTHER_TRACK_COLOR, LEVEL_COLORS[WarningLevel.CAUTION]]
    assert ego.cubes[0].pose.position.x + ego.cubes[0].size.x / 2 == pytest.approx(0)


def test_the_log_says_each_change_of_level_and_why(header, short_drive, tmp_path):
    path = tmp_path / "drive.mcap"
    write_log(path, header, short_drive)
    said = [(time, message.level, message.message) for *_, time, message in foreign_read(path, "/log")]
    assert [time for time, *_ in said] == [2 * 10**9, 5 * 10**9, 6 * 10**9]
    assert [level for _, level, _ in said] == [3, 4, 2]  # foxglove.Log: WARNING, ERROR, INFO
    assert "collision in 2.5 s" in said[1][2]
    assert "vehicle 7 at 20 m" in said[1][2]


def test_a_lead_that_is_gone_is_said_once_with_figures_that_break_a_plots_line(header, short_drive, tmp_path):
    free = [
        FrameResult(index, (index - 90) * 10**9, (), (), None, WarningState(WarningLevel.NONE), None)
        for index in (100, 101)
    ]
    again = [replace(result, index=102, time_ns=12 * 10**9) for result, _ in short_drive[-1:]]
    path = tmp_path / "drive.mcap"
    write_log(path, header, [*short_drive, *((result, ()) for result in (*free, *again))])
    leads = [message for *_, message in foreign_read(path, "/fcw/lead")]
    assert [message.track_id for message in leads] == [7] * 100 + [-1, 7]
    gone = leads[100]
    assert gone.HasField("ttc_s")
    assert all(math.isnan(getattr(gone, name)) for name in ("distance_m", "ttc_s", "closing_speed_mps"))


def test_a_new_log_replaces_a_longer_old_one(header, short_drive, tmp_path):
    path = tmp_path / "drive.mcap"
    write_log(path, header, short_drive)
    assert [result.index for result in write_log(path, header, short_drive[:2]).results()] == [0, 1]


def test_a_log_that_cannot_be_written(header, tmp_path):
    with pytest.raises(UserError, match=r"drive\.mcap: cannot write the log \(No such file or directory\)"):
        McapSink(tmp_path / "nowhere" / "drive.mcap").open(header)


def test_closing_twice_or_without_opening_does_nothing(header, tmp_path):
    path = tmp_path / "drive.mcap"
    sink = McapSink(path)
    sink.close()
    assert not path.exists()
    sink.open(header)
    sink.close()
    size = path.stat().st_size
    sink.close()
    assert path.stat().st_size == size


@pytest.mark.parametrize("clip", ["tmo_seattlestreet2", "udacity_test_small2", "muchlisin_driving"])
def test_the_video_of_a_clip_comes_back_packet_for_packet(data_dir, header, tmp_path, clip: str):
    source = open_source(data_dir / "clips" / f"{clip}.mp4")
    encoder = None if source.relays_video else VideoEncoder(source.image_size, source.frame_rate_hz)
    drive: Drive = []
    for frame in source.frames():
        result = FrameResult(frame.index, frame.time_ns, (), (), None, WarningState(WarningLevel.NONE), None)
        drive.append((result, encoder.encode(frame) if encoder else frame.packets))
    log = write_log(tmp_path / "drive.mcap", header, drive)
    assert list(log.entries()) == drive
    shown = [packet.time_ns for packet in log.video_packets() if packet.shown]
    assert shown == [result.time_ns for result in log.results()]
    not_shown = sum(not packet.shown for packet in log.video_packets())
    assert not_shown == {"tmo_seattlestreet2": 45, "udacity_test_small2": 15}.get(clip, 0)
