"""Pictures that a video repeats, and when the others were taken."""

import numpy as np
import pytest

from fcw.motion.flow.pacing import Pacing


def paced(shown):
    """(time shown, time taken) of the new pictures; `shown` are times and numbers of pictures."""
    pacing, rng, pictures, times = Pacing(), np.random.default_rng(0), {}, []
    for time_s, number in shown:
        if number not in pictures:
            pictures[number] = rng.integers(0, 255, (90, 160)).astype(np.uint8)
        noise = rng.random((90, 160)) < 0.1
        if pacing.is_new(time_s, np.where(pictures[number] < 255, pictures[number] + noise, 255)):
            times.append((time_s, pacing.taken_s))
    return np.array(times)


@pytest.mark.parametrize(("taken_hz", "shown_hz"), [(25, 30), (24, 30), (20, 30), (25, 50), (15, 60)])
def test_a_video_made_from_one_of_fewer_pictures_was_taken_evenly(taken_hz, shown_hz):
    times = paced([(k / shown_hz, int(k * taken_hz / shown_hz + 1e-9)) for k in range(3 * shown_hz)])
    assert len(times) == 3 * taken_hz
    later = times[times[:, 0] > 1.5]
    assert np.diff(later[:, 1]) == pytest.approx(1 / taken_hz, rel=0.1)
    assert np.abs(later[:, 1] - later[:, 0]).max() < 1 / shown_hz


def test_a_video_that_repeats_nothing_was_taken_when_it_is_shown():
    rng = np.random.default_rng(1)
    times = paced([(k / 30 + rng.uniform(0, 0.01), k) for k in range(60)])
    assert times[:, 1] == pytest.approx(times[:, 0], abs=1e-12)


def test_after_a_recorder_stalled_its_pictures_count_when_they_are_shown():
    """Five pictures were lost, twice; the one before is shown in their place."""
    times = paced([(k / 30, k - k % 20 if k % 20 < 5 else k) for k in range(90)])
    assert times[:, 1] == pytest.approx(times[:, 0], abs=1e-12)


def drifting(steps_px, steps_s):
    """(time shown, time taken) of pictures of a scene that moves by so much in each step."""
    pacing, rng = Pacing(), np.random.default_rng(0)
    scene = np.cumsum(rng.normal(0, 8, (90, 4000)), axis=1) % 200
    times = []
    for place, time_s in zip(np.cumsum(steps_px), np.cumsum(steps_s), strict=True):
        left = int(place)
        assert pacing.is_new(time_s, scene[:, left : left + 160].astype(np.uint8))
        times.append((time_s, pacing.taken_s))
    return np.array(times)


def test_what_moves_evenly_was_taken_evenly_whatever_its_times_say():
    delays_s = np.random.default_rng(2).uniform(0, 0.05, 101)
    times = drifting(np.full(100, 2.0), 0.05 + np.diff(delays_s))
    later = times[times[:, 0] > 2.5]
    assert np.diff(later[:, 1]) == pytest.approx(0.05, rel=0.25)
    assert np.diff(later[:, 1]).std() < 0.2 * np.diff(later[:, 0]).std()


def test_what_moves_as_its_times_say_was_taken_when_it_is_shown():
    steps = np.random.default_rng(3).integers(1, 4, 100)
    times = drifting(2.0 * steps, steps / 30)
    assert times[:, 1] == pytest.approx(times[:, 0], abs=1e-12)


@pytest.mark.parametrize("lost_one_of", [5, 10])
def test_where_lost_pictures_are_replaced_the_others_were_taken_when_they_are_shown(lost_one_of):
    """A recorder lost every fifth or tenth picture, and shows the one before in its place."""
    pacing, rng = Pacing(), np.random.default_rng(0)
    scene, times = np.cumsum(rng.normal(0, 8, (90, 4000)), axis=1) % 200, []
    for number in range(90):
        left = 2 * (number - (number % lost_one_of == lost_one_of - 1))
        if pacing.is_new(number / 30, scene[:, left : left + 160].astype(np.uint8)) and number > 45:
            times.append((number / 30, pacing.taken_s))
    shown, taken = np.transpose(times)
    assert taken == pytest.approx(shown, abs=1e-12)
