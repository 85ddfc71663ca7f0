"""Folders of pictures as drives."""

import errno
import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from fcw.errors import UserError
from fcw.sources import open_source


def write_pictures(folder: Path, names: list[str]) -> None:
    """Pictures of one gray level each, 10 times their place in `names`."""
    folder.mkdir(exist_ok=True)
    for i, name in enumerate(names):
        cv2.imwrite(str(folder / name), np.full((48, 64, 3), 10 * i, np.uint8))


def levels(folder: Path) -> list[int]:
    return [int(frame.image[0, 0, 0]) // 10 for frame in open_source(folder).frames()]


def test_names_are_sorted_by_their_numbers(tmp_path):
    write_pictures(tmp_path / "drive", ["1.png", "2.png", "10.png", "100.bmp", "a9.png", "a10.webp"])
    assert levels(tmp_path / "drive") == [0, 1, 2, 3, 4, 5]


def test_one_picture_is_a_drive_of_one_frame(tmp_path):
    write_pictures(tmp_path, ["0.png", "1.PNG", "2.png"])
    (tmp_path / "timestamps.txt").write_text("0.0\n0.1\n0.2\n")
    source = open_source(tmp_path / "1.PNG")
    assert [(frame.index, int(frame.image[0, 0, 0])) for frame in source.frames()] == [(0, 10)]
    assert (source.name, source.frame_count, source.notes) == ("1.PNG", 1, ())


def test_without_times_ten_a_second_are_assumed_and_said(tmp_path):
    write_pictures(tmp_path / "drive", ["0.jpg", "1.jpg", "2.jpg"])
    source = open_source(tmp_path / "drive")
    assert [frame.time_ns for frame in source.frames()] == [0, 100_000_000, 200_000_000]
    assert (source.name, source.frame_count, source.relays_video) == ("drive", 3, False)
    assert "10 pictures a second are assumed" in " ".join(source.notes)


def test_a_frame_rate_gives_exact_times(tmp_path):
    write_pictures(tmp_path, [f"{i}.png" for i in range(7)])
    source = open_source(tmp_path, frame_rate_hz=3)
    assert [frame.time_ns for frame in source.frames()] == [round(i * 1e9 / 3) for i in range(7)]
    assert source.notes == ()
    assert [frame.index for frame in source.frames(666_666_667)] == [2, 3, 4, 5, 6]


@pytest.mark.parametrize("rate", [0.0, -3.0, float("nan"), float("inf")])
def test_a_rate_that_is_none(tmp_path, rate: float):
    write_pictures(tmp_path, ["0.png"])
    with pytest.raises(UserError, match="expected a number of pictures a second above 0"):
        open_source(tmp_path, frame_rate_hz=rate)


@pytest.mark.parametrize("beside", [True, False])
def test_kitti_timestamps(tmp_path, beside: bool):
    folder = tmp_path / "data"
    write_pictures(folder, ["0000000000.png", "0000000001.png", "0000000002.png"])
    (tmp_path / "timestamps.txt" if beside else folder / "timestamps.txt").write_text(
        "2011-09-26 23:59:59.994360375\n2011-09-27 00:00:00.097955225\n2011-09-27 00:00:00.201433269\n"
    )
    source = open_source(folder)
    assert [frame.time_ns for frame in source.frames()] == [0, 103_594_850, 207_072_894]
    assert source.frame_rate_hz == pytest.approx(1 / 0.1035, rel=1e-3)
    assert source.notes == ()


def test_kitti_timestamps_are_found_from_within_the_folder_too(tmp_path, monkeypatch):
    write_pictures(tmp_path / "data", ["0.png", "1.png"])
    (tmp_path / "timestamps.txt").write_text("0\n0.5\n")
    monkeypatch.chdir(tmp_path / "data")
    assert [frame.time_ns for frame in open_source(".").frames()] == [0, 500_000_000]


def test_hidden_files_are_no_pictures(tmp_path):
    write_pictures(tmp_path, ["0.png", "1.png"])
    for name in ("._0.png", "._1.png"):
        (tmp_path / name).write_bytes(b"\0\5\x16\7\0\2\0\0Mac OS X        ")
    (tmp_path / "timestamps.txt").write_text("0\n0.5\n")
    source = open_source(tmp_path)
    assert [frame.time_ns for frame in source.frames()] == [0, 500_000_000]
    assert source.notes == ()


def test_times_beside_another_folder_are_not_its_own(tmp_path):
    write_pictures(tmp_path / "front", ["0.png"])
    (tmp_path / "timestamps.txt").write_text("5.0\n")
    assert [frame.time_ns for frame in open_source(tmp_path / "front").frames()] == [0]


def test_times_in_seconds_keep_every_digit(tmp_path):
    write_pictures(tmp_path, ["0.png", "1.png"])
    (tmp_path / "timestamps.txt").write_text("1317042272.123456789\n1317042273\n")
    assert [frame.time_ns for frame in open_source(tmp_path).frames()] == [
        1_317_042_272_123_456_789,
        1_317_042_273_000_000_000,
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0.1\n", r"timestamps\.txt: 1 times for 2 pictures"),
        ("0.1\nlater\n", r"timestamps\.txt, line 2: 'later'; expected seconds"),
        ("0.2\n0.2\n", r"timestamps\.txt, line 2: '0\.2' is not after"),
        ("0.2\n2011-13-40 00:00:00\n", r"timestamps\.txt, line 2"),
    ],
)
def test_times_that_cannot_be(tmp_path, text: str, message: str):
    write_pictures(tmp_path, ["0.png", "1.png"])
    (tmp_path / "timestamps.txt").write_text(text)
    with pytest.raises(UserError, match=message):
        open_source(tmp_path)


def test_a_picture_that_cannot_be_read_is_left_out_and_named(tmp_path):
    write_pictures(tmp_path, [f"{i}.png" for i in range(5)])
    (tmp_path / "2.png").write_bytes((tmp_path / "2.png").read_bytes()[:40])
    (tmp_path / "3.png").write_bytes(b"")
    source = open_source(tmp_path)
    frames = list(source.frames())
    assert [frame.time_ns for frame in frames] == [0, 100_000_000, 400_000_000]
    assert [frame.index for frame in frames] == [0, 1, 2]
    assert [note for note in source.notes if "cannot be read" in note] == [
        f"{tmp_path / name}: this picture cannot be read and is left out" for name in ("2.png", "3.png")
    ]


def test_a_picture_of_another_size_is_named(tmp_path):
    write_pictures(tmp_path, ["0.png", "1.png"])
    cv2.imwrite(str(tmp_path / "2.png"), np.zeros((50, 64, 3), np.uint8))
    frames = open_source(tmp_path).frames()
    next(frames)
    next(frames)
    with pytest.raises(UserError, match=r"2\.png: 64x50 pixels, expected 64x48"):
        next(frames)


def test_a_path_through_a_file_and_one_that_may_not_be_read_say_what_helps(tmp_path, monkeypatch):
    (tmp_path / "a.mp4").touch()
    with pytest.raises(UserError, match=r"a\.mp4/x: no such file or folder"):
        open_source(tmp_path / "a.mp4" / "x")

    def refused(self: Path) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(self))

    monkeypatch.setattr(Path, "stat", refused)  # the tests may run as root, who may read everything
    with pytest.raises(UserError, match=r"\(Permission denied\); make it, and its folders, readable"):
        open_source(tmp_path / "a.mp4")


def test_a_folder_without_pictures(tmp_path):
    with pytest.raises(
        UserError, match=r"no pictures in this folder; expected .*, or the videos of one drive"
    ):
        open_source(tmp_path)
    for name in ("._drive.MP4", "drive.MP4"):
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(UserError, match=r"name the video: .*drive\.MP4"):
        open_source(tmp_path)
    (tmp_path / "bad.png").write_bytes(b"no picture")
    with pytest.raises(UserError, match="none of its 1 pictures can be read"):
        open_source(tmp_path)


def test_a_real_folder(data_dir: Path):
    source = open_source(data_dir / "kitti-sfnd" / "images")
    frames = list(source.frames())
    assert len(frames) == source.frame_count == 78
    assert str(source.image_size) == "1242x375"
    names = sorted(path.name for path in (data_dir / "kitti-sfnd" / "images").iterdir())
    last = cv2.imread(str(data_dir / "kitti-sfnd" / "images" / names[-1]))
    np.testing.assert_array_equal(frames[-1].image, last)


def test_numbers_that_are_missing_in_the_names_are_told(tmp_path):
    write_pictures(tmp_path / "drive", [f"frame_{i}.png" for i in (8, 9, 10, 11, 14, 15, 17)])
    (note,) = open_source(tmp_path / "drive", frame_rate_hz=10).notes
    assert "3 pictures are missing by the numbers in the names, the first after frame_11.png" in note
    assert "timestamps.txt" in note


@pytest.mark.parametrize(
    "names",
    [
        ["0.png", "5.png", "10.png", "15.png"],  # every fifth was taken
        ["1626.png", "1659.png", "1693.png", "1726.png", "1760.png"],  # times
        ["a.png", "b1.png", "b3.png", "b4.png"],
    ],
)
def test_other_numbers_are_not(tmp_path, names: list[str]):
    write_pictures(tmp_path / "drive", names)
    assert open_source(tmp_path / "drive", frame_rate_hz=10).notes == ()
