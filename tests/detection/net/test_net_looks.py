"""How windows are shown to the nets, and which are looked at twice."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.detection.boxes.overlap import intersection_over_union
from fcw.detection.net.looks import FIRST_PX, LEAST_CONTRAST, PickSettings, normalised, pick, runner
from fcw.detection.net.model import SHIPPED_NET_PATH, NetModel


@given(st.floats(0.4, 1.0), st.floats(0.0, 100.0), st.integers(0, 1000))
def test_haze_and_exposure_change_little_of_what_the_nets_see(clear, air, seed):
    # Koschmieder: clear * colour + air, here without rounding to keep the law exact.
    windows = np.random.default_rng(seed).uniform(0, 150, (2, 24, 24, 3))
    hazy = clear * windows + air
    seen, seen_hazy = (normalised(each.astype(np.float32)) for each in (windows, hazy))  # pyright: ignore[reportArgumentType]
    deviation = windows.reshape(2, -1).std(axis=1)
    faded = clear * (deviation + LEAST_CONTRAST) / (clear * deviation + LEAST_CONTRAST)
    assert seen_hazy == pytest.approx(seen * faded[:, None, None, None], abs=1e-3)
    assert faded.min() > 0.8  # nearly nothing is lost, down to 0.4 of the light


def test_a_plain_wall_stays_plain():
    wall = np.full((1, 24, 24, 3), 90, np.uint8)
    wall[:, ::2] += 1
    assert np.abs(normalised(wall)).max() <= 0.5 / LEAST_CONTRAST


def test_the_nets_are_given_channels_first():
    windows = np.zeros((1, 24, 24, 3), np.uint8)
    windows[0, 3, 5, 2] = 255
    given_ = normalised(windows)
    assert given_.shape == (1, 3, 24, 24)
    assert np.unravel_index(np.argmax(given_[0]), (3, 24, 24)) == (2, 3, 5)


def test_without_onnxruntime_opencv_says_the_same(monkeypatch):
    network = NetModel.load(SHIPPED_NET_PATH).first
    windows = np.random.default_rng(0).normal(size=(7, 3, FIRST_PX, FIRST_PX)).astype(np.float32)
    expected = runner(network)(windows)
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    assert runner(network)(windows).reshape(7, 5) == pytest.approx(expected, abs=1e-4)


def test_each_class_of_size_has_places_of_its_own_for_its_best():
    random = np.random.default_rng(0)
    sizes = np.repeat(np.array([30.0, 120.0, 400.0]), 20)
    boxes = np.zeros((60, 4))
    boxes[:, 0] = np.arange(60) * 900.0
    boxes[:, 2] = boxes[:, 3] = sizes
    logits = random.normal(size=60)
    settings = PickSettings(lowest_logit=-9.0, size_parts=(0.12, 0.3), counts=(5, 3, 2))
    placements = pick(boxes, logits, 720, settings)
    chosen = np.round((placements[:, 0] - placements[:, 2] / 2) / 900.0).astype(int)
    assert np.all(np.diff(logits[chosen]) <= 0)
    for first, count in ((0, 5), (20, 3), (40, 2)):
        best = first + np.argsort(-logits[first : first + 20])[:count]
        assert set(best) <= set(chosen)
    assert len(chosen) == 10


@given(st.integers(0, 500), st.floats(-1.0, 1.0))
def test_what_is_picked_is_worth_it_and_not_alike(seed, lowest):
    random = np.random.default_rng(seed)
    boxes, logits = random.uniform(5, 200, (60, 4)), random.normal(size=60)
    settings = PickSettings(lowest_logit=lowest)
    placements = pick(boxes, logits, 400, settings)
    rows = [
        int(
            np.argmin(
                np.abs(boxes[:, 0] + boxes[:, 2] / 2 - middle) + np.abs(boxes[:, 1] + boxes[:, 3] - bottom)
            )
        )
        for middle, bottom, _ in placements
    ]
    assert np.all(logits[rows] >= lowest)
    overlap = intersection_over_union(boxes[rows], boxes[rows]) - np.eye(len(rows))
    assert overlap.max(initial=0.0) <= settings.largest_iou + 1e-9
