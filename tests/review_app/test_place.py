"""Where somebody is: events are followed, and gone to in the order of time or of the list."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fcw.errors import UserError
from fcw_viz.review_app.drive_card import DriveCard
from fcw_viz.review_app.panels.folder_list import folder_html
from fcw_viz.review_app.place import LEAD_IN_S, Place, moment_text, parse_place, place_text


def at(place: Place, time_s: float) -> Place:
    place.row = place.opened.row_at(time_s)
    return place


@pytest.mark.parametrize(
    ("text", "parsed"),
    [
        ("monday", ("monday", None, None)),
        ("monday#2", ("monday", 2, None)),
        ("monday@7.5", ("monday", None, 7.5)),
        ("a@b#c", ("a@b#c", None, None)),
    ],
)
def test_a_place_is_a_drive_and_what_follows_its_name(
    text: str, parsed: tuple[str, int | None, float | None]
):
    assert parse_place(text) == parsed


@pytest.mark.parametrize("name", ["drive #2", "cam@8", "a#1@2#3"])
@pytest.mark.parametrize("read", [True, False])
def test_a_drive_of_the_list_opens_whatever_signs_its_name_has(name: str, read: bool):
    html = folder_html("drives", [DriveCard(name, Path("drive.mcap"), 3.0, read=read)], 0, 1000.0)
    (message,) = re.findall('data-fcw="open:([^"]*)"', html)
    assert parse_place(message) == (name, None, None)
    assert parse_place(place_text(name, 4)) == (name, 4, None)


def test_a_drive_begins_at_its_worst_event_where_nothing_else_is_named(place: Place):
    place.enter(place.opened, None, None)
    assert place.selected == place.opened.worst_event()
    place.enter(place.opened, None, 4.0)
    assert place.time_s == pytest.approx(4.0)


@pytest.mark.parametrize("rate_hz", [24.0, 29.97, 30.0, 59.94])
def test_the_address_of_a_frame_leads_to_that_frame_whatever_fraction_of_a_second_it_has(
    place: Place, rate_hz: float
):
    series = place.opened.series
    times_ns = np.round(np.arange(len(series)) * 1e9 / rate_hz).astype(np.int64)
    drive = replace(place.opened, series=replace(series, time_ns=times_ns))
    for row in range(len(series)):
        _, event, moment_s = parse_place(moment_text("made", drive.time_s(row)))
        place.enter(drive, event, moment_s)
        assert place.row == row


def test_events_come_one_after_the_other_and_the_last_one_stays(place: Place):
    events = place.opened.events
    for number in range(1, len(events)):
        place.selected = place.next_event(True)
        assert place.selected == number
        at(place, events[number].peak_s)
    assert place.next_event(True) == len(events) - 1


def test_from_between_two_events_each_way_leads_to_its_neighbour(place: Place):
    first, second = place.opened.events[:2]
    at(place, (first.end_s + second.start_s) / 2)
    place.selected = None
    assert (place.next_event(False), place.next_event(True)) == (0, 1)


def test_the_event_that_the_moment_is_in_is_selected_and_a_near_one_kept(place: Place):
    first, second = place.opened.events[:2]
    at(place, first.end_s + LEAD_IN_S / 2)
    assert not place.follow_event()
    assert place.selected == 0
    at(place, (second.start_s + second.end_s) / 2)
    assert place.follow_event()
    assert place.selected == 1


def test_without_a_drive_the_person_is_told_to_open_one(place: Place):
    place.leave()
    with pytest.raises(UserError, match="open a drive first: click one in the list, or press ↓ and Enter"):
        place.next_event(True)


def test_the_ends_of_a_range_stay_in_order_and_inside_the_drive(place: Place):
    place.mark(start_s=5.0)
    assert place.marked == (5.0, place.opened.duration_s)
    place.mark(end_s=8.0)
    assert place.marked == (5.0, 8.0)
    place.mark(start_s=9.0)
    assert place.marked == (9.0, 9.0)
    place.mark(end_s=-3.0)
    assert place.marked == (0.0, 0.0)
    place.mark(end_s=1e9)
    assert place.marked == (0.0, place.opened.duration_s)
