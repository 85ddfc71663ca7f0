"""Of a fast drive some pictures are searched: enough, evenly, and the same ones in any piece of it."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from searching import examples

from fcw.detection.schedule import SearchSchedule


@pytest.mark.parametrize(
    ("frame_rate_hz", "every"),
    [
        (5, 1),
        (10, 1),
        (20, 1),
        (23.976, 2),
        (24, 2),
        (25, 2),
        (29.97, 2),
        (30, 2),
        (50, 4),
        (59.94, 5),
        (60, 5),
    ],
)
def test_twelve_pictures_a_second_or_more_are_searched_where_there_are_as_many(frame_rate_hz, every):
    assert SearchSchedule(frame_rate_hz, 12.0).every == every


@pytest.mark.parametrize("frame_rate_hz", [10.0, 30.0, 240.0])
def test_zero_searches_every_picture(frame_rate_hz):
    schedule = SearchSchedule(frame_rate_hz, 0.0)
    assert all(schedule.searches(round(k * 1e9 / frame_rate_hz)) for k in range(20))


@given(
    frame_rate_hz=st.floats(5.0, 240.0),
    begins_s=st.floats(-1e4, 1e5),
    late=st.lists(st.floats(-0.2, 0.2), min_size=40, max_size=40),
)
@examples(200)
def test_one_picture_in_so_many_is_searched_though_the_times_are_uneven(frame_rate_hz, begins_s, late):
    schedule = SearchSchedule(frame_rate_hz, 12.0)
    times_ns = [round(1e9 * (begins_s + (k + off) / frame_rate_hz)) for k, off in enumerate(late)]
    searched = [k for k, time_ns in enumerate(times_ns) if schedule.searches(time_ns)]
    assert searched[0] == 0
    gaps = [later - earlier for earlier, later in pairwise(searched)]
    # The first picture is searched wherever in its span it is.
    assert max(gaps, default=1) <= schedule.every + 1
    assert len(searched) <= len(times_ns) // schedule.every + 2


@given(first=st.integers(0, 60), frame_rate_hz=st.sampled_from([23.976, 25.0, 29.97, 30.0, 60.0]))
@examples(100)
def test_a_piece_searches_what_the_whole_drive_searches_and_its_own_first_picture(first, frame_rate_hz):
    times_ns = [round(k * 1e9 / frame_rate_hz) for k in range(90)]
    whole, piece = (SearchSchedule(frame_rate_hz, 12.0) for _ in range(2))
    of_whole = [time_ns for time_ns in times_ns if whole.searches(time_ns)]
    of_piece = [time_ns for time_ns in times_ns[first:] if piece.searches(time_ns)]
    assert of_piece[0] == times_ns[first]
    assert {t for t in of_whole if t >= times_ns[first]} == set(of_piece) - {times_ns[first]} | (
        {times_ns[first]} & set(of_whole)
    )


def test_a_drive_that_stops_for_a_while_is_searched_at_once_when_it_goes_on():
    schedule = SearchSchedule(30.0, 12.0)
    times_ns = [round(k * 1e9 / 30) for k in (0, 1, 2, 3, 57, 58, 59)]
    assert [schedule.searches(time_ns) for time_ns in times_ns] == [
        True,
        False,
        True,
        False,
        True,
        True,
        False,
    ]
