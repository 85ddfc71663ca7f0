"""A camera gives pictures with times of their own. Tests have streams on this machine for one."""

import itertools
import re
import socket
import threading
from collections.abc import Callable, Generator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from camera_streams import StreamServer, as_jpeg
from clocks import FakeClock
from numpy.typing import NDArray
from video_making import MakeVideo

from fcw.errors import UserError
from fcw.frame import Frame, ImageSize
from fcw.sources.camera import (
    CONNECTING,
    LONGEST_PAUSE_S,
    RETURNS_WITHIN_S,
    CameraSource,
    camera_name,
    is_camera,
)
from fcw.sources.live import LiveSource

STEP_S = 0.04
"""From one look at the clock to the next."""
Serve = Callable[..., StreamServer]


@pytest.fixture
def serve() -> Generator[Serve]:
    servers: list[StreamServer] = []

    def start(images: list[NDArray[np.uint8] | bytes], file: Path | None = None) -> StreamServer:
        servers.append(StreamServer(images, file))
        return servers[-1]

    yield start
    for server in servers:
        server.close()


def number(image: NDArray[np.uint8]) -> int:
    """The number in the bands of `numbered_images`."""
    return sum(1 << bit for bit in range(8) if image[24, 8 * bit + 4].mean() > 128)


def test_pictures_of_a_stream_come_in_order_at_the_times_of_their_arrival(
    serve: Serve, numbered_images: list[NDArray[np.uint8]], monkeypatch: pytest.MonkeyPatch
):
    moments_s = 500.0 + np.cumsum(np.random.default_rng(4).uniform(0.02, 0.2, 20))
    clock = iter(moments_s)
    monkeypatch.setattr("fcw.sources.camera.time", SimpleNamespace(monotonic=lambda: next(clock)))
    server = serve(numbered_images[:20])
    source = CameraSource(f"{server.url}/camera.mjpg")
    assert source.image_size == ImageSize(64, 48)
    assert not source.recorded
    frames: list[Frame] = []
    for frame in itertools.islice(source.frames(), 20):  # then the connection ends
        frames.append(frame)
        server.taken.release()  # none is held back: the next one is sent only now
    assert [number(frame.image) for frame in frames] == list(range(20))
    times_s = np.array([frame.time_ns for frame in frames]) / 1e9
    assert times_s == pytest.approx(moments_s - moments_s[0], abs=1e-9)


def numbers(server: StreamServer, count: int) -> list[int]:
    """Of the first pictures of its camera."""
    found: list[int] = []
    for frame in itertools.islice(CameraSource(f"{server.url}/camera.mjpg").frames(), count):
        found.append(number(frame.image))
        server.taken.release(2)  # for a damaged one, too
    return found


def test_a_damaged_jpeg_is_left_out(serve: Serve, numbered_images: list[NDArray[np.uint8]]):
    jpegs = [as_jpeg(image) for image in numbered_images[:9]]
    for damaged in (3, 5):
        jpegs[damaged] = jpegs[damaged][: len(jpegs[damaged]) * 2 // 3]
    assert numbers(serve(jpegs), 7) == [0, 1, 2, 4, 6, 7, 8]


def test_a_camera_whose_jpegs_all_have_a_fault_is_seen_all_the_same(
    serve: Serve, numbered_images: list[NDArray[np.uint8]]
):
    faulty = [as_jpeg(image)[:-40] for image in numbered_images[:6]]
    assert len(numbers(serve(faulty), 6)) == 6


def test_a_recording_on_the_network_keeps_its_own_times_and_its_own_rate(
    serve: Serve, make_video: MakeVideo, numbered_images: list[NDArray[np.uint8]]
):
    file = make_video("drive.mkv", numbered_images[:12])  # read from its beginning to its end
    source = CameraSource(f"{serve([], file).url}/file")
    assert source.recorded
    times_ns = [frame.time_ns for frame in source.frames()]
    assert times_ns == pytest.approx([index * 1e9 / 30 for index in range(12)], abs=0.6e6)  # milliseconds
    clock = FakeClock()
    live = LiveSource(source, threading.Event(), paced=source.recorded, clock=clock)
    frames = list(live.frames())
    assert len(frames) + live.dropped == 12
    assert sum(clock.waited_s) == pytest.approx(11 / 30, abs=1e-3)


def test_bursts_of_the_network_are_not_in_the_times_of_a_transport_stream(
    serve: Serve,
    make_video: MakeVideo,
    numbered_images: list[NDArray[np.uint8]],
    monkeypatch: pytest.MonkeyPatch,
):
    # Ten pictures at once, half a second of nothing, ten more.
    came_s = iter(500.0 + np.repeat([0.0, 0.5], 10) + np.tile(np.arange(10) * 1e-3, 2))
    monkeypatch.setattr("fcw.sources.camera.time", SimpleNamespace(monotonic=lambda: next(came_s)))
    file = make_video("camera.ts", numbered_images[:20], codec_options={"bf": "0"})
    source = CameraSource(f"{serve([], file).url}/file")
    assert not source.recorded
    steps_ns = np.diff([frame.time_ns for frame in source.frames()])
    assert steps_ns == pytest.approx([1e9 / 30] * 19, abs=2e4)  # ticks of 11 microseconds


@pytest.mark.parametrize("starts", [(300, 30), (30, 90_000)], ids=["back", "forward"])
def test_when_a_cameras_clock_is_set_the_times_go_on(
    starts: tuple[int, int],
    serve: Serve,
    make_video: MakeVideo,
    numbered_images: list[NDArray[np.uint8]],
    monkeypatch: pytest.MonkeyPatch,
):
    came_s = itertools.count(500.0, 0.05)
    monkeypatch.setattr("fcw.sources.camera.time", SimpleNamespace(monotonic=lambda: next(came_s)))
    parts = [
        make_video(name, numbered_images[:9], pts=range(start, start + 9), codec_options={"bf": "0"})
        for name, start in zip(("before.ts", "after.ts"), starts, strict=True)
    ]
    whole = parts[0].with_name("whole.ts")
    whole.write_bytes(b"".join(part.read_bytes() for part in parts))
    source = CameraSource(f"{serve([], whole).url}/file")
    assert not source.recorded
    steps_ns = np.diff([frame.time_ns for frame in source.frames()])
    assert len(steps_ns) == 17
    assert np.delete(steps_ns, 8) == pytest.approx([1e9 / 30] * 16, abs=2e4)  # ticks of 11 microseconds
    assert steps_ns[8] == pytest.approx(50e6)  # when it came


class Moments:
    """In the place of the camera's `time`: it passes by looking and by waiting, and not otherwise."""

    def __init__(self) -> None:
        self.now_s = 500.0
        self.paused_s: list[float] = []
        self.on_pause: Callable[[], object] = lambda: None

    def monotonic(self) -> float:
        self.now_s += STEP_S
        return self.now_s

    def sleep(self, seconds: float) -> None:
        self.paused_s.append(seconds)
        self.now_s += seconds
        self.on_pause()


@pytest.fixture
def moments(monkeypatch: pytest.MonkeyPatch) -> Moments:
    made = Moments()
    monkeypatch.setattr("fcw.sources.camera.time", made)
    return made


def test_a_lost_connection_is_made_anew_and_the_times_go_on(
    serve: Serve, numbered_images: list[NDArray[np.uint8]], moments: Moments
):
    server = serve(numbered_images[:3])  # of each connection
    source = CameraSource(f"{server.url}/camera.mjpg")
    troubles: list[str] = []
    moments.on_pause = lambda: troubles.append(source.trouble)
    frames = list(itertools.islice(source.frames(), 8))
    assert [number(frame.image) for frame in frames] == [0, 1, 2, 0, 1, 2, 0, 1]
    assert [frame.index for frame in frames] == list(range(8))
    assert troubles == [CONNECTING] * 2
    assert moments.paused_s == [1, 1]
    assert (source.trouble, source.notes) == ("", ())
    steps_s = np.diff([frame.time_ns for frame in frames]) / 1e9
    assert np.delete(steps_s, [2, 5]) == pytest.approx([STEP_S] * 5, abs=1e-9)
    assert (steps_s[[2, 5]] > 1.0).all()


def test_a_camera_that_does_not_come_back_ends_the_drive_with_the_reason(
    serve: Serve, numbered_images: list[NDArray[np.uint8]], moments: Moments
):
    server = serve(numbered_images[:3])
    source = CameraSource(f"{server.url}/camera.mjpg")
    frames = source.frames()
    assert next(frames).index == 0
    server.close()
    assert len(list(frames)) == 2
    assert re.fullmatch(r"the camera is gone \(.+\) and did not come back in 60 s", source.trouble)
    assert source.notes == (f"{source.name}: {source.trouble}",)
    assert moments.paused_s[:6] == [1, 2, 3, 4, 5, 5]
    assert RETURNS_WITHIN_S - LONGEST_PAUSE_S < sum(moments.paused_s) < RETURNS_WITHIN_S + LONGEST_PAUSE_S


def test_pictures_of_another_size_end_the_drive_with_the_reason(
    serve: Serve, numbered_images: list[NDArray[np.uint8]], moments: Moments
):
    larger = [np.zeros((96, 128, 3), np.uint8)]
    source = CameraSource(f"{serve(numbered_images[:2] + larger).url}/camera.mjpg")
    assert len(list(source.frames())) == 2
    assert source.trouble == "its pictures are 128x96 now, no longer 64x48"
    assert moments.paused_s == []


def test_where_no_camera_is_the_message_says_what_was_expected():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    named = rf"127.0.0.1-{port}-camera: no camera there \(.*refused.*the number"
    with pytest.raises(UserError, match=named):
        CameraSource(f"http://127.0.0.1:{port}/camera")
    with pytest.raises(UserError, match=r"camera-97: no camera there with pictures of 640x480"):
        CameraSource("97", ImageSize(640, 480))


@pytest.mark.parametrize(
    ("address", "name"),
    [
        ("0", "camera-0"),
        ("/dev/video2", "camera-2"),
        ("rtsp://me:secret@10.0.0.7:554/live/main", "10.0.0.7-live-main"),
        ("http://car.local/stream?token=secret", "car.local-stream"),
        ("http://127.0.0.1:8081/s", "127.0.0.1-8081-s"),
        ("http://127.0.0.1:8082/s", "127.0.0.1-8082-s"),
        ("udp://@:1234", "1234"),
    ],
)
def test_names_hold_no_passwords(address: str, name: str):
    assert is_camera(address)
    assert camera_name(address) == name


def test_a_port_that_is_none_is_refused():
    with pytest.raises(UserError, match="no address of a camera"):
        camera_name("rtsp://10.0.0.7:99999/main")


@pytest.mark.parametrize("address", ["drive.mp4", "pictures", "0.mp4", "/data/drive.mcap"])
def test_files_are_no_cameras(address: str):
    assert not is_camera(address)
