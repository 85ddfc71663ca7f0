"""The feed keeps the latest moment, and never lets the pipeline wait."""

import threading
from collections.abc import Iterator

import numpy as np
import pytest
from review_drives import PERIOD_NS, RATE_HZ, header, result

from fcw.clock import Clock
from fcw.frame import Frame, ImageSize
from fcw.logs.records import Sink
from fcw.sources.live import LiveSource
from fcw_viz.live_app.feed import HISTORY_S, LiveFeed
from fcw_viz.live_app.panels import History
from fcw_viz.review_app.plots.plot import make_plots
from fcw_viz.review_app.plots.signals import LIVE
from fcw_viz.review_app.plots.values import Run

WAIT_S = 120.0


class SteppedClock(Clock):
    """Stands until the test moves it."""

    time_s = 50.0

    def now_s(self) -> float:
        return self.time_s

    def wait_s(self, seconds: float, stop: threading.Event) -> None:
        self.time_s += seconds


class Pictures:
    """Small pictures, each grey as its number."""

    name = "made"
    image_size = ImageSize(2, 2)
    frame_count = None
    frame_rate_hz = float(RATE_HZ)
    relays_video = False
    notes = ()

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        for index in range(3):
            yield Frame(index, index * PERIOD_NS, np.full((2, 2, 3), index, np.uint8))


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock()


@pytest.fixture
def source(clock: SteppedClock) -> LiveSource:
    return LiveSource(Pictures(), threading.Event(), clock=clock)


def test_the_latest_moment_has_its_picture_and_its_latency(source: LiveSource, clock: SteppedClock):
    feed: LiveFeed = LiveFeed(source)
    sink: Sink = feed
    sink.open(header())
    assert feed.newer_than(-1, 0) is None
    frame = next(source.frames())
    capture = source.capture(0)
    assert capture is not None
    clock.time_s = capture.captured_s + 0.08
    sink.write(result(0), ())
    moment = feed.newer_than(-1, 0)
    assert moment is not None
    assert moment.result == result(0)
    assert moment.image is frame.image
    assert moment.found_s - moment.captured_s == pytest.approx(0.08)
    assert feed.newer_than(0, 0) is None


def test_writing_waits_for_nobody_and_who_asks_gets_the_latest(source: LiveSource):
    feed = LiveFeed(source)
    feed.open(header())
    indices = [frame.index for frame in source.frames()]
    for index in indices:  # nobody asks meanwhile
        feed.write(result(index), ())
    moment = feed.newer_than(-1, 0)
    assert moment is not None
    assert moment.result.index == indices[-1]
    feed.write(result(indices[-1] + 1000), ())  # whose picture nobody remembers
    assert feed.newer_than(indices[-1], 0) is None


def test_who_waits_is_woken_by_the_next_result_and_by_the_end(source: LiveSource):
    feed = LiveFeed(source)
    feed.open(header())
    next(source.frames())
    got: list[object] = []
    waiter = threading.Thread(target=lambda: got.append(feed.newer_than(-1, WAIT_S)))
    waiter.start()
    feed.write(result(0), ())
    waiter.join(WAIT_S)
    assert not waiter.is_alive()
    assert got[0] is not None
    waiter = threading.Thread(target=lambda: got.append(feed.newer_than(0, WAIT_S)))
    waiter.start()
    feed.close()
    waiter.join(WAIT_S)
    assert not waiter.is_alive()
    assert got[1] is None
    assert feed.ended


def test_the_history_reaches_back_as_far_as_the_plots(source: LiveSource):
    feed = LiveFeed(source)
    feed.open(header())
    frames = round((HISTORY_S + 10) * RATE_HZ)
    for index in range(frames):
        feed.write(result(index), ())
    series = feed.history(frames - 1)
    assert series.duration_s == pytest.approx(HISTORY_S)
    assert series.time_ns[-1] == result(frames - 1).time_ns
    history = History(header(), series, feed.first_ns)
    assert history.last_s == pytest.approx((frames - 1) / RATE_HZ)
    distance = make_plots([Run.of(history, history.last_s - HISTORY_S, history.last_s)], LIVE, False)[0]
    assert np.isfinite(distance.curves[0].told.value).all()


def test_the_history_ends_at_the_frame_that_is_shown(source: LiveSource):
    feed = LiveFeed(source)
    feed.open(header())
    for index in range(20):
        feed.write(result(index), ())
    assert feed.history(12).time_ns[-1] == result(12).time_ns
    assert len(feed.history(-1)) == 0
