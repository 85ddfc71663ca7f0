"""Which boxes are one vehicle, and intervals that know it."""

import numpy as np
import pytest
from labelled import annotated

from fcw.evaluation.detection.intervals import Grouping, interval
from fcw.evaluation.detection.vehicles import frame_blocks, vehicle_identities


def grouping(vehicle, block=(0,), clip=(0,), vehicle_clip=None):
    vehicle = np.array(vehicle, np.int64)
    clips = np.zeros(len(vehicle), np.int64) if vehicle_clip is None else np.array(vehicle_clip, np.int64)
    return Grouping(vehicle, clips, np.array(block, np.int64), np.array(clip, np.int64))


def test_boxes_that_overlap_in_neighbouring_pictures_are_one_vehicle():
    images = [
        annotated((100, 100, 50, 40), (300, 100, 60, 50), time_s=0.0, image_id=1),
        annotated((306, 101, 62, 50), (104, 100, 52, 41), time_s=0.5, image_id=2),
        annotated((500, 100, 50, 40), time_s=1.0, image_id=3),
    ]
    (a, b), (b_again, a_again), (other,) = (numbers.tolist() for numbers in vehicle_identities(images))
    assert (a, b) == (a_again, b_again)
    assert len({a, b, other}) == 3


def test_the_order_of_pictures_in_the_labels_does_not_matter():
    late = annotated((100, 100, 50, 40), time_s=0.8, image_id=2)
    early = annotated((101, 100, 50, 40), time_s=0.0, image_id=1)
    first, second = vehicle_identities([late, early])
    assert first.tolist() == second.tolist()


@pytest.mark.parametrize(
    "other",
    [
        annotated((100, 100, 50, 40), time_s=0.5, clip="another"),
        annotated((100, 100, 50, 40), time_s=1.5),
        annotated((100, 100, 50, 40), time_s=None),
        annotated((140, 100, 50, 40), time_s=0.5),
    ],
    ids=["another clip", "more than a second later", "no time", "elsewhere"],
)
def test_boxes_of_other_clips_times_and_places_are_other_vehicles(other):
    first, second = vehicle_identities([annotated((100, 100, 50, 40), time_s=0.0), other])
    assert first.tolist() != second.tolist()


def test_identities_in_the_labels_are_believed():
    images = [
        annotated((100, 100, 50, 40), time_s=0.0, attributes=[{"track_id": 7}]),
        annotated((100, 100, 50, 40), time_s=0.5, attributes=[{"track_id": 8}]),
        annotated((900, 100, 50, 40), time_s=9.0, attributes=[{"track_id": 7}]),
    ]
    seven, eight, seven_again = (int(numbers[0]) for numbers in vehicle_identities(images))
    assert seven == seven_again != eight


def test_pictures_within_two_seconds_are_drawn_together():
    times = [0.0, 1.9, 2.1, None, None]
    images = [annotated(time_s=time_s, image_id=number) for number, time_s in enumerate(times)]
    images.append(annotated(time_s=0.0, clip="another"))
    blocks = frame_blocks(images)
    assert blocks[0] == blocks[1]
    assert len(set(blocks.tolist())) == 5


def test_a_vehicle_is_drawn_with_all_its_boxes_and_a_stretch_with_all_its_pictures():
    groups = grouping([0, 0, 1, 1, 1], block=[0, 0, 1], clip=[0, 0, 0])
    for vehicles, frames in groups.resamples(50):
        assert vehicles[0] == vehicles[1]
        assert vehicles[2] == vehicles[3] == vehicles[4]
        assert vehicles[0] + vehicles[2] == 2
        assert frames[0] == frames[1]
        assert frames[0] + frames[2] == 2


def test_clips_are_drawn_unless_kept():
    groups = grouping([0, 1], block=[0, 1], clip=[0, 1], vehicle_clip=[0, 1])
    drawn = {tuple(weights.vehicles) for weights in groups.resamples(50)}
    assert drawn == {(2.0, 0.0), (1.0, 1.0), (0.0, 2.0)}
    assert {tuple(weights.vehicles) for weights in groups.resamples(50, same_clips=True)} == {(1.0, 1.0)}


def test_the_same_draws_again():
    groups = grouping([0, 1, 2, 3])
    first, second = ([w.vehicles.tolist() for w in groups.resamples(5)] for _ in range(2))
    assert first == second


def test_the_middle_95_percent_without_what_is_undefined():
    low, high = interval([*range(1001), float("nan")])
    assert (low, high) == pytest.approx((25.0, 975.0))
    assert np.isnan(interval([float("nan")])).all()


def test_intervals_hold_the_truth_as_often_as_they_say_and_those_over_boxes_do_not():
    # 60 vehicles of 10 boxes, each found in a part of its boxes that is its own: mean of the parts 0.5.
    random = np.random.default_rng(1)
    vehicle = np.repeat(np.arange(60), 10)
    by_vehicle, by_box = grouping(vehicle), grouping(np.arange(600))
    vehicle_draws, box_draws = (
        np.array([weights.vehicles for weights in groups.resamples(200)]) for groups in (by_vehicle, by_box)
    )
    trials = 300
    held = held_by_box = 0
    for _ in range(trials):
        hit = random.random(600) < random.beta(0.5, 0.5, 60)[vehicle]
        low, high = interval(vehicle_draws @ hit / vehicle_draws.sum(axis=1))
        held += low <= 0.5 <= high
        low, high = interval(box_draws @ hit / box_draws.sum(axis=1))
        held_by_box += low <= 0.5 <= high
    assert held / trials == pytest.approx(0.94, abs=0.04)
    assert held_by_box / trials < 0.75
