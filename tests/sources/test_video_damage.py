"""Broken and foreign files: one clear message, or everything that still decodes and a note on the rest."""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import av
import numpy as np
import pytest
from av.stream import Disposition
from av.video.stream import VideoStream
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from searching import examples

from fcw.errors import UserError
from fcw.sources import open_source

SHORT_GOPS = {"bf": "0", "g": "10"}
INDEX_FIRST = {"movflags": "faststart"}


def cut(path: Path, keep: float) -> Path:
    data = path.read_bytes()
    short = path.with_name("cut_" + path.name)
    short.write_bytes(data[: int(len(data) * keep)])
    return short


def refusal(path: Path) -> str:
    with pytest.raises(UserError) as caught:
        open_source(path)
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value)


def test_a_missing_file(tmp_path):
    assert "no such file or folder; expected a video or MCAP file, a folder" in refusal(tmp_path / "no.mp4")


def test_an_empty_file(tmp_path):
    path = tmp_path / "empty.mp4"
    path.touch()
    assert "not a readable video" in refusal(path)


def test_an_mp4_without_its_index(make_video, noise_images):
    path = cut(make_video("end.mp4", noise_images), 0.6)
    assert "cut off may lack its index: repair it first" in refusal(path)


def test_a_video_of_larger_pictures_than_a_drive_may_have(make_video):
    path = make_video(
        "large.avi", [np.zeros((1100, 16000, 3), np.uint8)], codec="mjpeg", pixel_format="yuvj420p"
    )
    assert "pictures of 16000x1100; expected at most 16,777,216 pixels" in refusal(path)


def test_a_picture_that_is_too_large_amid_others_is_not_decoded(make_video, tmp_path):
    made = [
        make_video(
            f"{h}.mjpeg", [np.zeros((h, 16000, 3), np.uint8)], codec="mjpeg", pixel_format="yuvj420p"
        ).read_bytes()
        for h in (16, 1100)
    ]
    (tmp_path / "joined.mjpeg").write_bytes(made[0] * 3 + made[1])
    source = open_source(tmp_path / "joined.mjpeg")
    assert [frame.image.shape for frame in source.frames()] == [(16, 16000, 3)] * 3
    assert source.notes == ("joined.mjpeg: 1 picture damaged beyond decoding, left out",)


@pytest.mark.parametrize("content", [b"hello\n" * 100, bytes(range(256)) * 16])
def test_a_file_that_is_no_video(tmp_path, content: bytes):
    path = tmp_path / "notes.txt"
    path.write_bytes(content)
    assert "not a" in refusal(path)


@pytest.mark.parametrize("suffix", ["jpg", "png", "webp", "bmp"])
def test_a_single_damaged_picture(tmp_path, suffix: str):
    path = tmp_path / f"one.{suffix}"
    path.write_bytes(b"no picture")
    assert f"{path}: this picture cannot be read" in refusal(path)


def write_sound(path: Path, cover: np.ndarray | None = None) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mp3" if path.suffix == ".mp3" else "aac", rate=44_100)
        picture = container.add_stream("mjpeg") if cover is not None else None
        if isinstance(picture, VideoStream) and cover is not None:
            picture.height, picture.width, picture.pix_fmt = *cover.shape[:2], "yuvj420p"
            picture.disposition = Disposition.attached_pic
            container.mux(picture.encode(av.VideoFrame.from_ndarray(cover, format="bgr24")))
            container.mux(picture.encode(None))
        sound = av.AudioFrame.from_ndarray(np.zeros((2, 1024), np.float32), format="fltp", layout="stereo")
        sound.sample_rate = 44_100
        container.mux(stream.encode(sound))
        container.mux(stream.encode(None))


def test_sound_alone(tmp_path):
    path = tmp_path / "sound.mp4"
    write_sound(path)
    assert "no video stream in it (it holds: audio)" in refusal(path)


def test_sound_with_a_cover_picture_is_no_video(tmp_path):
    path = tmp_path / "song.mp3"
    write_sound(path, np.full((48, 64, 3), 90, np.uint8))
    with av.open(str(path)) as container:
        assert container.streams.video
    assert "no video stream in it" in refusal(path)


def test_a_stream_of_no_length(make_video, noise_images):
    path = make_video("none.mp4", noise_images[:1], container_options=INDEX_FIRST)
    data = path.read_bytes()
    # Empty the sample table: no sizes, so no samples.
    at = data.index(b"stsz")
    path.write_bytes(data[: at + 12] + bytes(4) + data[at + 16 :])
    assert "holds no picture that can be decoded" in refusal(path)


def test_a_codec_without_decoder(make_video, noise_images):
    path = make_video("odd.mp4", noise_images[:5])
    path.write_bytes(path.read_bytes().replace(b"avc1", b"zzz1"))
    message = refusal(path)
    assert "no decoder for the codec" in message
    assert "ffmpeg -i" in message


def test_a_file_cut_in_its_middle_gives_all_that_decodes(make_video, noise_images):
    whole = make_video("whole.mp4", noise_images, codec_options=SHORT_GOPS, container_options=INDEX_FIRST)
    expected = [frame.image for frame in open_source(whole).frames()]
    with av.open(str(whole)) as container:
        ends = [entry.pos + entry.size for entry in container.streams.video[0].index_entries]
    path = cut(whole, 0.6)
    readable = sum(end <= path.stat().st_size for end in ends)
    assert 10 < readable < 25
    source = open_source(path)
    frames = list(source.frames())
    assert len(frames) == readable
    for frame, image in zip(frames, expected, strict=False):
        np.testing.assert_array_equal(frame.image, image)
    assert f"of {len(expected)} pictures missing" in " ".join(source.notes)
    assert f"{frames[-1].time_ns / 1e9:.3f} s" in " ".join(source.notes)


def test_a_matroska_file_cut_in_its_middle_says_how_much_is_missing(make_video, noise_images):
    images = noise_images * 4
    path = cut(make_video("long.mkv", images, codec_options=SHORT_GOPS), 0.5)
    source = open_source(path)
    frames = list(source.frames())
    assert 40 < len(frames) < 70
    assert source.notes == (
        f"cut_long.mkv: the file is cut short: the last picture read is at {frames[-1].time_ns / 1e9:.3f} "
        "s, but it should last until 4.000 s",
    )


def test_a_matroska_file_that_lacks_less_than_a_second_says_so(make_video, noise_images):
    path = cut(make_video("long.mkv", noise_images * 4, codec_options=SHORT_GOPS), 0.85)
    source = open_source(path)
    last_s = [frame.time_ns for frame in source.frames()][-1] / 1e9
    assert 3.2 < last_s < 3.6
    (note,) = source.notes
    assert note.endswith(
        f"cut short: the last picture read is at {last_s:.3f} s, but it should last until 4.000 s"
    )


@pytest.mark.parametrize("suffix", ["mp4", "mkv", "ts", "mov"])
@pytest.mark.parametrize("sound_s", [0.0, 0.9, 5.0])
def test_a_whole_file_is_not_called_cut_short_whatever_its_sound(tmp_path, noise_images, suffix, sound_s):
    path = tmp_path / f"whole.{suffix}"
    write_with_sound(path, noise_images * 2, sound_s)
    source = open_source(path)
    assert len(list(source.frames())) == 60
    assert source.notes == ()


def write_with_sound(path: Path, images: Sequence[NDArray[np.uint8]], longer_s: float) -> None:
    """Pictures at 30 a second, and sound that lasts longer."""
    with av.open(str(path), "w") as container:
        video, sound = container.add_stream("libx264", rate=30), container.add_stream("aac", rate=44_100)
        assert isinstance(video, VideoStream)
        video.height, video.width = images[0].shape[:2]
        video.pix_fmt = "yuv420p"
        samples = round(44_100 * (len(images) / 30 + longer_s))
        silence = av.AudioFrame.from_ndarray(
            np.zeros((2, samples), np.float32), format="fltp", layout="stereo"
        )
        silence.sample_rate = 44_100
        for image in images:
            container.mux(video.encode(av.VideoFrame.from_ndarray(image, format="bgr24")))
        container.mux(video.encode(None))
        container.mux(sound.encode(silence))
        container.mux(sound.encode(None))


def test_a_damaged_packet_costs_its_picture_and_not_the_drive(make_video, noise_images):
    path = make_video("hit.mp4", noise_images, codec_options={"bf": "0", "g": "5"})
    clean = [frame.image for frame in open_source(path).frames()]
    with av.open(str(path)) as container:
        entry = container.streams.video[0].index_entries[12]
    data = bytearray(path.read_bytes())
    data[entry.pos : entry.pos + entry.size] = b"\xff" * entry.size
    path.write_bytes(data)
    source = open_source(path)
    frames = list(source.frames())
    assert len(frames) == len(clean) - 1
    for frame in frames[15 - 1 :]:  # from the next keyframe on all is well again
        number = round(frame.time_ns * 30 / 1e9)
        np.testing.assert_array_equal(frame.image, clean[number])
    assert "1 picture damaged beyond decoding" in " ".join(source.notes)
    assert [frame.index for frame in frames] == list(range(len(frames)))
    assert all(frame.packets[-1].time_ns == frame.time_ns for frame in frames)


def test_a_clock_that_steps_back_costs_no_picture(make_video, numbered_images, tmp_path):
    parts = [
        make_video(f"{name}.ts", numbered_images[first : first + 40], codec_options=SHORT_GOPS)
        for name, first in (("a", 0), ("b", 40))
    ]
    path = tmp_path / "joined.ts"
    path.write_bytes(b"".join(part.read_bytes() for part in parts))
    source = open_source(path)
    frames = list(source.frames())
    numbers = [
        sum(int(frame.image[:, 8 * bit + 2 : 8 * bit + 6].mean() > 127) << bit for bit in range(8))
        for frame in frames
    ]
    assert numbers == list(range(80))
    times = np.array([frame.time_ns for frame in frames])
    assert np.all(np.abs(np.diff(times) - 1e9 / 30) < 1e6)
    assert not source.relays_video
    assert "1 picture without a time after the one before" in " ".join(source.notes)
    assert next(source.frames(int(times[60]))).index == 60


def test_a_picture_of_another_size_ends_the_drive_with_a_note(make_video, noise_images, tmp_path):
    small = make_video("small.h264", noise_images[:10], codec_options=SHORT_GOPS)
    large_images = [np.tile(image, (2, 2, 1)) for image in noise_images[:10]]
    large = make_video("large.h264", large_images, codec_options=SHORT_GOPS)
    path = tmp_path / "both.h264"
    path.write_bytes(small.read_bytes() + large.read_bytes())
    source = open_source(path)
    assert {frame.image.shape for frame in source.frames()} == {(48, 64, 3)}
    assert "changes from 64x48 to 128x96" in " ".join(source.notes)


@pytest.mark.slow
@examples(60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damage_is_refused_or_survived(make_video, noise_images, data):
    name = data.draw(st.sampled_from(["d.mp4", "d.mkv", "d.avi", "d.ts"]))
    path = make_video(name, noise_images[:12], codec_options=SHORT_GOPS, container_options={})
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 12))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    try:
        source = open_source(path)
    except UserError:
        return
    frames = list(source.frames())
    times = [frame.time_ns for frame in frames]
    assert times == sorted(set(times))
    assert [frame.index for frame in frames] == list(range(len(frames)))
    assert all(frame.packets[-1].time_ns == frame.time_ns for frame in frames if source.relays_video)


EARLY_ENDS = """
import os, signal, sys
from fcw.sources import open_source
source = open_source(sys.argv[1])
for _ in range(3):
    frames = source.frames(); next(frames); next(frames); frames.close()
    frames = source.frames(); next(frames); next(frames); del frames
try:
    for frame in source.frames():
        if frame.index == 2:
            raise RuntimeError
except RuntimeError:
    pass
try:
    for frame in source.frames():
        if frame.index == 2:
            os.kill(os.getpid(), signal.SIGINT)
except KeyboardInterrupt:
    pass
held = source.frames(); next(held); next(held)
print("done")
"""


def test_ending_early_never_hangs(make_video, numbered_images):
    images = [np.repeat(np.repeat(image, 10, 0), 10, 1) for image in numbered_images[:40]]
    path = make_video("hang.mp4", images, codec_options={"g": "20", "preset": "ultrafast"})
    root = Path(__file__).parents[2]
    run = subprocess.run(
        [sys.executable, "-c", EARLY_ENDS, str(path)],
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "done\n", "")
