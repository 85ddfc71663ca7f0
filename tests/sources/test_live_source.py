"""A live source plays at the source's own rate and leaves frames out rather than be late."""

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pytest
from clocks import FakeClock

from fcw.errors import UserError
from fcw.frame import Frame, ImageSize, VideoPacket
from fcw.sources import live
from fcw.sources.live import LiveSource

RATE_HZ = 20
WAIT_S = 120.0
SIZE = ImageSize(2, 2)


@dataclass
class Made:
    """Frames with packets; each waits until the test lets it go."""

    GAP_AFTER: ClassVar = 2
    count: int = 10
    gap_ns: int = 0
    relays_video: bool = True
    first_ns: int = 7_000_000_000
    fails_after: int | None = None
    gate: threading.Semaphore = field(default_factory=lambda: threading.Semaphore(0))
    read: int = 0
    name: str = "made.mp4"
    image_size: ImageSize = SIZE
    frame_count: int | None = None
    frame_rate_hz: float = float(RATE_HZ)
    notes: tuple[str, ...] = ("a note",)
    recorded: bool = True
    trouble: str = ""

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for index in range(self.count):
            assert self.gate.acquire(timeout=WAIT_S)
            if index == self.fails_after:
                raise UserError("made.mp4: torn")
            time_ns = self.time_ns(index)
            packet = VideoPacket(bytes([index]), time_ns, index == 0, shown=True)
            self.read = index + 1
            yield Frame(index, time_ns, np.full((2, 2, 3), index, np.uint8), (packet,))

    def time_ns(self, index: int) -> int:
        return self.first_ns + index * 1_000_000_000 // RATE_HZ + self.gap_ns * (index > self.GAP_AFTER)

    def let(self, frames: int) -> None:
        """Let so many frames go, and wait until they are read."""
        wanted = self.read + frames
        self.gate.release(frames)
        wait_for(lambda: self.read >= wanted)


def wait_for(condition: Callable[[], bool]) -> None:
    end_s = time.monotonic() + WAIT_S
    while not condition():
        assert time.monotonic() < end_s, "waited in vain"
        time.sleep(0.001)


def opened(made: Made, **options: bool) -> tuple[LiveSource, Iterator[Frame], FakeClock, threading.Event]:
    clock, stop = FakeClock(), threading.Event()
    source = LiveSource(made, stop, clock=clock, **options)
    return source, source.frames(), clock, stop


def test_a_recording_is_played_at_its_own_rate():
    made = Made()
    source, frames, clock, _ = opened(made)
    for number in range(made.count):
        made.gate.release()
        frame = next(frames)
        assert frame.index == number
        # Each waits for what its time is after the first one's.
        assert clock.now_s() == pytest.approx(500.0 + number / RATE_HZ)
        capture = source.capture(number)
        assert capture is not None
        assert capture.captured_s == pytest.approx(500.0 + number / RATE_HZ)
        assert capture.image is frame.image
    assert next(frames, None) is None
    assert source.dropped == 0
    assert source.notes == ("a note",)
    assert source.duration_s == pytest.approx((made.count - 1) / RATE_HZ)


@pytest.mark.parametrize("gap_s", [3600, 40 * 86_400])
def test_a_gap_of_a_recordings_stamps_is_not_waited_for(gap_s: int):
    made = Made(count=6, gap_ns=gap_s * 1_000_000_000)
    source, frames, clock, _ = opened(made)
    shown_s: list[float] = []
    for number in range(made.count):
        made.gate.release()
        assert next(frames).time_ns == made.time_ns(number)
        capture = source.capture(number)
        assert capture is not None
        shown_s.append(capture.captured_s)
    steps_s = [1 / RATE_HZ] * 5
    steps_s[Made.GAP_AFTER] = live.LONGEST_WAIT_S
    assert np.diff(shown_s) == pytest.approx(steps_s, abs=1e-6)
    assert clock.now_s() - 500.0 == pytest.approx(sum(steps_s), abs=1e-6)


def test_a_cameras_frames_wait_for_nothing():
    made = Made()
    _, frames, clock, _ = opened(made, paced=False)
    made.gate.release(made.count)
    taken = list(frames)
    assert taken[-1].image[0, 0, 0] == made.count - 1
    assert clock.waited_s == []


def test_the_latest_frame_wins_and_the_dropped_ones_are_counted():
    made = Made()
    source, frames, _, _ = opened(made)
    made.gate.release()
    assert next(frames).image[0, 0, 0] == 0
    made.let(4)  # while nobody is ready
    wait_for(lambda: source.dropped == 3)
    frame = next(frames)
    assert frame.image[0, 0, 0] == 4
    assert frame.index == 1
    assert frame.time_ns == made.first_ns + 4 * 1_000_000_000 // RATE_HZ
    assert source.notes[-1] == "made.mp4: 3 pictures skipped to keep up"


def test_no_packet_is_lost_and_only_the_frames_own_is_shown():
    made = Made()
    source, frames, _, _ = opened(made)
    packets: list[VideoPacket] = []
    dropped = 0
    for step in (1, 3, 2, 4):
        made.gate.release(step)
        dropped += step - 1
        wait_for(lambda dropped=dropped: source.dropped == dropped)
        frame = next(frames)
        assert [packet.shown for packet in frame.packets] == [False] * (step - 1) + [True]
        packets += frame.packets
    assert [packet.data for packet in packets] == [bytes([index]) for index in range(made.count)]


def test_stopping_ends_the_frames_though_the_source_gives_nothing():
    made = Made()
    _, frames, _, stop = opened(made)
    made.gate.release()
    next(frames)
    stop.set()
    assert next(frames, None) is None


def test_what_goes_wrong_in_the_source_is_told_where_the_frames_are_taken():
    made = Made(fails_after=1)
    _, frames, _, _ = opened(made)
    made.gate.release(2)
    assert next(frames).index == 0
    with pytest.raises(UserError, match=r"made.mp4: torn"):
        next(frames)


def test_a_source_that_falls_silent_ends_the_drive(monkeypatch: pytest.MonkeyPatch):
    made = Made()
    source, frames, _, _ = opened(made)
    made.gate.release()
    next(frames)
    monkeypatch.setattr(live, "PATIENCE_S", 0.1)
    assert next(frames, None) is None
    assert "no picture for" in source.notes[-1]
    assert "no picture for" in source.trouble


def test_what_is_wrong_with_a_source_is_known_until_the_drive_is_ended_by_hand():
    made = Made()
    source, _, _, stop = opened(made)
    assert source.trouble == ""
    made.trouble = "the camera is gone"
    assert source.trouble == "the camera is gone"
    stop.set()
    assert source.trouble == ""


def test_a_camera_is_no_recording_behind_other_sources_either():
    assert opened(Made())[0].recorded
    assert not opened(Made(recorded=False))[0].recorded


class HeldClock(FakeClock):
    """Waiting ends when the test lets it."""

    def __init__(self) -> None:
        super().__init__()
        self.waiting, self.due = threading.Event(), threading.Event()

    def wait_s(self, seconds: float, stop: threading.Event) -> None:
        super().wait_s(seconds, stop)
        self.waiting.set()
        assert self.due.wait(WAIT_S)


def test_a_picture_that_is_not_due_yet_is_waited_for(monkeypatch: pytest.MonkeyPatch):
    made, clock = Made(count=2), HeldClock()
    made.gate.release(made.count)
    frames = LiveSource(made, threading.Event(), clock=clock).frames()
    assert next(frames).index == 0
    assert clock.waiting.wait(WAIT_S)
    monkeypatch.setattr(live, "PATIENCE_S", 0.0)
    threading.Timer(0.2, clock.due.set).start()
    assert next(frames).index == 1


def test_frames_asked_for_again_begin_anew():
    made = Made()
    source, frames, _, _ = opened(made)
    made.gate.release(made.count)
    assert next(frames).index == 0
    frames.close()  # pyright: ignore[reportAttributeAccessIssue]
    made.gate.release(made.count)
    assert next(source.frames()).index == 0


def test_only_the_last_captures_are_kept():
    made = Made(count=live.CAPTURES_KEPT + 5)
    source, frames, _, _ = opened(made)
    for _ in range(made.count):
        made.gate.release()
        next(frames)
    assert source.capture(0) is None
    assert source.capture(made.count - 1) is not None
