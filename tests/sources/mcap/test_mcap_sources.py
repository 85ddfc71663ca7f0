"""MCAP files of others as drives: their pictures at their own times, and clear words where that cannot be."""

import tracemalloc
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_files import (
    DELAY_NS,
    DEMO,
    ROS_SCHEMAS,
    START_NS,
    demo_frames,
    encoded,
    foxglove_images,
    foxglove_raw_images,
    foxglove_video,
    ros_file,
    ros_image,
    ros_jpeg,
    ros_twist,
    stamp_ns,
)

from fcw.camera.file import calibration_text, read_calibration
from fcw.errors import UserError
from fcw.frame import Frame
from fcw.sources import open_source
from fcw.sources.mcap.facts import mcap_facts

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
PERIOD_NS = 33_333_333
CLOSE = 12.0
"""Grey levels by which JPEG changes a picture on the average, at most."""


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    return demo_frames(20)


def small(color: tuple[int, int, int] = (10, 120, 250)) -> np.ndarray:
    """A BGR picture of 6x4 with one other pixel, so that turned rows or swapped colours show."""
    image = np.full((4, 6, 3), color, np.uint8)
    image[1, 4] = (200, 30, 60)
    return image


def difference(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(a.astype(int) - b.astype(int)).mean())


def copy_messages(path: Path, writer: Writer) -> None:
    """Write all messages of a file of one topic and finish."""
    with path.open("rb") as file:
        topic: int | None = None
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            if topic is None:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                topic = writer.register_channel(channel.topic, channel.message_encoding, number)
            writer.add_message(topic, message.log_time, message.data, message.log_time)
    writer.finish()


@pytest.mark.parametrize("kind", ["foxglove jpeg", "foxglove raw", "ros jpeg"])
def test_pictures_come_at_their_own_stamps(kind: str, frames: list[Frame], tmp_path: Path) -> None:
    path = tmp_path / "drive.mcap"
    if kind == "foxglove jpeg":
        foxglove_images(path, frames)
    elif kind == "foxglove raw":
        foxglove_raw_images(path, frames[:6])
    else:
        ros_file(path, [("/camera", COMPRESSED, stamp_ns(f) + DELAY_NS, ros_jpeg(f)) for f in frames])
    source = open_source(path)
    read = list(source.frames())
    expected = frames[: len(read)]
    assert len(read) == (6 if kind == "foxglove raw" else 20) == source.frame_count
    assert [frame.time_ns for frame in read] == [stamp_ns(frame) for frame in expected]
    assert [frame.index for frame in read] == list(range(len(read)))
    assert max(difference(a.image, b.image) for a, b in zip(read, expected, strict=True)) < CLOSE
    assert source.frame_rate_hz == pytest.approx(30, rel=1e-3)
    assert (source.relays_video, source.notes, source.name) == (False, (), "drive.mcap")


def test_log_times_count_where_nobody_stamped(frames: list[Frame], tmp_path: Path) -> None:
    messages = [("/camera", COMPRESSED, stamp_ns(f) + DELAY_NS, ros_jpeg(f, time_ns=0)) for f in frames[:4]]
    source = open_source(ros_file(tmp_path / "drive.mcap", messages))
    assert [frame.time_ns for frame in source.frames()] == [stamp_ns(f) + DELAY_NS for f in frames[:4]]


def test_a_picture_nobody_stamped_is_on_the_clock_of_the_others(frames: list[Frame], tmp_path: Path) -> None:
    messages = [
        ("/camera", COMPRESSED, stamp_ns(frame) + DELAY_NS, ros_jpeg(frame, time_ns=0 if i == 1 else None))
        for i, frame in enumerate(frames[:4])
    ]
    source = open_source(ros_file(tmp_path / "drive.mcap", messages))
    assert [frame.time_ns for frame in source.frames()] == [stamp_ns(frame) for frame in frames[:4]]


@pytest.mark.parametrize(
    ("encoding", "encoded"),
    [
        ("bgr8", small()),
        ("rgb8", small()[..., ::-1]),
        ("bgra8", cv2.cvtColor(small(), cv2.COLOR_BGR2BGRA)),
        ("rgba8", cv2.cvtColor(small(), cv2.COLOR_BGR2RGBA)),
        ("8UC3", small()),
    ],
)
@pytest.mark.parametrize("padding", [0, 5])
def test_raw_pictures_of_ros(encoding: str, encoded: np.ndarray, padding: int, tmp_path: Path) -> None:
    message = ros_image(np.ascontiguousarray(encoded), encoding, START_NS, padding)
    (frame,) = open_source(
        ros_file(tmp_path / "drive.mcap", [("/camera", IMAGE, START_NS, message)])
    ).frames()
    assert np.array_equal(frame.image, small())


def test_grey_pictures_of_ros(tmp_path: Path) -> None:
    grey = np.arange(24, dtype=np.uint8).reshape(4, 6)
    message = ros_image(grey[..., None], "mono8", START_NS)
    (frame,) = open_source(
        ros_file(tmp_path / "drive.mcap", [("/camera", IMAGE, START_NS, message)])
    ).frames()
    assert np.array_equal(frame.image, np.repeat(grey[..., None], 3, axis=2))


def demo_packets(count: int) -> list[tuple[int, bytes]]:
    frames = islice(open_source(DEMO / "drive.mp4").frames(), count)
    return [(stamp_ns(frame), packet.data) for frame in frames for packet in frame.packets]


def test_h264_is_relayed_packet_by_packet(frames: list[Frame], tmp_path: Path) -> None:
    source = open_source(foxglove_video(tmp_path / "drive.mcap", demo_packets(20)))
    assert source.relays_video
    read = list(source.frames())
    assert [frame.time_ns for frame in read] == [stamp_ns(frame) for frame in frames]
    assert [[p.data for p in frame.packets] for frame in read] == [
        [p.data for p in frame.packets] for frame in frames
    ]
    assert all(packet.time_ns == frame.time_ns for frame in read for packet in frame.packets)
    assert max(difference(a.image, b.image) for a, b in zip(read, frames, strict=True)) < 1


def test_seeking_gives_the_same_frames_as_reading_on(tmp_path: Path) -> None:
    source = open_source(foxglove_video(tmp_path / "drive.mcap", demo_packets(80)))
    read = list(source.frames())
    for number in (0, 1, 45, 79):
        sought = next(source.frames(read[number].time_ns))
        assert (sought.index, sought.time_ns) == (number, read[number].time_ns)
        assert np.array_equal(sought.image, read[number].image)
        assert sought.packets[-1] == read[number].packets[-1]
        assert sought.packets[0].keyframe


def test_pictures_are_found_by_their_stamp_though_logged_later(frames: list[Frame], tmp_path: Path) -> None:
    source = open_source(foxglove_images(tmp_path / "drive.mcap", frames))
    assert [frame.index for frame in source.frames(stamp_ns(frames[13]))] == list(range(13, 20))
    assert next(source.frames(stamp_ns(frames[13]) + 1)).index == 14


@pytest.mark.slow
def test_a_recording_that_begins_between_two_keyframes_begins_at_the_next(tmp_path: Path) -> None:
    packets = demo_packets(100)
    whole = open_source(foxglove_video(tmp_path / "whole.mcap", packets))
    second = [i for i, frame in enumerate(whole.frames()) if frame.packets[-1].keyframe][1]
    cut = open_source(foxglove_video(tmp_path / "cut.mcap", packets[5:]))
    assert cut.relays_video
    read = list(cut.frames())
    assert read[0].time_ns == packets[second][0]
    assert (len(read), read[0].index) == (100 - second, 0)
    left_out = f"{tmp_path / 'cut.mcap'}: /video: {second - 5} pictures before the first keyframe left out"
    assert cut.notes == (left_out,)
    assert not whole.notes
    next(cut.frames(read[40].time_ns))
    assert cut.notes == (left_out,)


@pytest.mark.parametrize(
    ("video_format", "codec_name", "options"),
    [
        ("h264", "libx264", {"bf": "3", "b-adapt": "0"}),  # against Foxglove's rules, but it happens
        ("h265", "libx265", {"preset": "ultrafast", "x265-params": "log-level=none:bframes=0"}),
        ("vp9", "libvpx-vp9", {"deadline": "realtime", "lag-in-frames": "0"}),
    ],
)
def test_other_video_is_decoded_and_not_relayed(
    video_format: str, codec_name: str, options: dict[str, str], frames: list[Frame], tmp_path: Path
) -> None:
    packets = encoded(frames, codec_name, options)
    source = open_source(foxglove_video(tmp_path / "drive.mcap", packets, video_format))
    read = list(source.frames())
    assert not source.relays_video
    assert [frame.time_ns for frame in read] == [stamp_ns(frame) for frame in frames]
    assert all(frame.packets == () for frame in read)
    for frame, original in zip(read, frames, strict=True):
        assert difference(frame.image, cv2.resize(original.image, (320, 180))) < CLOSE
    assert next(source.frames(read[9].time_ns)).index == 9


def test_several_cameras_without_a_choice_are_listed(frames: list[Frame], tmp_path: Path) -> None:
    path = foxglove_images(tmp_path / "drive.mcap", frames[:2], ["/front", "/rear"])
    with pytest.raises(UserError) as told:
        open_source(path)
    assert "drive.mcap: several topics of pictures" in str(told.value)
    assert "/front (foxglove.CompressedImage); /rear (foxglove.CompressedImage)" in str(told.value)
    assert "--topic" in str(told.value)
    assert len(list(open_source(path, topic="/rear").frames())) == 2


def test_a_topic_that_is_not_there_lists_those_that_are(frames: list[Frame], tmp_path: Path) -> None:
    path = foxglove_images(tmp_path / "drive.mcap", frames[:2], ["/front"])
    with pytest.raises(UserError, match=r"--topic /top: no such topic; expected one of: /front \(foxglove"):
        open_source(path, topic="/top")


def test_a_file_without_pictures_says_what_it_holds(tmp_path: Path) -> None:
    twist = ("/speed", "geometry_msgs/msg/TwistStamped", START_NS, ros_twist(START_NS, 3.0))
    path = ros_file(tmp_path / "drive.mcap", [twist])
    with pytest.raises(UserError, match=r"no topic of pictures.*it holds: /speed \(geometry_msgs/TwistStam"):
        open_source(path)
    with pytest.raises(
        UserError,
        match=r"--topic /speed: a topic of geometry_msgs/TwistStamped, which is not a type of pictures",
    ):
        open_source(path, topic="/speed")


def test_a_topic_is_no_choice_in_a_video() -> None:
    with pytest.raises(UserError, match=r"--topic /camera was given, but only MCAP files have topics"):
        open_source(DEMO / "drive.mp4", topic="/camera")


@pytest.mark.parametrize("content", [b"", b"not at all MCAP, but long enough to be read as one"])
def test_another_file_of_that_name_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "drive.mcap"
    path.write_bytes(content)
    with pytest.raises(UserError, match=r"drive\.mcap: not an MCAP file"):
        open_source(path)


def test_an_unknown_encoding_is_named_with_those_that_are_read(tmp_path: Path) -> None:
    message = ros_image(np.zeros((4, 6, 2), np.uint8), "16UC1", START_NS)
    path = ros_file(tmp_path / "drive.mcap", [("/depth", IMAGE, START_NS, message)])
    with pytest.raises(UserError, match=r"/depth \(sensor_msgs/Image\): .*'16UC1'; expected one of bgr8"):
        open_source(path)


def test_an_unknown_video_format_is_named(tmp_path: Path) -> None:
    path = foxglove_video(tmp_path / "drive.mcap", [(START_NS, b"?")], "theora")
    with pytest.raises(UserError, match="'theora'; expected one of h264, h265, vp9, av1"):
        open_source(path)


def test_pictures_that_cannot_be_decoded_or_stand_back_in_time_are_left_out(
    frames: list[Frame], tmp_path: Path
) -> None:
    messages = [("/camera", COMPRESSED, stamp_ns(f), ros_jpeg(f)) for f in frames[:6]]
    messages[2][3].data = b"no jpeg"
    messages[4] = ("/camera", COMPRESSED, stamp_ns(frames[4]), ros_jpeg(frames[4], stamp_ns(frames[3])))
    source = open_source(ros_file(tmp_path / "drive.mcap", messages))
    assert [f.time_ns for f in source.frames()] == [stamp_ns(frames[i]) for i in (0, 1, 3, 5)]
    undecodable, late = source.notes
    assert "1 picture that cannot be decoded, left out" in undecodable
    assert "1 picture with a time not after the one before, left out" in late


@pytest.mark.parametrize("part", [0.3, 0.7, 0.99])
def test_a_torn_file_gives_its_beginning_and_says_so(
    part: float, frames: list[Frame], tmp_path: Path
) -> None:
    whole, torn = tmp_path / "whole.mcap", tmp_path / "torn.mcap"
    messages = [("/camera", COMPRESSED, stamp_ns(f), ros_jpeg(f)) for f in frames]
    ros_file(whole, messages, chunk_size=200_000)  # as recorders that fear for their data write them
    data = whole.read_bytes()
    torn.write_bytes(data[: int(len(data) * part)])
    source = open_source(torn)
    read = list(source.frames())
    assert [frame.time_ns for frame in read] == [stamp_ns(frame) for frame in frames[: len(read)]]
    assert len(read) >= part * 20 - 4
    assert "torn.mcap: the file was never finished" in source.notes[-1]


def test_times_of_no_calendar_are_damage(frames: list[Frame], tmp_path: Path) -> None:
    """MCAP counts nanoseconds up to the year 2554; times here end in 2262."""
    messages = [("/camera", COMPRESSED, stamp_ns(f), ros_jpeg(f, time_ns=0)) for f in frames[:3]]
    late = [("/camera", COMPRESSED, 2**63 + i, ros_jpeg(f, time_ns=0)) for i, f in enumerate(frames[:3])]
    source = open_source(ros_file(tmp_path / "drive.mcap", messages + late))
    assert [frame.time_ns for frame in source.frames()] == [stamp_ns(f) for f in frames[:3]]
    assert "the file was never finished or is damaged" in source.notes[-1]
    with pytest.raises(UserError, match="none of its first 32 pictures can be decoded"):
        open_source(ros_file(tmp_path / "late.mcap", late))


def test_files_without_chunks_or_index_are_read(frames: list[Frame], tmp_path: Path) -> None:
    original = foxglove_images(tmp_path / "indexed.mcap", frames[:5])
    path = tmp_path / "drive.mcap"
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=False, use_summary_offsets=False, use_statistics=False)
        writer.start()
        copy_messages(original, writer)
    source = open_source(path)
    assert [frame.time_ns for frame in source.frames()] == [stamp_ns(frame) for frame in frames[:5]]


@pytest.mark.slow
def test_memory_does_not_grow_with_the_file(tmp_path: Path) -> None:
    """40 raw pictures of 2.8 MB in chunks of one each: a reader that held them all would need 110 MB."""
    frames = [frame for frame in demo_frames(2) for _ in range(20)]
    frames = [Frame(i, i * PERIOD_NS, frame.image) for i, frame in enumerate(frames)]
    source = open_source(foxglove_raw_images(tmp_path / "drive.mcap", frames))
    tracemalloc.start()
    count = sum(1 for _ in source.frames())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert count == 40
    assert peak < 35e6


def test_own_speed_is_found_at_the_stamps_of_the_pictures(frames: list[Frame], tmp_path: Path) -> None:
    twist = "geometry_msgs/msg/TwistStamped"
    messages = [
        item
        for frame in frames[:4]
        for time_ns in (stamp_ns(frame),)
        for item in (
            ("/camera", COMPRESSED, time_ns + DELAY_NS, ros_jpeg(frame)),
            ("/cmd_vel", twist, time_ns, ros_twist(time_ns, 99.0)),
            ("/vehicle/twist", twist, time_ns + 3 * DELAY_NS, ros_twist(time_ns, 20.0 + frame.index)),
        )
    ]
    facts = mcap_facts(ros_file(tmp_path / "drive.mcap", messages))
    assert facts.ego_speed is not None
    speeds = [facts.ego_speed.at(stamp_ns(frame)) for frame in frames[:4]]
    assert speeds == pytest.approx([20, 21, 22, 23], abs=1e-3)
    assert facts.notes == ("drive.mcap: own speed from /vehicle/twist (geometry_msgs/TwistStamped)",)


@pytest.mark.parametrize(
    ("kind", "field"),
    [(COMPRESSED, "string format"), (COMPRESSED, "uint8[] data"), (IMAGE, "string encoding")],
)
def test_pictures_whose_schema_lacks_a_field_of_its_name_cannot_be_decoded(
    kind: str, field: str, frames: list[Frame], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = ros_jpeg(frames[0]) if kind == COMPRESSED else ros_image(small(), "bgr8", START_NS)
    name = field.split()[1]
    monkeypatch.setitem(ROS_SCHEMAS, kind, ROS_SCHEMAS[kind].replace(field, f"{field}_of_theirs"))
    setattr(picture, f"{name}_of_theirs", getattr(picture, name))
    path = ros_file(tmp_path / "drive.mcap", [("/camera", kind, START_NS, picture)])
    with pytest.raises(UserError, match="none of its first 32 pictures can be decoded"):
        open_source(path)


@pytest.mark.parametrize("theirs", ["uint32 nanoseconds", "string nanosec"])
def test_stamps_and_speeds_that_are_not_what_their_names_say_are_not_used(
    theirs: str, frames: list[Frame], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    twist = "geometry_msgs/msg/TwistStamped"
    speed = ROS_SCHEMAS[twist].replace("Vector3 linear", "Vector3 forwards")
    stamp = ROS_SCHEMAS[COMPRESSED].replace("uint32 nanosec", theirs)
    for kind, schema in ((twist, speed), (COMPRESSED, stamp)):
        monkeypatch.setitem(ROS_SCHEMAS, kind, schema)
    picture, motion = ros_jpeg(frames[0]), ros_twist(START_NS, 5.0)
    motion.twist.forwards = motion.twist.linear
    picture.header.stamp.nanoseconds, picture.header.stamp.nanosec = 5, "five" if "string" in theirs else 5
    messages = [("/camera", COMPRESSED, START_NS + DELAY_NS, picture), ("/twist", twist, START_NS, motion)]
    path = ros_file(tmp_path / "drive.mcap", messages)
    assert [frame.time_ns for frame in open_source(path).frames()] == [START_NS + DELAY_NS]
    assert mcap_facts(path).ego_speed is None


def test_two_speeds_of_one_kind_are_told_and_none_is_used(frames: list[Frame], tmp_path: Path) -> None:
    twist = "geometry_msgs/msg/TwistStamped"
    messages = [("/camera", COMPRESSED, START_NS, ros_jpeg(frames[0]))]
    messages += [(topic, twist, START_NS, ros_twist(START_NS, 5.0)) for topic in ("/gps/vel", "/wheels/vel")]
    facts = mcap_facts(ros_file(tmp_path / "drive.mcap", messages))
    assert facts.ego_speed is None
    assert "/gps/vel or /wheels/vel" in facts.notes[0]
    assert "--ego-speed" in facts.notes[0]


def test_an_attached_calibration_is_found(frames: list[Frame], tmp_path: Path) -> None:
    calibration = read_calibration(DEMO / "drive.calibration.yaml")
    path = tmp_path / "drive.mcap"
    original = foxglove_images(tmp_path / "plain.mcap", frames[:3])
    assert mcap_facts(original).calibration is None
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        text = calibration_text(calibration)
        writer.add_attachment(0, 0, "calibration.yaml", "application/yaml", text.encode())
        copy_messages(original, writer)
    assert mcap_facts(path).calibration == calibration
