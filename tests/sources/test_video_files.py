"""Videos made on the spot: times, rotation, containers, codecs."""

from fractions import Fraction

import av
import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.errors import UserError
from fcw.sources import VideoSource, h264, open_source

NO_B_FRAMES = {"bf": "0", "g": "10"}


def number_in(image: np.ndarray) -> int:
    """The number that the picture shows, see the fixture `numbered_images`."""
    return sum(int(image[:, 8 * bit + 2 : 8 * bit + 6].mean() > 127) << bit for bit in range(8))


def test_variable_frame_rate_keeps_every_time(make_video, numbered_images):
    pts = [0, 1501, 4500, 4501, 9000, 99_000, 99_090, 180_007]
    path = make_video(
        "vfr.mp4",
        numbered_images[: len(pts)],
        pts=pts,
        time_base=Fraction(1, 90_000),
        codec_options=NO_B_FRAMES,
    )
    frames = list(open_source(path).frames())
    assert [frame.time_ns for frame in frames] == [round(Fraction(p, 90_000) * 10**9) for p in pts]
    assert [number_in(frame.image) for frame in frames] == list(range(len(pts)))
    assert [frame.packets[-1].time_ns for frame in frames] == [frame.time_ns for frame in frames]


@pytest.mark.parametrize("mirror", [(False, False), (True, False), (False, True)])
@pytest.mark.parametrize("degrees", [0, 90, 180, 270])
def test_pictures_are_set_upright_as_the_file_asks(make_video, degrees: int, mirror: tuple[bool, bool]):
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[:24, :32] = (250, 20, 20)  # top left blue
    picture[:24, 32:] = (20, 250, 20)  # top right green
    picture[24:, :32] = (20, 20, 250)  # bottom left red, bottom right black
    path = make_video("turned.mp4", [picture] * 3, rotation=(degrees, *mirror), codec_options=NO_B_FRAMES)
    expected = np.rot90(picture, degrees // 90)  # anticlockwise, as PyAV counts, then mirrored
    expected = expected[:, ::-1] if mirror[0] else expected
    expected = expected[::-1] if mirror[1] else expected
    source = open_source(path)
    frame = next(source.frames())
    assert frame.image.shape == expected.shape
    assert (source.image_size.height, source.image_size.width) == expected.shape[:2]
    assert np.mean(np.abs(frame.image.astype(float) - expected)) < 8
    upright = degrees == 0 and not any(mirror)
    assert source.relays_video == upright
    assert isinstance(source, VideoSource)
    assert source.coded_anew.startswith("they are ") == (not upright)
    assert bool(frame.packets) == upright
    assert ("turned.mp4: pictures are" in " ".join(source.notes)) == (not upright)


def test_a_rotation_is_said_in_degrees_clockwise_and_agrees_with_opencv(make_video):
    generator = np.random.default_rng(0)
    picture = cv2.resize(generator.integers(0, 256, (6, 8, 3), np.uint8), (64, 48))
    path = make_video("phone.mp4", [picture] * 3, rotation=(270, False, False))
    source = open_source(path)
    shown, image = cv2.VideoCapture(str(path)).read()
    assert shown
    np.testing.assert_array_equal(next(source.frames()).image, image)
    assert source.notes == ("phone.mp4: pictures are turned by 90 degrees clockwise, as the file asks",)


@pytest.mark.parametrize(
    ("ratio", "width"), [(Fraction(4, 3), 128), (Fraction(8, 9), 85), (Fraction(1280, 1281), 96), (None, 96)]
)
def test_pixels_that_are_not_square_are_made_so(make_video, ratio: Fraction | None, width: int):
    picture = np.zeros((48, 96, 3), np.uint8)
    picture[:, 48:] = 250
    path = make_video("tape.mp4", [picture] * 3, pixel_ratio=ratio, codec_options=NO_B_FRAMES)
    source = open_source(path)
    frame = next(source.frames())
    assert frame.image.shape == (48, width, 3)
    assert source.image_size.width == width
    assert int(np.argmax(frame.image[24, :, 1] > 125)) == pytest.approx(width / 2, abs=1)
    as_it_is = width == 96
    assert source.relays_video == as_it_is
    expected = f"tape.mp4: pictures are resized from 96x48 to {width}x48, because their pixels are not square"
    assert source.notes == (() if as_it_is else (expected,))


def test_of_a_turned_picture_the_pixels_are_made_square_before(make_video):
    picture = np.zeros((48, 96, 3), np.uint8)
    path = make_video("a.mp4", [picture] * 3, pixel_ratio=Fraction(4, 3), rotation=(90, False, False))
    source = open_source(path)
    assert next(source.frames()).image.shape == (128, 48, 3)
    assert len(source.notes) == 2


def test_mirrored_pictures_are_said_to_be(make_video, numbered_images):
    path = make_video("rear.mp4", numbered_images[:3], rotation=(0, True, False))
    assert open_source(path).notes == ("rear.mp4: pictures are mirrored, as the file asks",)


@pytest.mark.parametrize("name", ["a.mp4", "a.mov", "a.mkv", "a.avi", "a.ts"])
@pytest.mark.parametrize("b_frames", [0, 2])
def test_containers_give_the_same_pictures_and_relay_only_without_b_frames(
    make_video, numbered_images, name: str, b_frames: int
):
    options = {"bf": str(b_frames), "g": "10", "b_strategy": "0", "sc_threshold": "0"}
    source = open_source(make_video(name, numbered_images, codec_options=options))
    frames = list(source.frames())
    assert [number_in(frame.image) for frame in frames] == list(range(100))
    steps = np.diff([frame.time_ns for frame in frames])
    assert np.all(np.abs(steps - 1e9 / 30) <= 1e6)  # Matroska counts in milliseconds
    assert source.relays_video == (b_frames == 0)
    assert isinstance(source, VideoSource)
    assert source.coded_anew.startswith("the video has B frames") == (b_frames > 0)
    assert bool(source.coded_anew) == (b_frames > 0)
    assert all(bool(frame.packets) == (b_frames == 0) for frame in frames)
    assert source.notes == ()
    for index in (0, 15, 99):
        frame = next(source.frames(frames[index].time_ns))
        assert (frame.index, frame.time_ns, number_in(frame.image)) == (
            index,
            frames[index].time_ns,
            index,
        )
        if source.relays_video:
            assert frame.packets[0].keyframe


@pytest.mark.parametrize("pixel_format", ["yuv444p", "yuv420p10le"])
def test_video_that_viewers_cannot_decode_is_not_relayed(make_video, numbered_images, pixel_format: str):
    path = make_video("deep.mp4", numbered_images[:12], pixel_format=pixel_format, codec_options=NO_B_FRAMES)
    source = open_source(path)
    frames = list(source.frames())
    assert not source.relays_video
    assert isinstance(source, VideoSource)
    assert pixel_format in source.coded_anew
    assert [number_in(frame.image) for frame in frames] == list(range(12))


def test_a_frame_rate_for_a_video_is_refused(make_video, numbered_images):
    path = make_video("rated.mp4", numbered_images[:3])
    with pytest.raises(UserError, match=r"rated\.mp4: a frame rate of 12 was given, but a video has times"):
        open_source(path, frame_rate_hz=12)


def exp_golomb(number: int) -> str:
    digits = f"{number + 1:b}"
    return "0" * (len(digits) - 1) + digits


@given(first=st.integers(0, 2**20), slice_type=st.integers(0, 9), idr=st.booleans(), headers=st.booleans())
def test_slice_headers_are_read_as_the_standard_writes_them(
    first: int, slice_type: int, idr: bool, headers: bool
):
    bits = exp_golomb(first) + exp_golomb(slice_type) + "1"
    bits += "1" * (-len(bits) % 8)
    slice_unit = bytes([0x65 if idr else 0x41]) + int(bits, 2).to_bytes(len(bits) // 8, "big")
    parameter_sets = b"\0\0\0\1\x67\x42\0\0\0\1\x68\xce" if headers else b""
    unit = h264.inspect(parameter_sets + b"\0\0\0\1\x06\x05\0\0\1" + slice_unit + b"\0\0\1\x67")
    assert unit == h264.AccessUnit(idr, headers, slice_type % 5 == 1)


def test_words_in_any_encoding_do_not_matter(make_video, numbered_images):
    path = make_video("words.mp4", numbered_images[:5])
    data = path.read_bytes()
    assert data.count(b"VideoHandler") == 1
    path.write_bytes(data.replace(b"VideoHandler", "Kamera für 道路".encode("gb18030")[:12].ljust(12)))
    assert len(list(open_source(path).frames())) == 5


def test_a_file_of_two_cameras_says_which_one_is_used(make_video, numbered_images, tmp_path):
    ahead = make_video("ahead.mp4", numbered_images[:5], codec_options=NO_B_FRAMES)
    behind = make_video(
        "behind.mp4", [image[:32] for image in numbered_images[:5]], codec_options=NO_B_FRAMES
    )
    both = tmp_path / "both.mp4"
    with av.open(str(both), "w") as target:
        sources = [av.open(str(path)) for path in (ahead, behind)]
        copies = [target.add_stream_from_template(source.streams.video[0]) for source in sources]
        for source, copy in zip(sources, copies, strict=True):
            for packet in source.demux(video=0):
                if packet.size:
                    packet.stream = copy
                    target.mux(packet)
            source.close()
    source = open_source(both)
    assert str(source.image_size) == "64x48"
    (note,) = source.notes
    assert note.startswith(
        "both.mp4: holds 2 videos, as of cameras ahead and behind; the first (64x48) is used and not 64x32"
    )
    assert len(list(source.frames())) == 5
    assert source.notes == (note,)
    assert open_source(ahead).notes == ()
