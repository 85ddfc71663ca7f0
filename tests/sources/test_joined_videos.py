"""The videos of a folder as one drive, as dash cameras record it."""

import shutil
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from running.demo_cut import cut_demo
from test_video_files import NO_B_FRAMES, number_in

from fcw.errors import UserError
from fcw.frame import DatedSource, TimedSource, VideoLike
from fcw.job import DriveJob, run_drive
from fcw.logs.mcap.reader import DriveLog
from fcw.sources import JoinedSource, open_source
from fcw.units import NS_PER_S

LENGTHS = {"DR_2.MP4": 7, "DR_9.MP4": 1, "DR_10.MP4": 12}


@pytest.fixture
def drive(make_video, numbered_images, tmp_path: Path) -> Path:
    """Twenty numbered pictures in three files, whose own clocks all begin at 0."""
    folder = tmp_path / "drive"
    folder.mkdir()
    first = 0
    for name, count in LENGTHS.items():
        path = make_video(name, numbered_images[first : first + count], codec_options=NO_B_FRAMES)
        shutil.move(path, folder / name)
        first += count
    (folder / "._DR_2.MP4").write_bytes(b"of macOS")
    return folder


def times_of(count: int) -> list[int]:
    """At 30 pictures a second, to the rounding of one picture's period for each file before."""
    return [round(i * NS_PER_S / 30) for i in range(count)]


def test_the_videos_of_a_folder_follow_each_other_by_their_numbers(drive):
    source = open_source(drive)
    assert isinstance(source, JoinedSource)
    assert all(isinstance(source, kind) for kind in (TimedSource, VideoLike, DatedSource))
    frames = list(source.frames())
    assert [number_in(frame.image) for frame in frames] == list(range(20))
    assert [frame.index for frame in frames] == list(range(20))
    assert np.allclose([frame.time_ns for frame in frames], times_of(20), rtol=0, atol=3)
    assert source.times_ns.tolist() == [frame.time_ns for frame in frames]
    assert (source.name, source.frame_count, str(source.image_size)) == ("drive", 20, "64x48")
    assert source.notes == (
        "drive: its 3 videos, DR_2.MP4 to DR_10.MP4, are taken as one drive, by their names",
    )


def test_packets_are_relayed_over_the_boundaries(drive):
    source = open_source(drive)
    assert source.relays_video
    packets = [packet for frame in source.frames() for packet in frame.packets]
    assert [packet.time_ns for packet in packets] == [frame.time_ns for frame in source.frames()]
    assert all(packet.shown for packet in packets)
    assert all(packets[first].keyframe for first in (0, 7, 8))


@pytest.mark.parametrize("first", range(20))
def test_a_drive_may_be_entered_anywhere(first: int, drive):
    source = open_source(drive)
    start_ns = [frame.time_ns for frame in source.frames()][first]
    for before_ns in (0, 1):
        frames = list(source.frames(start_ns - before_ns))
        assert [frame.index for frame in frames] == list(range(first, 20))
        assert [number_in(frame.image) for frame in frames] == list(range(first, 20))
    assert list(source.frames(10**12)) == []


def test_after_a_damaged_picture_the_drive_goes_on_and_names_its_file(drive, make_video, noise_images):
    path = make_video("DR_5.MP4", noise_images[:20], codec_options=NO_B_FRAMES)
    with av.open(str(path)) as container:
        entry = container.streams.video[0].index_entries[12]
    data = bytearray(path.read_bytes())
    data[entry.pos : entry.pos + entry.size] = b"\xff" * entry.size
    (drive / "DR_5.MP4").write_bytes(data)
    source = open_source(drive)
    frames = list(source.frames())
    assert [number_in(frame.image) for frame in frames[-13:]] == list(range(7, 20))
    assert [frame.index for frame in frames] == list(range(39))
    assert np.allclose([frame.time_ns for frame in frames[-13:]], times_of(40)[-13:], rtol=0, atol=6)
    assert source.notes[1:] == ("DR_5.MP4: 1 picture damaged beyond decoding, left out",)


def test_a_last_file_without_its_index_is_left_out_and_told(drive):
    torn = drive / "DR_11.MP4"
    torn.write_bytes((drive / "DR_10.MP4").read_bytes()[:1500])
    source = open_source(drive)
    assert len(list(source.frames())) == 20
    whole, left_out = source.notes
    assert whole.startswith("drive: its 3 videos, DR_2.MP4 to DR_10.MP4")
    assert left_out.startswith(f"left out: {torn}: not a readable video")
    assert left_out.endswith("may lack its index: repair it first")
    for name in ("DR_2.MP4", "DR_9.MP4"):
        (drive / name).write_bytes(b"")
    assert [note.split(":")[0] for note in open_source(drive).notes] == ["left out"] * 3
    (drive / "DR_10.MP4").write_bytes(b"")
    with pytest.raises(UserError, match=r"DR_2\.MP4: not a readable video"):
        open_source(drive)


def test_how_all_pictures_are_set_right_is_said_once(tmp_path, make_video, numbered_images):
    for i in range(3):
        make_video(f"{i}.mp4", numbered_images[:3], rotation=(90, False, False), codec_options=NO_B_FRAMES)
    source = open_source(tmp_path)
    assert str(source.image_size) == "48x64"
    assert len(list(source.frames())) == 9
    assert [note.split(";")[0].split(",")[0] for note in source.notes] == [
        f"{tmp_path.name}: its 3 videos",
        "0.mp4: pictures are turned by 270 degrees clockwise",
    ]
    assert not source.relays_video


@pytest.mark.parametrize("names", [("1F.MP4", "1R.MP4"), ("day_NF.mp4", "day_NR.mp4"), ("0_f.ts", "0_r.ts")])
def test_files_of_the_cameras_ahead_and_behind_are_told_by_their_names(names, drive):
    for name in names:
        shutil.copy(drive / "DR_2.MP4", drive / name)
    with pytest.raises(
        UserError, match=f"drive: holds files of two cameras by .* as {names[0]} and {names[1]};"
    ):
        open_source(drive)


def test_videos_of_another_size_are_of_another_camera(drive, make_video, numbered_images):
    path = make_video("R.mp4", [image[:32] for image in numbered_images[:5]], codec_options=NO_B_FRAMES)
    shutil.move(path, drive / "R.mp4")
    with pytest.raises(UserError, match=r"R\.mp4: 64x32 pixels, expected 64x48 as in DR_2\.MP4; keep one"):
        open_source(drive)


def test_where_a_later_video_begins_with_pictures_that_are_not_shown_all_are_coded_anew(
    drive, make_video, numbered_images
):
    one_keyframe = {"bf": "0", "g": "50", "sc_threshold": "0"}
    path = make_video("DR_11.MP4", numbered_images[:9], pts=range(-3, 6), codec_options=one_keyframe)
    assert [len(frame.packets) for frame in open_source(path).frames()] == [4, 1, 1, 1, 1, 1]
    shutil.move(path, drive / "DR_11.MP4")
    source = open_source(drive)
    assert isinstance(source, JoinedSource)
    assert source.coded_anew == "DR_11.MP4 begins with pictures that are not to be shown"
    assert [frame.packets for frame in source.frames()] == [()] * 26


def test_a_video_without_times_cannot_be_joined(drive, make_video, numbered_images):
    path = make_video("DR_3.avi", numbered_images[:20], codec="mpeg4", codec_options={"bf": "2"})
    shutil.move(path, drive / "DR_3.avi")
    source = open_source(drive)
    with pytest.raises(UserError, match=r"DR_3\.avi: it does not state the times of all its pictures"):
        next(source.frames())


def test_a_rate_is_not_for_videos(drive):
    with pytest.raises(UserError, match="a frame rate of 5 was given, but a video has times"):
        open_source(drive, frame_rate_hz=5)


def test_a_folder_of_videos_and_pictures_is_not_guessed_at(drive):
    cv2.imwrite(str(drive / "0.png"), np.full((48, 64, 3), 100, np.uint8))
    with pytest.raises(
        UserError, match=r"holds videos, such as DR_2\.MP4, and pictures, such as 0\.png; expected"
    ):
        open_source(drive)
    for name in ("DR_2.MP4", "DR_9.MP4"):  # one video may be of the pictures
        (drive / name).unlink()
    assert open_source(drive).frame_count == 1


def test_a_drive_in_two_files_is_followed_as_the_whole_one(tmp_path):
    """Over the boundary at 29 s, just before its warning."""
    whole = cut_demo(tmp_path, 28, 2)
    for part in (1, 2):
        cut_demo(tmp_path / "card", 27 + part, 1, name=f"DR_{part}")
    calibration = tmp_path / "drive.calibration.yaml"
    drives = []
    for source in (whole, tmp_path / "card"):
        out = tmp_path / "out" / source.stem
        run_drive(DriveJob(source, out, calibration))
        log = DriveLog(out / "drive.mcap")
        drives.append((list(log.results()), [packet.data for packet in log.video_packets()]))
    (expected, expected_packets), (found, packets) = drives
    assert packets == expected_packets
    assert np.allclose([r.time_ns for r in found], [r.time_ns for r in expected], rtol=0, atol=1)
    assert any(result.warning.level for result in expected)
    for result, whole_result in zip(found, expected, strict=True):
        assert result.warning.level == whole_result.warning.level
        assert result.lead_id == whole_result.lead_id
        distances = [[track.distance_m for track in each.tracks] for each in (result, whole_result)]
        assert distances[0] == pytest.approx(distances[1], rel=1e-6)
