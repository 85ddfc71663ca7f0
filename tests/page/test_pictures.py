"""Frames by number are exactly those that iteration gives: real clips, every kind of source, damage."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from itertools import islice
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from av.video.stream import VideoStream

from fcw.errors import UserError
from fcw.sources import Frame, ImageFolderSource, VideoSource, open_source
from fcw_viz.page import pictures as pictures_module
from fcw_viz.page.pictures import READ_ON_FRAMES, Pictures

DEMO_DRIVE = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
COUNT = 60


def open_pictures(path: Path) -> Pictures:
    return Pictures(open_source(path))


def numbered_image(number: int) -> np.ndarray:
    """A picture with its number in eight black and white bands, over noise that does not compress."""
    bands = np.repeat(np.array([255 * (number >> bit & 1) for bit in range(8)], np.uint8), 8)
    noise = np.random.default_rng(number).integers(0, 256, (48, 64, 3), np.uint8)
    return np.concatenate((np.tile(bands[None, :, None], (16, 1, 3)), noise[16:]))


def make_video(
    path: Path,
    pts: Sequence[int] = range(COUNT),
    rate: int = 30,
    codec: str = "libx264",
    options: dict[str, str] | None = None,
) -> Path:
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=30, options=options or {"g": "12"})
        assert isinstance(stream, VideoStream)
        stream.width, stream.height = 64, 48
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, rate)
        for number, tick in enumerate(pts):
            picture = av.VideoFrame.from_ndarray(numbered_image(number), format="bgr24")
            picture.pts, picture.time_base = tick, Fraction(1, rate)
            container.mux(stream.encode(picture))
        container.mux(stream.encode(None))
    return path


def assert_same(frame: Frame, expected: Frame) -> None:
    assert (frame.index, frame.time_ns) == (expected.index, expected.time_ns)
    assert np.array_equal(frame.image, expected.image)


def assert_reads_what_iteration_gives(path: Path) -> None:
    """In an order that goes forwards, backwards, near and far, with and without the cache's help."""
    expected = list(open_source(path).frames())
    pictures = open_pictures(path)
    last = len(expected) - 1
    order = [last, 0, 1, 2, 2 + READ_ON_FRAMES, last // 2, last // 2 - 1, last // 2 - 2, last, last - 1]
    order += np.random.default_rng(1).integers(0, last + 1, 12).tolist()
    for index in order:
        if 0 <= index <= last:
            assert_same(pictures.read(index), expected[index])
    assert pictures.count == len(expected)
    # Just before the end, so that long clips are not decoded twice.
    played = list(pictures.play(last - 3))
    assert len(played) == 4
    for frame, same in zip(played, expected[-4:], strict=True):
        assert_same(frame, same)


@pytest.mark.parametrize(
    "clip", ["kb_dashcam1", "muchlisin_driving", "tmo_seattlestreet2", "udacity_project_video_cut"]
)
def test_real_clips_by_number(data_dir: Path, clip: str):
    assert_reads_what_iteration_gives(data_dir / "clips" / f"{clip}.mp4")


def test_pictures_of_a_real_folder_by_number(data_dir: Path):
    assert_reads_what_iteration_gives(data_dir / "kitti-sfnd" / "images")


@pytest.mark.parametrize(
    ("name", "codec", "options"),
    [
        ("plain.mp4", "libx264", {"bf": "0", "g": "12"}),
        ("reordered.mp4", "libx264", {"bf": "3", "g": "12", "b_strategy": "0"}),
        ("one-keyframe.mp4", "libx264", {"g": "1000", "sc_threshold": "0"}),
        ("a.mkv", "libx264", {"bf": "2", "g": "12"}),
        ("a.ts", "libx264", {"bf": "2", "g": "12"}),
        ("motion-jpeg.avi", "mjpeg", {}),
        ("no-times-reordered.avi", "libx264", {"bf": "2", "g": "12"}),
        ("no-times-at-all.h264", "libx264", {"bf": "0", "g": "12"}),
    ],
)
def test_every_container_and_codec(tmp_path: Path, name: str, codec: str, options: dict[str, str]):
    path = make_video(tmp_path / name, codec=codec, options=options)
    expected = list(open_source(path).frames())
    pictures = open_pictures(path)
    for index in (0, 40, 39, 38, 5, 6, 30, COUNT - 1, 0):
        assert_same(pictures.read(index), expected[index])
    assert len(expected) == COUNT


def test_motion_jpeg_of_old_cameras_is_not_decoded_from_the_start(tmp_path: Path):
    source = VideoSource(make_video(tmp_path / "old.avi", codec="mjpeg", options={}))
    assert source.times_ns is not None
    assert source.times_ns.tolist() == [frame.time_ns for frame in source.frames()]
    assert_reads_what_iteration_gives(tmp_path / "old.avi")


def test_variable_rate_keeps_every_time(tmp_path: Path):
    ticks = np.cumsum(np.random.default_rng(5).integers(1, 9000, COUNT)).tolist()
    path = make_video(tmp_path / "varying.mp4", ticks, rate=90_000)
    assert_reads_what_iteration_gives(path)
    pictures = open_pictures(path)
    since_first = Fraction(ticks[33] - ticks[0], 90_000) * 10**9
    assert pictures.read(33).time_ns - pictures.read(0).time_ns == pytest.approx(float(since_first), abs=1)


def test_edit_lists_that_hide_the_first_pictures(tmp_path: Path):
    whole = make_video(tmp_path / "whole.mp4", options={"g": "12", "bf": "0"})
    cut = tmp_path / "cut.mp4"
    with av.open(str(whole)) as old, av.open(str(cut), "w") as new:
        stream = new.add_stream_from_template(old.streams.video[0])
        for packet in old.demux(old.streams.video[0]):
            if packet.pts is None or packet.dts is None or packet.time_base is None:
                continue
            # Times below zero: the muxer writes an edit list that begins at zero.
            packet.pts -= round(5 / 30 / packet.time_base)
            packet.dts -= round(5 / 30 / packet.time_base)
            packet.stream = stream
            new.mux(packet)
    expected = list(VideoSource(cut).frames())
    assert len(expected) == COUNT - 5
    assert_reads_what_iteration_gives(cut)


def test_the_count_is_known_without_decoding(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = make_video(tmp_path / "drive.mp4")
    source = VideoSource(path)

    def no_decoding(*_: object) -> None:
        raise AssertionError("a frame was decoded")

    monkeypatch.setattr(VideoSource, "frames", no_decoding)
    assert Pictures(source).count == COUNT


def test_numbers_outside_the_drive_give_its_ends(tmp_path: Path):
    for name in ("drive.mp4", "no-times.avi"):
        pictures = open_pictures(make_video(tmp_path / name, options={"bf": "2"}))
        assert pictures.read(10**6).index == COUNT - 1
        assert pictures.read(-3).index == 0
        assert pictures.count == COUNT
        assert [frame.index for frame in pictures.play(10**6)] == [COUNT - 1]


def test_a_single_picture(tmp_path: Path):
    path = tmp_path / "road.PNG"
    path.write_bytes(cv2.imencode(".png", numbered_image(7))[1].tobytes())
    pictures = open_pictures(path)
    assert (pictures.count, pictures.name, str(pictures.image_size)) == (1, "road.PNG", "64x48")
    assert np.array_equal(pictures.read(0).image, numbered_image(7))
    assert np.array_equal(pictures.read(5).image, numbered_image(7))
    assert [frame.index for frame in pictures.play(0)] == [0]


def folder_of(tmp_path: Path, count: int) -> Path:
    for number in range(count):
        cv2.imwrite(str(tmp_path / f"{number}.png"), numbered_image(number))
    return tmp_path


def test_a_damaged_picture_of_a_folder_gives_the_next_one_and_at_the_end_the_one_before(tmp_path: Path):
    folder = folder_of(tmp_path, 12)
    for number in (4, 11):
        (folder / f"{number}.png").write_bytes(b"damaged")
    pictures = Pictures(ImageFolderSource(folder))
    assert pictures.count == 12
    for asked, given in ((3, 3), (4, 5), (5, 5), (11, 10), (10, 10), (4, 5)):
        frame = pictures.read(asked)
        assert frame.index == given
        assert np.array_equal(frame.image, numbered_image(given))
    assert [frame.index for frame in pictures.play(3)] == [3, 5, 6, 7, 8, 9, 10]


def test_a_folder_that_changes_under_the_page_is_one_message(tmp_path: Path):
    folder = folder_of(tmp_path, 3)
    pictures = Pictures(ImageFolderSource(folder))
    cv2.imwrite(str(folder / "1.png"), np.zeros((5, 5, 3), np.uint8))
    with pytest.raises(UserError, match=r"1\.png: 5x5 pixels, expected 64x48"):
        pictures.read(1)
    for file in folder.glob("*.png"):
        file.unlink()
    with pytest.raises(UserError, match="its pictures can no longer be read"):
        pictures.read(2)


def test_a_video_that_goes_away_under_the_page_is_one_message(tmp_path: Path):
    path = make_video(tmp_path / "drive.mp4")
    pictures = open_pictures(path)
    path.unlink()
    with pytest.raises(UserError, match=r"drive\.mp4: not a readable video"):
        pictures.read(0)


@pytest.mark.parametrize("kept", [0.4, 0.7, 0.95])
@pytest.mark.parametrize("name", ["cut.mkv", "cut.ts"])
def test_a_video_cut_short_gives_a_picture_for_every_number(tmp_path: Path, name: str, kept: float):
    path = make_video(tmp_path / name)
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * kept)])
    by_time = {frame.time_ns: frame for frame in open_source(path).frames()}
    pictures = open_pictures(path)
    assert pictures.count < COUNT
    indices = []
    for index in range(pictures.count):
        frame = pictures.read(index)
        assert np.array_equal(frame.image, by_time[frame.time_ns].image)
        indices.append(frame.index)
    assert indices == sorted(indices)


def test_damage_in_the_middle_gives_pictures_of_the_right_time(tmp_path: Path):
    path = make_video(tmp_path / "drive.mp4", options={"g": "12", "bf": "0"})
    with av.open(str(path)) as container:
        packet = next(p for i, p in enumerate(container.demux(container.streams.video[0])) if i == 24)
        assert packet.pos is not None
    data = bytearray(path.read_bytes())
    data[packet.pos : packet.pos + packet.size] = bytes(packet.size)
    path.write_bytes(bytes(data))
    shown_ns = {frame.time_ns for frame in open_source(path).frames()}
    pictures = open_pictures(path)
    assert len(shown_ns) < pictures.count == COUNT
    for index in (0, 23, 24, 25, 40, COUNT - 1):
        frame = pictures.read(index)
        assert frame.index >= index
        assert frame.time_ns in shown_ns


def test_many_threads_get_the_pictures_they_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(pictures_module, "CACHE_BYTES", 0)  # the least there is: pictures fall out again
    path = make_video(tmp_path / "drive.mp4")
    expected = list(open_source(path).frames())
    pictures = open_pictures(path)
    order = np.random.default_rng(2).integers(0, COUNT, 150).tolist()
    with ThreadPoolExecutor(6) as pool:
        for index, frame in zip(order, pool.map(pictures.read, order), strict=True):
            assert_same(frame, expected[index])


@pytest.mark.slow
def test_the_shipped_drive_by_number():
    expected = list(islice(VideoSource(DEMO_DRIVE).frames(10**9), 5))
    pictures = open_pictures(DEMO_DRIVE)
    assert pictures.count == 1200
    for frame in reversed(expected):
        assert_same(pictures.read(frame.index), frame)
