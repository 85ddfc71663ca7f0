"""A log against the truth: what counts, what is an error, and which warnings were due."""

import dataclasses

import pytest

from fcw.box import Box
from fcw.detection.detector import Detection
from fcw.evaluation.simulated import compare_with_truth, counts_as_rear_view, enhanced_ttc_s, vehicle_at
from fcw.logs.records import FrameResult
from fcw.simulation.truth.truth import FrameTruth, VehicleTruth
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState

NONE = WarningState(WarningLevel.NONE)


def seen(name="lead", distance_m=20.0, closing_mps=0.0, **more) -> VehicleTruth:
    truth = VehicleTruth(
        name=name,
        distance_m=distance_m,
        lateral_m=0.0,
        path_lateral_m=0.0,
        closing_speed_mps=closing_mps,
        ttc_s=distance_m / closing_mps if closing_mps > 0 else None,
        box=Box(600, 330, 80, 60),
        body_box=Box(600, 330, 80, 60),
        visible_fraction=1.0,
        oncoming=False,
        in_path=True,
    )
    if "box" in more:
        more.setdefault("body_box", more["box"])
    return dataclasses.replace(truth, **more)


def instant(index: int, *vehicles: VehicleTruth) -> FrameTruth:
    return FrameTruth(round(index * 1e9 / 30), 20.0, 0.0, 0.0, 330.0, vehicles)


def track(distance_m=20.0, box: Box | None = None, track_id=1) -> Track:
    return Track(
        track_id,
        box or Box(600, 330, 80, 60),
        1.0,
        distance_m,
        19,
        21,
        0.0,
        0.0,
        0.1,
        None,
        1.0,
        SeenBy.DETECTOR,
        True,
    )


def result(index, *tracks, detections=(), warning=NONE, lead_id: int | None = 1) -> FrameResult:
    boxes = tuple(Detection(box, 1.0) for box in detections)
    return FrameResult(
        index, round(index * 1e9 / 30), boxes, tracks, lead_id if tracks else None, warning, 20.0
    )


def test_distance_errors_are_relative_and_signed():
    truths = [instant(k, seen()) for k in range(3)]
    results = [result(0, track(21.0)), result(1, track(19.0)), result(2)]
    comparison = compare_with_truth(results, truths)
    assert comparison.lead_errors == pytest.approx((0.05, -0.05))
    assert comparison.lead_frames == 3
    assert comparison.track_errors == comparison.lead_errors


def test_what_was_not_searched_counts_neither_as_missed_nor_as_free_of_false_alarms():
    truths = [instant(k, seen()) for k in range(4)]
    found = seen().box, Box(100, 330, 40, 30)
    results = [result(k, track(20.0), detections=() if k % 2 else found) for k in range(4)]
    every = compare_with_truth(results, truths)
    assert (every.detection_rate, every.false_positives_per_frame) == (0.5, 0.5)
    second = compare_with_truth(
        [dataclasses.replace(one, searched=one.index % 2 == 0) for one in results], truths
    )
    assert (second.detection_rate, second.false_positives_per_frame) == (1.0, 1.0)
    assert second.lead_errors == every.lead_errors


def test_a_lead_that_is_another_vehicle_has_no_error():
    other = seen("other", 40.0, box=Box(100, 330, 40, 30), in_path=False)
    comparison = compare_with_truth([result(0, track(40.0, other.box))], [instant(0, seen(), other)])
    assert comparison.lead_errors == ()
    assert comparison.track_errors == pytest.approx((0.0,))


def test_a_box_belongs_to_the_vehicle_it_overlaps_by_half():
    truth = instant(0, seen())
    assert vehicle_at(Box(600, 330, 80, 60), truth) is truth.vehicles[0]
    assert vehicle_at(Box(600, 330, 40, 60), truth) is truth.vehicles[0]
    assert vehicle_at(Box(600, 330, 39, 60), truth) is None
    assert vehicle_at(Box(0, 0, 9, 9), instant(0)) is None


@pytest.mark.parametrize(
    ("change", "counts"),
    [
        ({}, True),
        ({"distance_m": 4.9}, False),
        ({"distance_m": 60.1}, False),
        ({"visible_fraction": 0.7}, False),
        ({"oncoming": True}, False),
        ({"lateral_m": 8.9}, True),
        ({"lateral_m": -9.1}, False),
    ],
)
def test_what_a_detector_must_find(change, counts):
    assert counts_as_rear_view(dataclasses.replace(seen(), **change)) is counts


def test_hits_misses_and_false_positives_are_counted_and_what_does_not_count_is_neither():
    found, missed = seen("found"), seen("missed", box=Box(100, 330, 80, 60))
    oncoming = seen("oncoming", box=Box(300, 330, 80, 60), oncoming=True)
    boxes = (found.box, oncoming.box, Box(900, 330, 80, 60))
    comparison = compare_with_truth(
        [result(0, detections=boxes), result(1)], [instant(0, found, missed, oncoming), instant(1)]
    )
    assert (comparison.vehicles, comparison.hits, comparison.false_positives) == (2, 1, 1)
    assert comparison.detection_rate == 0.5
    assert comparison.false_positives_per_frame == 0.5


def test_the_side_of_a_vehicle_that_does_not_count_is_not_a_false_positive():
    oncoming = seen("oncoming", oncoming=True, body_box=Box(600, 330, 240, 60))
    side, beyond = Box(700, 330, 140, 60), Box(850, 330, 80, 60)
    comparison = compare_with_truth([result(0, detections=(side, beyond))], [instant(0, oncoming)])
    assert comparison.false_positives == 1


def approach(warned_at: int | None, level=WarningLevel.WARNING, from_m=40.0, **more):
    """Closing at 10 m/s: due at 24.75 m (see test_truth), which from 40 m frame 46 is the first to pass."""
    frames = round(3 * (from_m - 40)) + 70
    truths = [instant(k, seen(distance_m=from_m - k / 3, closing_mps=10.0, **more)) for k in range(frames)]
    results = [
        result(
            k,
            track(from_m - k / 3),
            warning=WarningState(level, 1, "ttc") if warned_at is not None and k >= warned_at else NONE,
        )
        for k in range(frames)
    ]
    return compare_with_truth(results, truths)


@pytest.mark.parametrize(("warned_at", "in_time"), [(30, True), (46, True), (47, False), (None, False)])
def test_a_warning_is_in_time_when_it_comes_at_the_due_moment_or_before(warned_at, in_time):
    (due,) = approach(warned_at).due
    assert due.vehicle == "lead"
    assert due.due_s == pytest.approx(46 / 30)
    assert due.in_time is in_time
    assert due.warned_s == (None if warned_at is None else pytest.approx(warned_at / 30))


@pytest.mark.parametrize(
    ("warned_at", "in_window"), [(58, False), (61, True), (106, True), (107, False), (None, False)]
)
def test_the_window_of_a_warning_begins_at_4_s_and_ends_when_it_is_due(warned_at, in_window):
    # From 60 m on: 4 s, that is 40 m, at frame 60; due at 24.75 m, which frame 106 is the first to pass.
    (due,) = approach(warned_at, from_m=60.0).due
    assert due.earliest_s == pytest.approx(60 / 30, abs=0.04)
    assert due.due_s == pytest.approx(106 / 30)
    assert due.in_window is in_window


def test_a_caution_is_no_warning():
    (due,) = approach(30, WarningLevel.CAUTION).due
    assert due.warned_s is None


def test_the_same_danger_is_due_once_though_it_pauses_for_a_moment():
    truths = [
        instant(k, seen(distance_m=10.0, closing_mps=10.0 if not 20 <= k < 40 else 0.0)) for k in range(60)
    ]
    assert len(compare_with_truth([result(k) for k in range(60)], truths).due) == 1


def test_warnings_of_oncoming_and_of_nothing_are_told_apart_from_those_that_were_needed():
    assert approach(30).needless == ()
    oncoming = approach(30, oncoming=True, in_path=False)
    assert oncoming.due == ()
    assert oncoming.warnings_of_oncoming == 1
    assert [warning.vehicle for warning in oncoming.needless] == ["lead"]
    elsewhere = approach(30, box=Box(0, 0, 20, 20))
    assert [warning.vehicle for warning in elsewhere.needless] == [None]
    assert elsewhere.warnings_of_oncoming == 0


def test_what_does_not_belong_together_is_refused():
    with pytest.raises(ValueError, match="do not belong together"):
        compare_with_truth([result(0)], [instant(0), instant(1)])


def test_the_enhanced_ttc_takes_a_growing_closing_speed_to_go_on():
    # 36.6 m at 6.4 m/s is a TTC of 5.7 s; with 6 m/s^2 more each second the 36.6 m are used up in 2.6 s.
    assert enhanced_ttc_s(36.6, 6.4, 0.0) == pytest.approx(5.72, abs=0.01)
    growing_s = enhanced_ttc_s(36.6, 6.4, 6.0)
    assert growing_s is not None
    assert 6.4 * growing_s + 6.0 * growing_s**2 / 2 == pytest.approx(36.6)
    # Whoever brakes may let go; what does not come nearer has no such time.
    assert enhanced_ttc_s(36.6, 6.4, -3.0) == pytest.approx(36.6 / 6.4)
    assert enhanced_ttc_s(36.6, 0.0, 6.0) is None


@pytest.mark.parametrize(("growth_mps2", "needless"), [(0.0, True), (3.0, False)])
def test_an_early_warning_is_needless_unless_the_lead_brakes(growth_mps2, needless):
    # At 30 m and 6 m/s the TTC is 5 s; with 3 m/s^2 more each second the gap lasts 2.9 s.
    truths = [
        instant(k, seen(distance_m=30.0, closing_mps=6.0 + growth_mps2 * (k - 5) / 30)) for k in range(6)
    ]
    warned = WarningState(WarningLevel.WARNING, 1, "braking_due")
    results = [result(k, track(30.0), warning=warned if k == 5 else NONE) for k in range(6)]
    assert bool(compare_with_truth(results, truths).needless) is needless
