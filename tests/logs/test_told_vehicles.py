"""Which vehicles have words wherever a frame is shown."""

import math
from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from fcw.box import Box
from fcw.logs.overlay import MOST_TOLD, overlay_boxes, told_ids
from fcw.logs.records import FrameResult
from fcw.motion.state import OwnPath
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState

LEAD = Track(1, Box(600, 380, 80, 60), 9.0, 30.0, 28.0, 32.0, 0.1, 1.0, 0.4, 30.0, 3.0, SeenBy.DETECTOR, True)
ASIDE = replace(LEAD, in_path=False, ttc_s=None)


def result(*tracks: Track, lead_id: int | None = None, warned: int | None = None) -> FrameResult:
    level = WarningLevel.NONE if warned is None else WarningLevel.WARNING
    return FrameResult(0, 0, (), tracks, lead_id, WarningState(level, warned), None, ())


def test_the_lead_has_words_and_what_drives_beside_or_before_it_has_none():
    beside = replace(ASIDE, track_id=2, distance_m=20.0, lateral_m=3.5)
    before = replace(LEAD, track_id=3, distance_m=50.0)
    assert told_ids(result(LEAD, beside, before, lead_id=1)) == {1}


def test_what_moves_into_the_path_nearer_than_the_lead_has_words():
    from_left = replace(ASIDE, track_id=2, distance_m=20.0, lateral_m=3.5, lateral_speed_mps=-1.3)
    from_right = replace(ASIDE, track_id=3, distance_m=20.0, lateral_m=-3.5, lateral_speed_mps=1.3)
    goes_away = replace(ASIDE, track_id=4, distance_m=20.0, lateral_m=3.5, lateral_speed_mps=1.3)
    assert told_ids(result(LEAD, from_left, from_right, goes_away, lead_id=1)) == {1, 2, 3}


def test_what_half_stands_in_the_path_has_words_but_not_when_it_is_not_seen():
    half = replace(ASIDE, track_id=2, distance_m=8.0, lateral_m=-1.7)
    assert told_ids(result(LEAD, half, lead_id=1)) == {1, 2}
    assert told_ids(result(LEAD, replace(half, seen_by=SeenBy.COASTING), lead_id=1)) == {1}


def test_the_vehicle_that_is_warned_of_has_words_wherever_it_is():
    beside = replace(ASIDE, track_id=2, distance_m=60.0, lateral_m=6.0)
    assert told_ids(result(LEAD, beside, lead_id=1, warned=2)) == {1, 2}


def test_oncoming_vehicles_are_no_rivals():
    oncoming = replace(LEAD, track_id=2, distance_m=25.0, closing_speed_mps=30.0)
    frame = replace(result(LEAD, oncoming, lead_id=1), ego_speed_mps=14.0)
    assert told_ids(frame) == {1}


def test_in_a_bend_a_neighbour_is_no_rival_who_is_straight_ahead_of_the_camera():
    """In a bend of 100 m to the left our path is 4.5 m aside at 30 m, and the right lane's there 1 m."""
    lead = replace(LEAD, lateral_m=4.5)
    beside = replace(ASIDE, track_id=2, distance_m=29.0, lateral_m=0.7)
    bend = OwnPath(curvature_per_m=1 / 100)
    assert told_ids(replace(result(lead, beside, lead_id=1), own_path=bend)) == {1}
    assert told_ids(result(lead, beside, lead_id=1)) == {1, 2}


def test_a_distance_out_of_range_is_no_rival():
    far = replace(ASIDE, track_id=2, distance_m=1e300)
    bend = OwnPath(curvature_per_m=1 / 100)
    assert told_ids(replace(result(replace(LEAD, distance_m=math.inf), far, lead_id=1), own_path=bend)) == {1}


def test_on_a_free_road_the_two_nearest_have_words():
    tracks = [replace(ASIDE, track_id=i, distance_m=10.0 * i, lateral_m=4.0) for i in (4, 2, 3)]
    boxes = overlay_boxes(result(*tracks))
    assert [box.told for box in boxes] == [False, True, True]


tracks = st.lists(
    st.builds(
        lambda i, d, y, v, inside: replace(
            LEAD, track_id=i, distance_m=d, lateral_m=y, lateral_speed_mps=v, in_path=inside
        ),
        st.integers(1, 99),
        st.floats(1, 90),
        st.floats(-10, 10),
        st.floats(-5, 5),
        st.booleans(),
    ),
    unique_by=lambda track: track.track_id,
)


@given(tracks)
def test_never_more_than_three_and_always_the_lead_and_the_warned_one(some):
    lead = some[0].track_id if some else None
    warned = some[-1].track_id if some else None
    told = told_ids(result(*some, lead_id=lead, warned=warned))
    assert len(told) <= MOST_TOLD
    assert told <= {track.track_id for track in some}
    assert not some or {lead, warned} <= told
