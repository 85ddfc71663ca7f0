"""Events of a drive: from made-up signals, and from the truth of the shipped drive."""

import math
from collections.abc import Container, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.box import Box
from fcw.logs.events import DriveEvent, WarningCounter, find_events, seen_s
from fcw.logs.records import CUT, NOTHING_SEEN, FrameResult
from fcw.logs.series import SeriesBuilder
from fcw.simulation.truth.file import read_truth
from fcw.simulation.truth.log import truth_result
from fcw.simulation.truth.truth import FrameTruth, warning_is_due
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState

PERIOD_NS = 100_000_000
DEMO = Path(__file__).parents[2] / "recordings" / "demo"


def frame(
    index: int,
    distance_m: float | None = None,
    closing_mps: float = 0.0,
    level: WarningLevel = WarningLevel.NONE,
    *,
    track_id: int = 3,
    own_mps: float | None = 20.0,
    notes: tuple[str, ...] = (),
) -> FrameResult:
    """A frame with a lead at a distance, or with none; the first is at 5 s on the source's clock."""
    tracks: tuple[Track, ...] = ()
    if distance_m is not None:
        ttc_s = distance_m / closing_mps if closing_mps > 0 else None
        box = Box(600, 300, 60, 50)
        tracks = (
            Track(
                track_id, box, 9, distance_m, 9, 11, 0, closing_mps, 0.3, ttc_s, 2.0, SeenBy.DETECTOR, True
            ),
        )
    state = (
        WarningState(level) if level == WarningLevel.NONE else WarningState(level, track_id, "braking_due")
    )
    time_ns = 50 * PERIOD_NS + index * PERIOD_NS
    lead_id = track_id if tracks else None
    return FrameResult(index, time_ns, (), tracks, lead_id, state, own_mps, notes)


def events_of(frames: list[FrameResult]) -> tuple[DriveEvent, ...]:
    builder = SeriesBuilder()
    for result in frames:
        builder.add(result, ())
    return find_events(builder.build())


def test_a_drive_of_no_frames_or_of_no_vehicles_has_no_events():
    assert events_of([]) == ()
    assert events_of([frame(i) for i in range(20)]) == ()


def test_a_caution_that_becomes_a_warning_is_one_event_with_its_worst_moment():
    levels = [WarningLevel.NONE] * 5 + [WarningLevel.CAUTION] * 5 + [WarningLevel.WARNING] * 6
    levels += [WarningLevel.CAUTION] * 3 + [WarningLevel.NONE] * 5
    closing_mps = [8.0] * 15 + [2.0] * 9  # braked at frame 15
    distances_m = [30 - 0.8 * i if i < 15 else 18 - 0.2 * (i - 15) for i in range(24)]
    frames = [
        frame(i, d, v, level)
        for i, (d, v, level) in enumerate(zip(distances_m, closing_mps, levels, strict=True))
    ]
    (event,) = events_of(frames)
    assert (event.kind, event.track_id, event.rule) == ("warning", 3, "braking_due")
    assert (event.start_s, event.end_s, event.peak_s) == (0.5, 1.8, 1.4)
    assert event.min_ttc_s == pytest.approx(18.8 / 8)
    assert event.min_distance_m == pytest.approx(18 - 0.2 * 3)
    assert event.max_required_deceleration_mps2 == pytest.approx(8**2 / (2 * 18.8))
    assert event.severity == pytest.approx(8**2 / (2 * 18.8) / 8)


def test_another_vehicle_and_another_kind_are_other_events():
    spans = [(WarningLevel.ADVISORY, 3), (WarningLevel.CAUTION, 3), (WarningLevel.CAUTION, 4)]
    frames = [
        frame(10 * k + i, 12.0, 1.0, level, track_id=track_id)
        for k, (level, track_id) in enumerate(spans)
        for i in range(10)
    ]
    found = [(event.kind, event.track_id, event.start_s, event.end_s) for event in events_of(frames)]
    assert found == [("advisory", 3, 0.0, 0.9), ("caution", 3, 1.0, 1.9), ("caution", 4, 2.0, 2.9)]


def test_a_level_held_on_a_vehicle_no_longer_followed_measures_nothing_of_the_next():
    frames = [frame(i, 30.0, 5.0, WarningLevel.CAUTION) for i in range(5)]
    other = frame(5, 4.0, 9.0, track_id=8)
    state = WarningState(WarningLevel.CAUTION, 3, "braking_due")
    frames.append(FrameResult(5, other.time_ns, (), other.tracks, 8, state, 20.0))
    (event,) = events_of(frames)
    assert event.end_s == 0.5
    assert event.min_distance_m == 30.0


def test_a_warned_vehicle_that_is_not_the_lead_has_its_own_figures_and_lost_ones_are_no_measurement():
    frames = []
    for i in range(10):
        lead = frame(i, 40.0, 1.0, track_id=8)
        state = WarningState(
            WarningLevel.WARNING,
            3,
            "braking_due",
            ttc_s=1.5 - i / 10,
            required_deceleration_mps2=4.0 + i / 10,
            distance_m=12.0 - i,
            distance_low_m=11.0 - i,
            distance_high_m=13.0 - i,
            closing_speed_mps=8.0,
            overlap_m=0.9,
            collision_probability=0.5,
            extrapolated=i >= 6,
        )
        frames.append(FrameResult(i, lead.time_ns, (), lead.tracks, 8, state, 20.0))
    (event,) = events_of(frames)
    assert (event.track_id, event.min_distance_m, event.peak_s) == (3, 7.0, 0.5)
    assert event.min_ttc_s == pytest.approx(1.0)
    assert event.severity == pytest.approx(4.5 / 8 * 0.5)


@pytest.mark.parametrize(
    ("distance_m", "closing_mps", "own_mps", "kinds"),
    [
        (10.0, 7.0, 20.0, ["near miss"]),  # TTC 1.43 s
        (10.0, 6.5, 20.0, []),  # 1.54 s and 2.1 m/s^2
        (30.0, 14.5, None, ["near miss"]),  # 3.5 m/s^2
        (30.0, 14.0, None, []),  # 3.3 m/s^2
        (3.0, 2.5, 8.0, []),  # 1.2 s, but no faster than a queue closes up
        (10.0, 7.0, 2.0, []),  # it comes towards us
        (10.0, 7.0, None, ["near miss"]),
    ],
)
def test_what_a_near_miss_is(distance_m: float, closing_mps: float, own_mps: float | None, kinds):
    frames = [frame(i, 60.0, 0.0) for i in range(5)]
    frames += [frame(i, distance_m, closing_mps, own_mps=own_mps) for i in range(5, 10)]
    assert [event.kind for event in events_of(frames)] == kinds


def test_a_near_miss_is_measured_while_an_advisory_is_held_on_another_vehicle():
    near = [frame(i, 10.0, 10.0, track_id=8) for i in range(5)]
    held = WarningState(WarningLevel.ADVISORY, 3, "following_time", extrapolated=True)
    found = {event.kind: event for event in events_of([replace(one, warning=held) for one in near])}
    assert found["near miss"].track_id == 8
    assert found["near miss"].min_ttc_s == 1.0
    assert found["near miss"].min_distance_m == 10.0
    assert found["near miss"].severity == pytest.approx(10.0**2 / (2 * 10.0) / 8)
    assert found["advisory"].min_distance_m is None


def test_a_moments_closeness_is_noise():
    frames = [frame(i, 8.0 if 5 <= i < 8 else 40.0, 7.0) for i in range(20)]
    assert events_of(frames) == ()


def test_a_warned_vehicle_is_no_near_miss_before_and_after():
    levels = [WarningLevel.NONE] * 8 + [WarningLevel.WARNING] * 10 + [WarningLevel.NONE] * 8
    frames = [frame(i, 9.0, 8.0, level) for i, level in enumerate(levels)]
    assert [event.kind for event in events_of(frames)] == ["warning"]


def test_contact_is_as_severe_as_it_gets():
    frames = [frame(i, max(2.0 - i, 0.0), 8.0, WarningLevel.WARNING) for i in range(4)]
    (event,) = events_of(frames)
    assert event.severity == 1
    assert event.max_required_deceleration_mps2 == math.inf
    assert event.min_distance_m == 0
    assert event.peak_s == 0.2


def test_a_mount_that_moved_is_told_once_with_its_words_until_it_is_withdrawn():
    frames = [
        frame(i, notes=(f"the mount has moved by {i} degrees",) if 10 <= i < 15 or i > 25 else ())
        for i in range(30)
    ]
    first, second = events_of(frames)
    assert (first.kind, first.start_s, first.end_s, first.track_id) == ("mount moved", 1.0, 1.4, None)
    assert first.note == "the mount has moved by 14 degrees"  # by then it is known best
    assert (second.start_s, second.end_s) == (2.6, 2.9)


def test_times_in_which_nothing_can_be_seen_are_events_apart_from_a_mount_that_moved():
    frames = [
        frame(i, notes=("moved",) * (5 <= i < 25) + (NOTHING_SEEN,) * (i < 3 or 10 <= i < 20))
        for i in range(30)
    ]
    found = [(event.kind, event.start_s, event.end_s, event.note) for event in events_of(frames)]
    assert found == [
        ("nothing seen", 0.0, 0.2, NOTHING_SEEN),
        ("mount moved", 0.5, 2.4, "moved"),
        ("nothing seen", 1.0, 1.9, NOTHING_SEEN),
    ]


def test_times_in_which_too_little_can_be_seen_are_events_with_the_words_of_their_last_frame():
    soft = [f"soft picture, half of the cars {distance_m} m away are missed: ..." for distance_m in (50, 40)]
    frames = [
        frame(i, notes=("moved",) * (i >= 5) + ((soft[i >= 15],) if 10 <= i < 20 else ())) for i in range(30)
    ]
    found = [(event.kind, event.start_s, event.end_s, event.note) for event in events_of(frames)]
    assert found == [("mount moved", 0.5, 2.9, "moved"), ("poor sight", 1.0, 1.9, soft[1])]


def at_tenths(tenths: Sequence[int], blank: Container[int] = ()) -> list[FrameResult]:
    """Frames at these tenths of a second, some of them black."""
    return [
        replace(frame(tenth, notes=(NOTHING_SEEN,) * (tenth in blank)), index=index)
        for index, tenth in enumerate(tenths)
    ]


def test_a_time_without_pictures_is_an_event_in_which_nothing_is_seen():
    events = events_of(at_tenths([0, 1, 11, 26, 27, 50, 80, 81]))  # a step of 1.0 s is none
    assert [(one.kind, one.start_s, one.end_s) for one in events] == [
        ("nothing seen", 1.1, 2.6),
        ("nothing seen", 2.7, 8.0),  # pictures that come so slowly are one time
    ]
    assert "apart for 1.5 s" in events[0].note
    assert all((one.track_id, one.severity, one.peak_s) == (None, 0.0, one.start_s) for one in events)


def test_a_warning_that_lasts_over_a_time_without_pictures_is_one_and_the_most_severe():
    tenths = [*range(5), *range(100, 105)]
    frames = [
        replace(frame(tenth, 10.0, 8.0, WarningLevel.WARNING), index=index)
        for index, tenth in enumerate(tenths)
    ]
    events = events_of(frames)
    assert [event.kind for event in events] == ["warning", "nothing seen"]
    assert events[0].severity > events[1].severity == 0.0


@pytest.mark.parametrize(
    ("tenths", "blank", "expected_s"),
    [
        (range(31), (), 3.0),
        ([*range(11), *range(51, 61)], (), 1.9),
        (range(31), range(10, 21), 2.0),
        ([*range(11), *range(51, 61)], range(8, 53), 1.6),  # black before and after: each time counts once
        ([0, 20, 40], (), 0.0),
        (range(31), range(31), 0.0),
        ([], (), 0.0),
    ],
    ids=["all", "no pictures", "black", "both", "all apart", "all black", "none"],
)
def test_for_how_long_something_could_be_seen(
    tenths: Sequence[int], blank: Container[int], expected_s: float
):
    duration_s = (tenths[-1] - tenths[0]) / 10 if tenths else 0.0
    assert seen_s(duration_s, events_of(at_tenths(tenths, blank))) == pytest.approx(expected_s, abs=1e-12)


def test_each_cut_is_an_event_of_its_own():
    frames = [frame(i, notes=("moved",) * (i >= 5) + (CUT,) * (i in (10, 12))) for i in range(20)]
    found = [(event.kind, event.start_s, event.end_s, event.note) for event in events_of(frames)]
    assert found == [("mount moved", 0.5, 1.9, "moved"), ("cut", 1.0, 1.0, CUT), ("cut", 1.2, 1.2, CUT)]


@given(
    st.lists(
        st.tuples(
            st.sampled_from(WarningLevel),
            st.integers(1, 2),
            st.none() | st.floats(0, 80),
            st.floats(-20, 20),
        ),
        max_size=30,
    )
)
def test_every_alarm_is_in_one_event_and_every_event_in_the_drive(rows):
    frames = [frame(i, d, v, level, track_id=k) for i, (level, k, d, v) in enumerate(rows)]
    events = events_of(frames)
    assert [event.start_s for event in events] == sorted(event.start_s for event in events)
    for event in events:
        assert 0 <= event.start_s <= event.peak_s <= event.end_s <= max(len(frames) - 1, 0) / 10
        assert 0 <= event.severity <= 1
    for i, result in enumerate(frames):
        about = [
            event
            for event in events
            if event.kind in ("warning", "caution") and event.start_s <= i / 10 <= event.end_s
        ]
        alarmed = result.warning.level >= WarningLevel.CAUTION
        assert [event.track_id for event in about] == ([result.warning.track_id] if alarmed else [])


def shipped_truth() -> tuple[list[FrameTruth], list[FrameResult]]:
    """What was true on the shipped drive, and the same as results."""
    truth = read_truth(DEMO / "truth.csv")
    ids = {name: k for k, name in enumerate(sorted({v.name for f in truth for v in f.vehicles}))}
    return truth, [truth_result(i, f.time_ns, f, ids) for i, f in enumerate(truth)]


def test_the_shipped_drives_truth_has_the_one_warning_that_was_due():
    truth, results = shipped_truth()
    due = [(f, f.lead) for f in truth if f.lead is not None and warning_is_due(f.lead)]
    (event,) = [event for event in events_of(results) if event.kind == "warning"]
    start_ns = truth[0].time_ns
    assert event.start_s == pytest.approx((due[0][0].time_ns - start_ns) / 1e9)
    assert event.end_s == pytest.approx((due[-1][0].time_ns - start_ns) / 1e9)
    assert {lead.name for _, lead in due} == {"cutting in"}
    assert event.min_distance_m == pytest.approx(min(lead.distance_m for _, lead in due))
    needed_mps2 = [lead.closing_speed_mps**2 / (2 * lead.distance_m) for _, lead in due]
    assert event.max_required_deceleration_mps2 == pytest.approx(max(needed_mps2))
    worst, _ = due[needed_mps2.index(max(needed_mps2))]
    assert event.peak_s == pytest.approx((worst.time_ns - start_ns) / 1e9)


@given(
    st.lists(
        st.tuples(st.integers(1, 12), st.sampled_from(WarningLevel), st.integers(1, 2)),
        min_size=1,
        max_size=12,
    )
)
def test_warnings_are_counted_while_a_drive_runs_as_they_are_found_in_the_end(
    spells: list[tuple[int, WarningLevel, int]],
):
    shown = [(level, track_id) for count, level, track_id in spells for _ in range(count)]
    counter, builder = WarningCounter(), SeriesBuilder()
    for index, (level, track_id) in enumerate(shown):
        result = frame(index, 30.0, 5.0, level, track_id=track_id)
        counter.add(result.told_warning)
        builder.add(result, ())
    found = find_events(builder.build())
    assert counter.count == sum(event.kind == "warning" for event in found)
