"""Playback keeps time by leaving pictures out. The clock here only runs when something takes time."""

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from fcw.clock import Clock
from fcw.errors import UserError
from fcw.frame import Frame, ImageSize
from fcw.sources import open_source
from fcw_viz.page.pictures import Pictures
from fcw_viz.page.playback import LARGEST_LAG_S, LONGEST_GAP_S, Playback

RATE_HZ = 25
COUNT = 250
PERIOD_S = 1 / RATE_HZ
WAIT_S = 120.0


class FakeClock(Clock):
    """Time passes by waiting and by `take`, and not otherwise."""

    def __init__(self) -> None:
        self.time_s = 1000.0

    def now_s(self) -> float:
        return self.time_s

    def wait_s(self, seconds: float, stop: threading.Event) -> None:
        self.time_s += seconds

    def take(self, seconds: float) -> None:
        self.time_s += seconds


class FakeSource:
    """Small pictures at a steady rate, or at the times given."""

    name = "fake"
    image_size = ImageSize(2, 2)
    frame_rate_hz = float(RATE_HZ)
    relays_video = False
    notes: tuple[str, ...] = ()

    def __init__(
        self, times_s: np.ndarray | None = None, on_read: Callable[[int], None] = lambda index: None
    ) -> None:
        times_s = np.arange(COUNT) / RATE_HZ if times_s is None else times_s
        self.times_ns = np.round(times_s * 1e9).astype(np.int64)
        self.frame_count = len(times_s)
        self._on_read = on_read

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for index, time_ns in enumerate(self.times_ns.tolist()):
            if start_ns is None or time_ns >= start_ns:
                self._on_read(index)
                yield Frame(index, time_ns, np.zeros((2, 2, 3), np.uint8))


class Played:
    """What one playback showed, and when."""

    def __init__(
        self,
        source: FakeSource,
        clock: FakeClock,
        show_takes_s: float = 0.0,
        start_index: int = 0,
        speed: float = 1.0,
        on_show: Callable[[int], None] = lambda index: None,
    ) -> None:
        self.indices: list[int] = []
        self.times_s: list[float] = []
        self.message = "not ended"
        ended = threading.Event()

        def show(frame: Frame) -> None:
            self.indices.append(frame.index)
            self.times_s.append(clock.now_s())
            clock.take(show_takes_s)
            on_show(frame.index)

        def on_end(message: str) -> None:
            self.message = message
            ended.set()

        self.playback = Playback(Pictures(source), show, on_end, clock)
        self.playback.play(start_index, speed)
        assert ended.wait(WAIT_S)
        assert not self.playback.playing

    def lateness_s(self, source: FakeSource, speed: float = 1.0) -> np.ndarray:
        """How late each picture was shown, by the first one's time."""
        drive_s = (source.times_ns[self.indices] - source.times_ns[self.indices[0]]) / 1e9 / speed
        return np.array(self.times_s) - self.times_s[0] - drive_s


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_every_picture_is_shown_at_its_time_where_there_is_time(speed: float):
    source, clock = FakeSource(), FakeClock()
    played = Played(source, clock, show_takes_s=0.9 * PERIOD_S / speed, start_index=100, speed=speed)
    assert played.indices == list(range(100, COUNT))
    assert np.abs(played.lateness_s(source, speed)).max() < 1e-6
    assert played.message == ""


def test_varying_rates_keep_their_own_times():
    times_s = np.cumsum(np.random.default_rng(3).uniform(0.01, 0.3, 60))
    source, clock = FakeSource(times_s), FakeClock()
    played = Played(source, clock, show_takes_s=0.005)
    assert played.indices == list(range(60))
    assert np.abs(played.lateness_s(source)).max() < 1e-6


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("gap_s", [3600.0, 40 * 86_400.0])
def test_a_gap_of_the_stamps_is_not_waited_for(gap_s: float, speed: float):
    times_s = np.array([0.0, 0.04, 0.04 + gap_s, 0.08 + gap_s])
    played = Played(FakeSource(times_s), FakeClock(), speed=speed)
    assert played.indices == [0, 1, 2, 3]
    assert np.diff(played.times_s) == pytest.approx(np.array([0.04, LONGEST_GAP_S, 0.04]) / speed, abs=1e-6)


@pytest.mark.parametrize("periods", [2.5, 4.0, 7.3])
def test_a_slow_view_is_shown_fewer_pictures_and_never_lags(periods: float):
    source, clock = FakeSource(), FakeClock()
    played = Played(source, clock, show_takes_s=periods * PERIOD_S)
    assert played.lateness_s(source)[:-1].max() <= PERIOD_S + 1e-6
    assert played.indices[-1] == COUNT - 1
    # As many as there is time for.
    assert len(played.indices) == pytest.approx(COUNT / periods, rel=0.35)
    assert np.diff(played.indices).max() <= np.ceil(periods) + 1
    # The whole drive takes as long as it took.
    assert played.times_s[-1] - played.times_s[0] > (COUNT - 1) * PERIOD_S - (periods + 1) * PERIOD_S


def test_where_even_decoding_is_too_slow_it_plays_slowly_but_shows_pictures_all_the_time():
    clock = FakeClock()
    source = FakeSource(on_read=lambda index: clock.take(3 * PERIOD_S))
    played = Played(source, clock)
    assert np.diff(played.times_s).max() <= LARGEST_LAG_S + 3 * PERIOD_S + 1e-6
    assert clock.now_s() - 1000.0 == pytest.approx(3 * PERIOD_S * COUNT, rel=0.05)


def test_after_a_hitch_it_goes_on_from_there():
    clock = FakeClock()
    source = FakeSource(on_read=lambda index: clock.take(5.0 if index == 50 else 0.0))
    played = Played(source, clock)
    assert played.indices == list(range(COUNT))  # five seconds of pictures are not skipped
    assert played.times_s[-1] - played.times_s[0] == pytest.approx(
        5.0 + (COUNT - 1) * PERIOD_S, abs=2 * PERIOD_S
    )


def test_after_stop_returns_nothing_is_shown():
    source, clock = FakeSource(), FakeClock()
    shown: list[int] = []
    reached, go_on = threading.Event(), threading.Event()

    def show(frame: Frame) -> None:
        shown.append(frame.index)
        if frame.index == 5:
            reached.set()
            go_on.wait(WAIT_S)

    ends: list[str] = []
    playback = Playback(Pictures(source), show, ends.append, clock)
    playback.play(0)
    assert reached.wait(WAIT_S)
    assert playback.playing
    stopping = threading.Thread(target=playback.stop)
    stopping.start()
    while playback.playing:  # until the other thread has said so, which takes a busy machine a while
        stopping.join(0.001)
    go_on.set()
    stopping.join(WAIT_S)
    assert not stopping.is_alive()
    assert shown == [0, 1, 2, 3, 4, 5]
    assert ends == [""]
    assert not playback.playing
    assert all(thread.name != "playback" for thread in threading.enumerate())


def test_playing_again_replaces_what_plays():
    source, clock = FakeSource(), FakeClock()
    indices: list[int] = []
    ended = threading.Semaphore(0)
    playback: Playback

    def show(frame: Frame) -> None:
        indices.append(frame.index)
        if frame.index == 3 and len(indices) == 4:
            playback.play(200)  # as a click while it plays, by its own thread

    playback = Playback(Pictures(source), show, lambda message: ended.release(), clock)
    playback.play(0)
    for _ in range(2):
        assert ended.acquire(timeout=WAIT_S)
    assert indices == [0, 1, 2, 3, *range(200, COUNT)]


def test_a_drive_that_cannot_be_read_on_is_said_in_words():
    def fail(index: int) -> None:
        if index == 10:
            raise UserError("10.png: 5x5 pixels, expected 2x2")

    played = Played(FakeSource(on_read=fail), FakeClock())
    assert played.indices == list(range(10))
    assert played.message == "10.png: 5x5 pixels, expected 2x2"


def test_a_fault_of_ours_ends_it_with_words_too():
    def fail(index: int) -> None:
        if index == 4:
            raise ZeroDivisionError

    played = Played(FakeSource(), FakeClock(), on_show=fail)
    assert played.indices == [0, 1, 2, 3, 4]
    assert "the server's log says why" in played.message


def test_the_real_clock_waits_until_it_is_stopped():
    stop = threading.Event()
    waiting = threading.Thread(target=Clock().wait_s, args=(WAIT_S, stop))
    waiting.start()
    stop.set()
    waiting.join(WAIT_S / 2)
    assert not waiting.is_alive()


def test_a_real_drive_plays_from_where_it_is_told():
    drive = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
    shown: list[int] = []
    ended = threading.Event()
    playback = Playback(
        Pictures(open_source(drive)),
        lambda frame: shown.append(frame.index),
        lambda _: ended.set(),
        FakeClock(),
    )
    playback.play(1195)
    assert ended.wait(WAIT_S)
    assert shown == [1195, 1196, 1197, 1198, 1199]
