"""Playing by the clock: never late by more than the frame that is being shown, whatever showing takes."""

import threading

import numpy as np
import pytest
from clocks import FakeClock

from fcw.errors import UserError
from fcw_viz.review_app.time.player import SPEEDS, Player

WAIT_S = 120.0
PERIOD_NS = 40_000_000
TIMES_NS = 7_000_000_000 + np.arange(500, dtype=np.int64) * PERIOD_NS


def play(showing_s: float, speed: float, start: int = 0, times_ns=TIMES_NS) -> list[tuple[int, float]]:
    """Rows that were shown, each with the time since the start at which its showing began."""
    clock, shown, ended = FakeClock(), [], threading.Event()
    start_s = clock.now_s()

    def show(row: int) -> None:
        shown.append((row, clock.now_s() - start_s))
        clock.time_s += showing_s

    player = Player(lambda stop: None, show, lambda message: ended.set(), clock)
    player.load(times_ns)
    player.play(start, speed)
    assert ended.wait(WAIT_S)
    return shown


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("showing_s", [0.0, 0.01, 0.09, 0.35])
def test_each_frame_is_the_one_that_is_due(showing_s: float, speed: float):
    shown = play(showing_s, speed)
    for row, at_s in shown[:-1]:
        due_s = (TIMES_NS[row] - TIMES_NS[0]) / 1e9 / speed
        assert at_s == pytest.approx(due_s, abs=PERIOD_NS / 1e9 / speed + 1e-6)
    rows = [row for row, _ in shown]
    assert rows == sorted(set(rows))
    assert rows[-1] == len(TIMES_NS) - 1


def test_at_a_quarter_of_the_speed_no_frame_is_left_out():
    assert [row for row, _ in play(0.01, 0.25)] == list(range(1, 500))


def test_a_slow_browser_gets_fewer_frames_of_the_same_drive():
    shown = play(0.2, 1.0)
    assert len(shown) == pytest.approx(499 * 0.04 / 0.2, rel=0.05)


def test_frames_that_come_unevenly_are_shown_at_their_times():
    times_ns = np.array([0, 40, 80, 2_000, 2_040], np.int64) * 1_000_000
    assert [at_s for _, at_s in play(0.0, 1.0, times_ns=times_ns)] == pytest.approx([0.04, 0.08, 2.0, 2.04])


@pytest.mark.parametrize("speed", [0.5, 1.0, 4.0])
@pytest.mark.parametrize("gap_s", [3600, 40 * 86_400])
def test_a_gap_of_the_stamps_is_not_waited_for(gap_s: int, speed: float):
    times_ns = np.array([0, 40, 80, 80 + gap_s * 1000, 120 + gap_s * 1000], np.int64) * 1_000_000
    moments_s = np.array([0.04, 0.08, 2.08, 2.12]) / speed
    assert [at_s for _, at_s in play(0.0, speed, times_ns=times_ns)] == pytest.approx(moments_s, abs=1e-6)


def test_the_end_is_told_with_what_went_wrong():
    told, ended = [], threading.Event()

    def fail(row: int) -> None:
        raise UserError("the log is gone")

    def end(message: str) -> None:
        told.append(message)
        ended.set()

    player = Player(lambda stop: None, fail, end, FakeClock())
    player.load(TIMES_NS)
    player.play(3)
    assert ended.wait(WAIT_S)
    assert told == ["the log is gone"]
    assert not player.playing


def test_nothing_is_shown_after_stop():
    shown, first = [], threading.Event()

    def show(row: int) -> None:
        shown.append(row)
        first.set()

    player = Player(lambda stop: None, show, lambda message: None)
    player.load(TIMES_NS)
    player.play(0, 8.0)
    assert first.wait(WAIT_S)
    player.stop()
    count = len(shown)
    assert not player.playing
    assert len(shown) == count


def test_the_browser_is_waited_for_before_the_frame_is_chosen():
    clock, shown, ended = FakeClock(), [], threading.Event()

    def ready(stop: threading.Event) -> None:
        clock.time_s += 0.5

    player = Player(ready, shown.append, lambda message: ended.set(), clock)
    player.load(TIMES_NS)
    player.play(0)
    assert ended.wait(WAIT_S)
    # The next frame is waited for, then the browser for half a second: by then a later frame is due.
    assert shown[:2] == [(40 + 500) // 40, (14 * 40 + 500) // 40]


def test_a_part_is_played_to_its_end_and_no_further():
    shown, ended = [], threading.Event()
    player = Player(lambda stop: None, shown.append, lambda message: ended.set(), FakeClock())
    player.load(TIMES_NS)
    player.play_to(100, 110, 1.0)
    assert ended.wait(WAIT_S)
    assert shown == list(range(101, 111))


def test_a_part_is_played_again_and_again_until_it_is_stopped():
    shown, enough = [], threading.Event()

    def show(row: int) -> None:
        shown.append(row)
        if len(shown) >= 33:
            enough.set()

    player = Player(lambda stop: None, show, lambda message: None, FakeClock())
    player.load(TIMES_NS)
    player.play_to(100, 110, 1.0, 100)
    assert enough.wait(WAIT_S)
    player.stop()
    assert shown[:32] == [*range(101, 111), *range(100, 111), *range(100, 111)]
