"""Pictures of a log by the number of their frame."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.frame import Frame, ImageSize, VideoPacket
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.pictures import LogPictures
from fcw.logs.records import DriveHeader, FrameResult
from fcw.sources import open_source
from fcw.warning.types import WarningLevel, WarningState

PERIOD_NS = 40_000_000
FRAMES = 90


def picture(index: int, size: ImageSize) -> NDArray[np.uint8]:
    """A grey picture with its number in binary as eight wide bars, and a pattern at its edges."""
    image = np.full((size.height, size.width, 3), 120, np.uint8)
    bars = np.array_split(np.arange(size.width), 8)
    for bit, columns in enumerate(bars):
        image[:, columns] = 220 if index >> bit & 1 else 40
    return image


def number(image: NDArray[np.uint8]) -> int:
    bars = np.array_split(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), 8, axis=1)
    return sum((bar.mean() > 130) << bit for bit, bar in enumerate(bars))


def drive_log(path: Path, header: DriveHeader, size: ImageSize, keep: Callable[[int], bool]) -> DriveLog:
    """A log whose frame k is picture k; pictures for which `keep` is False are missing."""
    fields = {name: getattr(header, name) for name in DriveHeader.__dataclass_fields__}
    header = DriveHeader(**{**fields, "image_size": size, "frame_rate_hz": 25.0, "relays_video": False})
    encoder = VideoEncoder(size, 25.0)
    sink = McapSink(path)
    sink.open(header)
    for index in range(FRAMES):
        frame = Frame(index, index * PERIOD_NS, picture(index, size))
        result = FrameResult(index, frame.time_ns, (), (), None, WarningState(WarningLevel.NONE), None)
        packets = encoder.encode(frame)
        sink.write(result, packets if keep(index) else ())
    encoder.close()
    sink.close()
    return DriveLog(path)


@pytest.mark.parametrize("size", [ImageSize(160, 96), ImageSize(161, 97)])
def test_any_picture_is_the_one_of_its_frame(header, tmp_path, size: ImageSize):
    log = drive_log(tmp_path / "drive.mcap", header, size, lambda index: True)
    pictures = LogPictures(log)
    order = [0, 0, 1, 2, 50, 51, 49, 89, 3, 24, 25, 26, 60, 61, 75, 74, 88]
    order += np.random.default_rng(0).integers(0, FRAMES, 40).tolist()
    for index in order:
        image = pictures.at(index)
        assert image.shape == (size.height, size.width, 3)
        assert number(image) == index
    pictures.close()
    assert number(pictures.at(7)) == 7


def test_a_jump_gives_the_same_pixels_as_going_there(header, tmp_path):
    log = drive_log(tmp_path / "drive.mcap", header, ImageSize(160, 96), lambda index: True)
    pictures = LogPictures(log)
    in_order = [pictures.at(index).copy() for index in range(FRAMES)]
    for index in (70, 30, 88, 12):
        np.testing.assert_array_equal(LogPictures(log).at(index), in_order[index])


def test_there_is_a_keyframe_each_second_and_no_picture_waits_for_a_later_one(header, tmp_path):
    log = drive_log(tmp_path / "drive.mcap", header, ImageSize(160, 96), lambda index: True)
    assert log.series().keyframe_ns.tolist() == [0, 1_000_000_000, 2_000_000_000, 3_000_000_000]
    times_ns = [packet.time_ns for packet in log.video_packets()]
    assert times_ns == sorted(times_ns)


def test_a_missing_picture_is_said_and_others_still_come(header, tmp_path):
    log = drive_log(tmp_path / "drive.mcap", header, ImageSize(160, 96), lambda index: index < 80)
    pictures = LogPictures(log)
    assert number(pictures.at(79)) == 79
    with pytest.raises(UserError, match=r"drive\.mcap: no picture of frame 80 at 3\.200 s"):
        pictures.at(80)
    assert number(pictures.at(79)) == 79
    with pytest.raises(IndexError):
        pictures.at(FRAMES)


def test_damaged_pictures_do_not_take_later_ones_with_them(header, tmp_path):
    log = drive_log(tmp_path / "drive.mcap", header, ImageSize(160, 96), lambda index: True)
    data = bytearray(log.path.read_bytes())
    damaged = next(
        chunk
        for chunk in log.chunks.chunks
        if chunk.message_start_time >= 1_000_000_000
        and log.chunks.topics[next(iter(chunk.message_index_offsets))] == "/camera/image"
    )
    middle = damaged.chunk_start_offset + damaged.chunk_length // 2
    data[middle : middle + 20] = bytes(20)
    log.path.write_bytes(data)
    with pytest.raises(UserError, match=r"drive\.mcap: the log is damaged"):
        list(DriveLog(log.path).video_packets())
    salvaged = DriveLog(log.path, pass_over_damage=True)
    packets = list(salvaged.video_packets())
    lost = [k * PERIOD_NS for k in range(FRAMES) if k * PERIOD_NS not in {p.time_ns for p in packets}]
    # From the damage up to the next keyframe: what came after in between cannot be decoded.
    assert lost == list(range(1_000_000_000, 2_000_000_000, PERIOD_NS))
    assert len(list(salvaged.results())) == FRAMES
    pictures = LogPictures(salvaged)
    assert [number(pictures.at(index)) for index in (24, 50, 70)] == [24, 50, 70]
    with pytest.raises(UserError, match="no picture of frame 40"):
        pictures.at(40)


@pytest.mark.parametrize("clip", ["tmo_seattlestreet2", "kb_dashcam1"])
def test_pictures_of_a_relayed_clip_are_the_sources(data_dir, header, tmp_path, clip: str):
    source = open_source(data_dir / "clips" / f"{clip}.mp4")
    assert source.relays_video
    fields = {name: getattr(header, name) for name in DriveHeader.__dataclass_fields__}
    sink = McapSink(tmp_path / "drive.mcap")
    sink.open(DriveHeader(**{**fields, "image_size": source.image_size}))
    wanted = {3, 90, 91, 200, 333}
    images: dict[int, NDArray[np.uint8]] = {}
    for frame in source.frames():
        result = FrameResult(frame.index, frame.time_ns, (), (), None, WarningState(WarningLevel.NONE), None)
        packets: tuple[VideoPacket, ...] = frame.packets
        sink.write(result, packets)
        if frame.index in wanted:
            images[frame.index] = frame.image
        if frame.index == max(wanted):
            break
    sink.close()
    pictures = LogPictures(DriveLog(tmp_path / "drive.mcap"))
    for index in (333, 3, 90, 91, 200):
        np.testing.assert_array_equal(pictures.at(index), images[index])
