"""Video whose pictures refer to later ones: packets are decoded in their order, or what is lost is told."""

import re
from pathlib import Path

import av
import numpy as np
import pytest
from mcap_files import demo_frames, encoded, foxglove_video, stamp_ns

from fcw.errors import UserError
from fcw.frame import Frame
from fcw.sources import open_source

SLOW = {"g": "12"}
CODECS = {
    "h264": ("libx264", {"bf": "2", "x264-params": "repeat-headers=1:annexb=1", **SLOW}),
    "h265": ("libx265", {"x265-params": "bframes=3:keyint=12:repeat-headers=1:log-level=none", **SLOW}),
}
DECODERS = {"h264": "h264", "h265": "hevc"}

START_CODE = b"\0\0\0\1"

Packets = list[tuple[int, bytes]]


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    return demo_frames(30)


@pytest.fixture(params=CODECS)
def coded(request: pytest.FixtureRequest, frames: list[Frame]) -> tuple[str, Packets]:
    """The format, and the packets in decoding order with the times of their pictures."""
    packets = encoded(frames, *CODECS[request.param])
    times_ns = [time_ns for time_ns, _ in packets]
    assert times_ns != sorted(times_ns)
    return request.param, packets


def decoded(packets: Packets, codec_name: str) -> list[np.ndarray]:
    """The pictures, by FFmpeg alone."""
    codec = av.CodecContext.create(codec_name, "r")
    assert isinstance(codec, av.VideoCodecContext)
    pictures = [picture for _, data in packets for picture in codec.decode(av.Packet(data))]
    return [picture.to_ndarray(format="bgr24") for picture in (*pictures, *codec.decode(None))]


def test_packets_that_were_logged_at_their_pictures_times_are_decoded_as_they_stand(
    coded: tuple[str, Packets], frames: list[Frame], tmp_path: Path
) -> None:
    video_format, packets = coded
    source = open_source(foxglove_video(tmp_path / "drive.mcap", packets, video_format))
    read = list(source.frames())
    assert [frame.time_ns for frame in read] == [stamp_ns(frame) for frame in frames]
    for frame, expected in zip(read, decoded(packets, DECODERS[video_format]), strict=True):
        assert np.array_equal(frame.image, expected)
    assert source.frame_count == len(frames)
    assert source.frame_rate_hz == pytest.approx(30.0, rel=1e-3)
    assert source.notes == ()
    assert next(source.frames(read[20].time_ns)).index == 20


def test_of_packets_that_stand_in_the_order_of_their_pictures_it_is_told_what_that_does(
    coded: tuple[str, Packets], tmp_path: Path
) -> None:
    video_format, packets = coded
    source = open_source(foxglove_video(tmp_path / "drive.mcap", sorted(packets), video_format))
    lost = len(packets) - len(list(source.frames()))
    (note,) = source.notes
    if video_format == "h264":
        assert (lost, "stand in the order in which they are shown" in note) == (0, True)
    else:
        assert lost > 0
        assert f"/video: {lost} pictures left out by the decoder" in note


def test_video_without_such_pictures_says_nothing(frames: list[Frame], tmp_path: Path) -> None:
    codec, options = CODECS["h264"]
    packets = encoded(frames, codec, options | {"bf": "0"})
    source = open_source(foxglove_video(tmp_path / "drive.mcap", packets))
    assert len(list(source.frames())) == len(frames)
    assert source.notes == ()
    assert source.relays_video


def units(packet: bytes) -> list[bytes]:
    """The NAL units of a packet, without start codes."""
    return [unit for unit in re.split(b"\0\0\0?\1", packet) if unit]


def test_parameter_sets_in_messages_of_their_own_belong_to_the_next_picture(
    frames: list[Frame], tmp_path: Path
) -> None:
    codec, options = CODECS["h264"]
    packets = encoded(frames, codec, options | {"bf": "0"})
    apart: Packets = []
    for time_ns, packet in packets:
        # Types 1 and 5 are slices (ITU-T H.264, table 7-1), of which a picture may have several.
        sets = [unit for unit in units(packet) if unit[0] & 0x1F not in (1, 5)]
        slices = [unit for unit in units(packet) if unit not in sets]
        apart += [(time_ns, START_CODE + unit) for unit in sets]
        apart.append((time_ns, b"".join(START_CODE + unit for unit in slices)))
    assert len(apart) > len(packets)
    source = open_source(foxglove_video(tmp_path / "drive.mcap", apart))
    read = list(source.frames())
    assert [frame.time_ns for frame in read] == [stamp_ns(frame) for frame in frames]
    for frame, expected in zip(read, decoded(packets, "h264"), strict=True):
        assert np.array_equal(frame.image, expected)
    assert (source.frame_count, source.notes, source.relays_video) == (len(frames), (), True)
    later = next(source.frames(read[20].time_ns))
    assert (later.index, np.array_equal(later.image, read[20].image)) == (20, True)


def test_packets_as_in_an_mp4_file_are_told_by_their_form(frames: list[Frame], tmp_path: Path) -> None:
    packets = encoded(frames[:3], *CODECS["h264"])
    with_lengths = [
        (time_ns, b"".join(len(unit).to_bytes(4) + unit for unit in units(packet)))
        for time_ns, packet in packets
    ]
    with pytest.raises(UserError, match=r"no picture in its h264 .*start code \(Annex B\).*mp4toannexb"):
        open_source(foxglove_video(tmp_path / "drive.mcap", with_lengths))
