"""The watch for a moved mount, and the lens's prior."""

import math

import numpy as np
import pytest

from fcw.frame import ImageSize
from fcw.tracking.horizon import MountWatch, RulerReading

SIZE = ImageSize(1280, 720)
STEP_S = 1.0
WELL_CLICKED_RAD = math.radians(0.05)
WIDTH_SIGMA = 0.08
NOISE_RAD = math.radians(0.1)


def traffic(rng, seconds, turned_rad=0.0, turned_at=0, vehicles=3, stay_s=25):
    """Readings of each second: vehicles of unknown widths, one after the other, on a road that pitches."""
    common = slope = 0.0
    seen = []
    for second in range(seconds):
        slope = 0.95 * slope + math.radians(0.05) * math.sqrt(1 - 0.95**2) * rng.standard_normal()
        common = slope + math.radians(0.12) * rng.standard_normal()
        readings = []
        for place in range(vehicles):
            if (second + place * stay_s // vehicles) % stay_s == 0 or second == 0:
                width, below_rad = WIDTH_SIGMA * rng.standard_normal(), rng.uniform(0.03, 0.1)
                seen = [*seen[-20:], (place, second, width, below_rad)]
            _, born, width, below_rad = next(entry for entry in reversed(seen) if entry[0] == place)
            pitch_rad = common + below_rad * (width + 0.03 * rng.standard_normal())
            pitch_rad += math.radians(0.2) * rng.standard_normal()
            pitch_rad += turned_rad if second >= turned_at else 0.0
            vehicle = (1000 * place + born, 0)
            readings.append(RulerReading(vehicle, pitch_rad, below_rad, WIDTH_SIGMA, NOISE_RAD))
        yield readings


def watched(frames, sigma_rad=WELL_CLICKED_RAD):
    """Whether a moved mount is said at each second."""
    watch = MountWatch(sigma_rad)
    said = []
    for readings in frames:
        watch.update(readings, STEP_S)
        said.append(watch.moved)
    return watch, said


@pytest.mark.slow
def test_an_ordinary_drive_of_two_hours_says_nothing():
    _, said = watched(traffic(np.random.default_rng(1), 7200))
    assert not any(said)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("seed", range(4))
def test_half_a_degree_in_mid_drive_is_said_within_two_minutes_and_which_way(direction, seed):
    turned_rad = direction * math.radians(0.5)
    watch, said = watched(traffic(np.random.default_rng(seed), 500, turned_rad, 300))
    assert not any(said[:300])
    assert any(said[300:420])
    assert watch.note is not None
    assert ("farther down" if direction > 0 else "farther up") in watch.note
    assert watch.deviation_rad == pytest.approx(turned_rad, abs=math.radians(0.25))


def test_what_is_said_is_not_taken_back_by_a_flicker_but_by_a_mended_mount():
    rng = np.random.default_rng(3)
    turned = [
        *traffic(rng, 300),
        *traffic(rng, 400, math.radians(1.0)),
        *traffic(rng, 400),
    ]
    _, said = watched(turned)
    changes = [k for k in range(1, len(said)) if said[k] != said[k - 1]]
    assert len(changes) == 2
    assert 300 <= changes[0] < 700 <= changes[1]


def test_a_deviation_that_the_clicks_explain_is_not_said():
    _, said = watched(traffic(np.random.default_rng(5), 900, math.radians(0.3)), sigma_rad=math.radians(0.3))
    assert not any(said)


def test_a_calibration_that_is_wrong_from_the_start_is_said():
    watch, said = watched(traffic(np.random.default_rng(6), 600, math.radians(1.0)))
    assert said[-1]
    assert watch.deviation_rad == pytest.approx(math.radians(1.0), abs=math.radians(0.3))


def test_frames_without_vehicles_say_nothing():
    watch, said = watched([[]] * 1000)
    assert not any(said)
    assert watch.note is None
