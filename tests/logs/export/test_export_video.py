"""Cuts and videos: what comes out is what the log held, in the range that was asked for."""

from dataclasses import replace
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from av.video.codeccontext import VideoCodecContext
from av.video.frame import PictureType
from export_drives import (
    RATE_HZ,
    SIZE,
    drive_header,
    marked_drive,
    marked_picture,
    write_log,
    write_torn_log,
)
from mcap.reader import make_reader
from numpy.typing import NDArray

from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.logs.export.clip import DriveClip
from fcw.logs.export.mp4 import write_overlay_mp4, write_relayed_mp4
from fcw.logs.export.replay import replay, with_its_keyframe
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.pictures import LogPictures
from fcw.logs.records import FrameResult

FRAMES = 80


@pytest.fixture(scope="module")
def drive():
    """Keyframes at frames 0, 25, 50 and 75."""
    return marked_drive(FRAMES)


@pytest.fixture(scope="module")
def log_path(drive, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("drive") / "drive.mcap"
    write_log(path, drive, drive_header())
    return path


def cut(log_path: Path, out: Path, between: tuple[float, float] | None) -> tuple[DriveLog, float]:
    clip, earlier_s = with_its_keyframe(DriveClip.open(log_path, between=between))
    replay(clip, McapSink(out), lambda: None)
    return DriveLog(out), earlier_s


def draw_nothing(_image: NDArray[np.uint8], _result: FrameResult) -> None:
    pass


def read_video(path: Path) -> list[NDArray[np.uint8]]:
    video, pictures = cv2.VideoCapture(str(path)), []
    while True:
        there, picture = video.read()
        if not there:
            return pictures
        pictures.append(np.asarray(picture, np.uint8))


def assert_shows(pictures: list[NDArray[np.uint8]], indexes: range) -> None:
    """A frame's number is its brightness: see `marked_picture`."""
    assert len(pictures) == len(indexes)
    for picture, index in zip(pictures, indexes, strict=True):
        assert np.abs(picture.astype(int) - marked_picture(index)).mean() < 3, index


def test_a_copied_video_takes_pictures_that_stand_back_in_time(drive, tmp_path):
    entries = list(drive[:12])
    (late,), (own,) = entries.pop(5)[1], entries[5][1]  # as an MCAP file that was recorded so is read
    late = replace(late, time_ns=entries[3][0].time_ns, shown=False)
    entries[5] = entries[5][0], (late, own)
    write_log(tmp_path / "drive.mcap", entries, drive_header())
    clip = DriveClip.open(tmp_path / "drive.mcap")
    assert write_relayed_mp4(tmp_path / "drive.mp4", clip, lambda: None) == 12
    with av.open(str(tmp_path / "drive.mp4")) as container:
        shown_s = [picture.time for picture in container.decode(video=0)]
    known_s = [clip.time_s(result.time_ns) for result, _ in entries]
    assert [time_s for time_s in shown_s if time_s in known_s] == known_s
    assert len(shown_s) == 12


def test_a_part_of_a_drive_is_where_the_drive_was_then(drive, tmp_path):
    points = "".join(
        f'<trkpt lat="{48 + second / 1000}" lon="11"><time>2026-05-01T10:00:0{second}Z</time></trkpt>'
        for second in range(5)
    )
    gpx = f"<gpx><trk><trkseg>{points}</trkseg></trk></gpx>".encode()
    write_log(tmp_path / "drive.mcap", drive, replace(drive_header(), gpx=gpx))
    part, _ = cut(tmp_path / "drive.mcap", tmp_path / "part.mcap", (2.2, 3.0))
    part_of_it, _ = cut(part.path, tmp_path / "part of it.mcap", (0, 0.5))
    for log in (part, part_of_it):  # from the keyframe at 2 s on
        track = log.track()
        assert track is not None
        assert track.place_at(0.5) == pytest.approx((48.0025, 11.0), abs=1e-9)
    whole, _ = cut(tmp_path / "drive.mcap", tmp_path / "whole.mcap", None)
    assert whole.header == DriveLog(tmp_path / "drive.mcap").header


@pytest.mark.parametrize(
    ("between", "first", "last", "earlier_s"),
    [
        (None, 0, 79, 0),
        ((1.2, 2.0), 25, 50, 0.2),  # from within a second: frames 30 to 50
        ((2.0, 2.4), 50, 60, 0),  # from a keyframe
        ((0.4, 3.16), 0, 79, 0.4),
    ],
)
def test_a_cut_is_a_whole_log_of_the_range_from_its_keyframe_on(
    drive, log_path, tmp_path, between, first, last, earlier_s
):
    log, earlier = cut(log_path, tmp_path / "cut.mcap", between)
    assert log.complete
    assert earlier == pytest.approx(earlier_s)
    assert log.header == drive_header()
    assert list(log.entries()) == drive[first : last + 1]
    with (tmp_path / "cut.mcap").open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    counts = {summary.channels[i].topic: n for i, n in summary.statistics.channel_message_counts.items()}
    assert counts["/fcw/frame"] == counts["/camera/image"] == last + 1 - first


def test_the_pictures_of_a_cut_decode_by_the_drives_frame_numbers(log_path, tmp_path):
    log, _ = cut(log_path, tmp_path / "cut.mcap", (1.2, 2.0))
    pictures = LogPictures(log)
    assert_shows([pictures.at(index) for index in (25, 26, 40, 30, 50)][:2], range(25, 27))
    assert_shows([pictures.at(30)], range(30, 31))
    pictures.close()


def test_a_cut_of_a_cut_is_the_cut(log_path, tmp_path):
    cut(log_path, tmp_path / "once.mcap", (1.0, 2.2))
    whole, _ = cut(log_path, tmp_path / "direct.mcap", (2.0, 2.2))
    again, _ = cut(tmp_path / "once.mcap", tmp_path / "again.mcap", (1.0, 1.2))
    assert list(again.entries()) == list(whole.entries())


def test_packets_that_only_feed_the_decoder_go_with_their_frame(drive, tmp_path):
    """Frames 0 to 6 are not part of this drive, but frame 7 needs their packets."""
    hidden = tuple(replace(packets[0], shown=False) for _, packets in drive[:7])
    first, packets = drive[7]
    entries = [(first, (*hidden, *packets)), *drive[8:40]]
    write_log(tmp_path / "drive.mcap", entries, drive_header())
    log, earlier_s = cut(tmp_path / "drive.mcap", tmp_path / "cut.mcap", (0.0, 0.2))
    assert earlier_s == 0
    assert list(log.entries()) == entries[:6]


def test_a_log_without_video_is_cut_where_it_was_asked_for(drive, tmp_path):
    write_log(tmp_path / "drive.mcap", [(result, ()) for result, _ in drive], drive_header())
    log, earlier_s = cut(tmp_path / "drive.mcap", tmp_path / "cut.mcap", (0.2, 0.4))
    assert earlier_s == 0
    assert [result.index for result in log.results()] == list(range(5, 11))


def test_a_torn_log_is_cut_up_to_where_it_is_torn(drive, tmp_path):
    assert not write_torn_log(tmp_path / "torn.mcap", drive, drive_header()).complete
    log, _ = cut(tmp_path / "torn.mcap", tmp_path / "cut.mcap", None)
    entries = list(log.entries())
    assert log.complete
    assert 60 <= len(entries) < FRAMES  # at most half a second is lost
    assert [result for result, _ in entries] == [result for result, _ in drive[: len(entries)]]


def test_the_video_has_every_picture_at_its_time(log_path, tmp_path):
    clip = DriveClip.open(log_path, between=(0.8, 2.4))
    path = tmp_path / "out.mp4"
    assert write_overlay_mp4(path, clip, draw_nothing, lambda: None) == 41
    assert_shows(read_video(path), range(20, 61))
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert (stream.width, stream.height) == (SIZE.width, SIZE.height)
        pictures = list(container.decode(stream))
        assert [picture.time for picture in pictures] == pytest.approx([i / RATE_HZ for i in range(41)])
        assert float((stream.duration or 0) * (stream.time_base or 0)) == pytest.approx(41 / RATE_HZ)
        assert not any(picture.pict_type == PictureType.B for picture in pictures)


def test_the_index_stands_first_so_that_a_browser_starts_at_once(log_path, tmp_path):
    write_overlay_mp4(tmp_path / "out.mp4", DriveClip.open(log_path), draw_nothing, lambda: None)
    data = (tmp_path / "out.mp4").read_bytes()
    assert 0 < data.index(b"moov") < data.index(b"mdat")


def test_uneven_times_are_kept(drive, tmp_path):
    """A camera that drops frames: the gap stays in the video."""
    kept = [*range(10), *range(14, 20)]
    entries = [(replace(drive[i][0], index=n), drive[i][1]) for n, i in enumerate(kept)]
    write_log(tmp_path / "drive.mcap", entries, drive_header())
    clip = DriveClip.open(tmp_path / "drive.mcap")
    for write in (
        lambda path: write_overlay_mp4(path, clip, draw_nothing, lambda: None),
        lambda path: write_relayed_mp4(path, clip, lambda: None),
    ):
        write(tmp_path / "out.mp4")
        with av.open(str(tmp_path / "out.mp4")) as container:
            times = [
                packet.pts * packet.time_base for packet in container.demux(video=0) if packet.pts is not None
            ]
        assert [float(time) for time in times] == pytest.approx([i / RATE_HZ for i in kept])


def test_an_odd_size_keeps_its_pixels_in_place(tmp_path):
    size = ImageSize(321, 181)
    write_log(tmp_path / "drive.mcap", marked_drive(3, size), drive_header(size))
    write_overlay_mp4(
        tmp_path / "out.mp4", DriveClip.open(tmp_path / "drive.mcap"), draw_nothing, lambda: None
    )
    pictures = [picture[:181, :321] for picture in read_video(tmp_path / "out.mp4")]
    for index, picture in enumerate(pictures):
        assert np.abs(picture.astype(int) - marked_picture(index, size)).mean() < 3


def test_relayed_packets_are_the_logs_own(drive, log_path, tmp_path):
    clip, _ = with_its_keyframe(DriveClip.open(log_path, between=(1.2, 2.0)))
    path = tmp_path / "out.mp4"
    assert write_relayed_mp4(path, clip, lambda: None) == 26
    assert_shows(read_video(path), range(25, 51))
    with av.open(str(path)) as container:
        relayed = [picture.to_ndarray(format="yuv420p") for picture in container.decode(video=0)]
    decoder = av.CodecContext.create("h264", "r")
    assert isinstance(decoder, VideoCodecContext)
    decoder.thread_type = "SLICE"
    own = [decoder.decode(av.Packet(packet.data)) for _, packets in drive[25:51] for packet in packets]
    own.append(decoder.decode(None))
    pictures = [picture.to_ndarray(format="yuv420p") for decoded in own for picture in decoded]
    assert np.array_equal(pictures, relayed)


def test_packets_that_only_feed_the_decoder_are_not_shown_in_the_video(drive, tmp_path):
    hidden = tuple(replace(packets[0], shown=False) for _, packets in drive[:7])
    first, packets = drive[7]
    write_log(tmp_path / "drive.mcap", [(first, (*hidden, *packets)), *drive[8:20]], drive_header())
    write_relayed_mp4(tmp_path / "out.mp4", DriveClip.open(tmp_path / "drive.mcap"), lambda: None)
    assert_shows(read_video(tmp_path / "out.mp4"), range(7, 20))


def test_a_video_of_a_torn_log_ends_with_its_last_picture(drive, tmp_path):
    write_torn_log(tmp_path / "torn.mcap", drive, drive_header())
    clip = DriveClip.open(tmp_path / "torn.mcap")
    count = write_overlay_mp4(tmp_path / "out.mp4", clip, draw_nothing, lambda: None)
    assert 50 <= count < FRAMES
    assert_shows(read_video(tmp_path / "out.mp4"), range(count))


@pytest.mark.parametrize(
    "write",
    [
        lambda path, clip: write_overlay_mp4(path, clip, draw_nothing, lambda: None),
        lambda path, clip: write_relayed_mp4(path, clip, lambda: None),
    ],
    ids=["overlay", "relayed"],
)
def test_a_log_without_video_makes_no_video(drive, tmp_path, write):
    write_log(tmp_path / "drive.mcap", [(result, ()) for result, _ in drive[:5]], drive_header())
    clip = DriveClip.open(tmp_path / "drive.mcap")
    with pytest.raises(UserError, match=r"drive\.mcap: the log holds no pictures"):
        write(tmp_path / "out.mp4", clip)
    assert [path.name for path in tmp_path.iterdir()] == ["drive.mcap"]


def test_an_interruption_leaves_nothing_behind(log_path, tmp_path):
    def interrupt(_image: NDArray[np.uint8], result: FrameResult) -> None:
        if result.index == 10:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_overlay_mp4(tmp_path / "out.mp4", DriveClip.open(log_path), interrupt, lambda: None)
    assert list(tmp_path.iterdir()) == []
