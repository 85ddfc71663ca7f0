"""Where two runs of one drive differ, on runs of which it is known."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from review_drives import (
    CAUTION_S,
    FRAMES,
    NEAR_MISS_END_S,
    NEAR_MISS_S,
    PERIOD_NS,
    RATE_HZ,
    WARNING_END_S,
    WARNING_S,
    result,
)

from fcw.logs.comparison import Difference, DifferenceKind, find_differences, matching_rows
from fcw.logs.records import FrameResult
from fcw.logs.series import DriveSeries, SeriesBuilder
from fcw.warning.types import WarningLevel, WarningState

LAST_WARNED_S = WARNING_END_S - 1 / RATE_HZ
LAST_NEAR_S = NEAR_MISS_END_S - 1 / RATE_HZ


def series(change: Callable[[FrameResult], FrameResult] = lambda one: one, every: int = 1) -> DriveSeries:
    """The made drive, with a change of every frame's result."""
    builder = SeriesBuilder()
    for index in range(0, FRAMES, every):
        builder.add(change(result(index)), ())
    return builder.build()


def during(start_s: float, end_s: float, change: Callable[[FrameResult], FrameResult]):
    """A change in a part of the drive."""

    def changed(one: FrameResult) -> FrameResult:
        return change(one) if start_s <= one.index / RATE_HZ < end_s else one

    return changed


def silent(one: FrameResult) -> FrameResult:
    return replace(one, warning=WarningState(WarningLevel.NONE))


def without_lead(one: FrameResult) -> FrameResult:
    return replace(one, lead_id=None)


def farther(one: FrameResult) -> FrameResult:
    # The interval of the made drive reaches from 0.9 to 1.2 of the distance.
    tracks = tuple(
        replace(
            track,
            distance_m=1.5 * track.distance_m,
            distance_low_m=1.25 * track.distance_m,
            distance_high_m=1.9 * track.distance_m,
        )
        for track in one.tracks
    )
    return replace(one, tracks=tracks)


def differences(first: DriveSeries, second: DriveSeries, same: bool = True) -> tuple[Difference, ...]:
    return find_differences(first, second, lambda row, other: same)


def test_a_run_does_not_differ_from_itself():
    assert differences(series(), series()) == ()


@pytest.mark.parametrize("swapped", [False, True])
def test_a_warning_that_only_one_run_shows(swapped: bool):
    runs = series(), series(during(CAUTION_S, WARNING_END_S, silent))
    first, second = runs[::-1] if swapped else runs
    (one,) = differences(first, second)
    assert (one.kind, one.first_has) == (DifferenceKind.WARNING, not swapped)
    assert (one.start_s, one.end_s) == pytest.approx((CAUTION_S, LAST_WARNED_S))
    levels = (one.first_level, one.second_level)
    assert levels == ((WarningLevel.WARNING, WarningLevel.NONE)[:: -1 if swapped else 1])


def test_a_warning_that_is_less_urgent_in_the_other_run():
    def milder(one: FrameResult) -> FrameResult:
        return replace(one, warning=replace(one.warning, level=WarningLevel.CAUTION))

    (one,) = differences(series(), series(during(WARNING_S, WARNING_END_S, milder)))
    assert (one.first_level, one.second_level) == (WarningLevel.WARNING, WarningLevel.CAUTION)


def test_the_same_warning_a_little_later_is_no_difference():
    assert differences(series(), series(during(CAUTION_S, CAUTION_S + 0.4, silent))) == ()


@pytest.mark.parametrize("swapped", [False, True])
def test_a_warning_that_comes_later_differs_until_it_comes(swapped: bool):
    def milder(one: FrameResult) -> FrameResult:
        return replace(one, warning=replace(one.warning, level=WarningLevel.CAUTION))

    late_s = WARNING_S + 0.6
    runs = series(), series(during(WARNING_S, late_s, milder))
    first, second = runs[::-1] if swapped else runs
    (one,) = differences(first, second)
    assert (one.kind, one.first_has) == (DifferenceKind.WARNING, not swapped)
    assert (one.start_s, one.end_s) == pytest.approx((WARNING_S, late_s - 1 / RATE_HZ))
    levels = (one.first_level, one.second_level)
    assert levels == ((WarningLevel.WARNING, WarningLevel.CAUTION)[:: -1 if swapped else 1])


def test_a_lead_that_only_one_run_has():
    (one,) = differences(series(during(NEAR_MISS_S, NEAR_MISS_END_S, without_lead)), series())
    assert (one.kind, one.first_has) == (DifferenceKind.LEAD, False)
    assert (one.start_s, one.end_s) == pytest.approx((NEAR_MISS_S, LAST_NEAR_S))
    assert (one.first_m, one.second_m) == (None, pytest.approx(11.0))


def test_what_is_gone_at_once_is_noise():
    shorter = during(NEAR_MISS_S, NEAR_MISS_S + 0.12, without_lead)
    assert differences(series(), series(shorter)) == ()


@pytest.mark.parametrize(("same", "kind"), [(True, DifferenceKind.DISTANCE), (False, DifferenceKind.LEAD)])
def test_distances_whose_intervals_do_not_touch(same: bool, kind: DifferenceKind):
    changed = series(during(NEAR_MISS_S, NEAR_MISS_END_S, farther))
    (one,) = differences(series(), changed, same)
    assert (one.kind, one.first_has) == (kind, None)
    assert (one.start_s, one.end_s) == pytest.approx((NEAR_MISS_S, LAST_NEAR_S))
    assert (one.first_m, one.second_m) == (pytest.approx(11.0), pytest.approx(16.5))


def test_distances_whose_intervals_touch_are_no_difference():
    def a_little(one: FrameResult) -> FrameResult:
        return replace(one, tracks=tuple(replace(t, distance_m=1.3 * t.distance_m) for t in one.tracks))

    assert differences(series(), series(a_little)) == ()


def test_runs_of_part_of_the_drive_and_at_another_rate_are_matched_by_time():
    whole = series()
    half = series(every=2)
    rows, others = matching_rows(whole, half)
    np.testing.assert_array_equal(whole.time_ns[rows], half.time_ns[others])
    assert len(rows) == len(half)
    later = replace(whole, time_ns=whole.time_ns + FRAMES * PERIOD_NS)
    assert not len(matching_rows(whole, later)[0])
    assert differences(whole, later) == ()
