"""Every clip of the real data, against OpenCV's reader and against the times in the files' own packets."""

from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from av.codec.context import CodecContext
from av.packet import Packet
from av.video.codeccontext import VideoCodecContext

from fcw.frame import VideoPacket
from fcw.sources import VideoSource, open_source

RELAYED = (
    "kb_dashcam1",
    "kb_dashcam2",
    "solidWhiteRight",
    "tmo_countryroad",
    "tmo_seattlestreet2",
    "udacity_test_small1",
    "udacity_test_small2",
    "udacity_test_video",
)
"""H.264 without B frames, as the slice types in the files say."""
NOT_RELAYED = ("muchlisin_driving", "udacity_project_video_cut")
"""B frames; MPEG-4 part 2."""
CLIPS = RELAYED + NOT_RELAYED


def decoder() -> VideoCodecContext:
    context = CodecContext.create("h264", "r")
    assert isinstance(context, VideoCodecContext)
    context.thread_type = "SLICE"
    return context


def test_the_clips_listed_here_are_all_there_are(data_dir: Path):
    assert {path.stem for path in (data_dir / "clips").glob("*.mp4")} == set(CLIPS)


def shown_times_ns(path: Path) -> list[int]:
    """Times of the packets to be shown, without decoding."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        packets = [packet for packet in container.demux(stream) if not packet.is_discard]
        assert stream.time_base is not None
        pts = sorted(packet.pts for packet in packets if packet.pts is not None)
        return [round(Fraction(p) * stream.time_base * 10**9) for p in pts]


@pytest.mark.parametrize("clip", CLIPS)
def test_frames_are_those_opencv_shows_at_the_streams_own_times(data_dir: Path, clip: str):
    path = data_dir / "clips" / f"{clip}.mp4"
    capture = cv2.VideoCapture(str(path))
    source = open_source(path)
    expected_ns = shown_times_ns(path)
    count = 0
    for frame in source.frames():
        shown, image = capture.read()
        assert shown
        assert frame.time_ns == expected_ns[count]
        # OpenCV counts from the first picture, and in floating-point milliseconds.
        since_start_ms = (frame.time_ns - expected_ns[0]) / 1e6
        assert capture.get(cv2.CAP_PROP_POS_MSEC) == pytest.approx(since_start_ms, abs=1e-5)
        assert frame.index == count
        assert np.array_equal(frame.image, image)
        count += 1
    assert not capture.read()[0]
    assert source.frame_count == count == len(expected_ns)
    assert source.notes == ()
    assert (source.image_size.width, source.image_size.height) == (
        capture.get(cv2.CAP_PROP_FRAME_WIDTH),
        capture.get(cv2.CAP_PROP_FRAME_HEIGHT),
    )


@pytest.mark.parametrize("clip", NOT_RELAYED)
def test_video_that_needs_reordering_or_another_codec_is_not_relayed(data_dir: Path, clip: str):
    source = open_source(data_dir / "clips" / f"{clip}.mp4")
    assert not source.relays_video
    assert next(source.frames()).packets == ()


@pytest.mark.parametrize("clip", RELAYED)
def test_relayed_packets_decode_to_the_same_pictures(data_dir: Path, clip: str):
    source = open_source(data_dir / "clips" / f"{clip}.mp4")
    assert source.relays_video
    context = decoder()
    packets: list[VideoPacket] = []
    decoded: list[av.VideoFrame] = []
    waiting: list[np.ndarray] = []
    seen = 0

    def compare() -> None:
        """Pictures of packets that are shown must be the frames', in order."""
        nonlocal seen
        while decoded:
            picture = decoded.pop(0)
            if packets[seen].shown:
                assert np.array_equal(picture.to_ndarray(format="bgr24"), waiting.pop(0))
            seen += 1

    for frame in source.frames():
        assert [packet.shown for packet in frame.packets] == [False] * (len(frame.packets) - 1) + [True]
        assert frame.packets[-1].time_ns == frame.time_ns
        for packet in frame.packets:
            assert packet.data.startswith((b"\0\0\0\1", b"\0\0\1"))
            kinds = [unit[0] & 31 for unit in packet.data.split(b"\0\0\1")[1:]]
            assert (5 in kinds) == packet.keyframe
            assert not packet.keyframe or kinds.index(7) < kinds.index(8) < kinds.index(5)
        packets += frame.packets
        waiting.append(frame.image)
        for packet in frame.packets:
            decoded += context.decode(Packet(packet.data))
        compare()
    decoded += context.decode(None)
    compare()
    assert seen == len(packets)
    assert waiting == []
    assert packets[0].keyframe
    times = [packet.time_ns for packet in packets]
    assert times == sorted(set(times))


@pytest.mark.parametrize("clip", RELAYED)
def test_packets_before_the_first_shown_frame_are_kept(data_dir: Path, clip: str):
    path = data_dir / "clips" / f"{clip}.mp4"
    with av.open(str(path)) as container:
        leading = 0
        for packet in container.demux(container.streams.video[0]):
            if not packet.is_discard:
                break
            leading += 1
    source = open_source(path)
    packets = next(source.frames()).packets
    assert len(packets) == leading + 1
    assert all(packet.time_ns < 0 for packet in packets[:-1])
    if clip in ("tmo_seattlestreet2", "udacity_test_small2"):
        assert leading > 0


@pytest.mark.parametrize("clip", ["tmo_seattlestreet2", "muchlisin_driving", "kb_dashcam2"])
def test_starting_later_gives_the_same_frames(data_dir: Path, clip: str):
    source = VideoSource(data_dir / "clips" / f"{clip}.mp4")
    times = [frame.time_ns for frame in source.frames()]
    for index in (0, 1, len(times) // 3, len(times) - 1):
        for start_ns in (times[index], times[index] - 1):
            frame = next(source.frames(start_ns))
            assert (frame.index, frame.time_ns) == (index, times[index])
            if source.relays_video:
                context = decoder()
                pictures = [p for packet in frame.packets for p in context.decode(Packet(packet.data))]
                pictures += context.decode(None)
                assert np.array_equal(pictures[-1].to_ndarray(format="bgr24"), frame.image)
    assert list(source.frames(times[-1] + 1)) == []
    assert next(source.frames(-(10**12))).index == 0
