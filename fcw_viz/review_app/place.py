"""The place of a tab: its drive, frame and event."""

from collections.abc import Sequence

from fcw.annotation.review import JudgedEvent, find_event, reference_to
from fcw.errors import UserError
from fcw_viz.review_app.drive import Drive, by_severity
from fcw_viz.review_app.plots.choice import PlotChoice
from fcw_viz.review_app.session import DriveReview, ReviewSession
from fcw_viz.review_app.triage.drive_filter import DriveFilter

LEAD_IN_S = 2.0
"""An event is played from so long before it, and a moment so near before it belongs to it."""
MOST_LISTED = 200
"""Largest number of events in the list, the worst ones; the time line shows all of them."""
NOTED_DECIMALS = 3
"""Decimals of the seconds in the address of the page."""


class Place:
    """The place and the choices of one tab.

    Attributes:
        session: what all tabs share.
        drive: the open drive; None while the list of drives is shown.
        row: row of the frame that is shown.
        selected: number of the selected event; None for none.
        by_time: whether the event list is sorted by time.
        asked: the filter of drives and events.
        marked: the marked range of the drive in seconds; None for none.
        goes_on: whether a verdict leads to the next unjudged event.
        plots: the chosen curves.
    """

    def __init__(self, session: ReviewSession) -> None:
        self.session = session
        self.drive: Drive | None = None
        self.row = 0
        self.selected: int | None = None
        self.by_time = False
        self.asked = DriveFilter()
        self.goes_on = False
        self.marked: tuple[float, float] | None = None
        self.plots = PlotChoice()

    @property
    def opened(self) -> Drive:
        """The open drive.

        Raises:
            UserError: no drive is open.
        """
        if self.drive is None:
            raise UserError("open a drive first: click one in the list, or press ↓ and Enter there")
        return self.drive

    @property
    def review(self) -> DriveReview:
        """The present review of the open drive."""
        return self.session.review(self.opened.name, self.opened)

    @property
    def judged(self) -> JudgedEvent | None:
        """The selected event with its verdicts."""
        return None if self.drive is None or self.selected is None else self.review.events[self.selected]

    @property
    def time_s(self) -> float:
        """The moment that is shown."""
        return self.opened.time_s(self.row)

    def enter(self, drive: Drive, event: int | None, moment_s: float | None) -> None:
        """Go to an event of a drive or, if not given, to a time in it, or else to its worst event."""
        self.drive = drive
        if event is None and moment_s is None:
            event = drive.worst_event()
        if event is not None and event < len(drive.events):
            self.selected = event
            self.row = drive.row_at(drive.events[event].peak_s)
        else:
            # The address may have rounded the moment to one before its frame.
            self.row = drive.row_at((moment_s or 0.0) + 0.5 * 10**-NOTED_DECIMALS)
        self.follow_event()

    def turn_to(self, drive: Drive) -> None:
        """Go to the same time and event of a drive that has grown or was replaced."""
        time_s, selected = self.time_s, self.selected
        event = None if selected is None else reference_to(self.opened.events[selected])
        self.drive = drive
        self.row = drive.row_at(time_s)
        if self.marked is not None:
            start_s, end_s = self.marked
            inside = start_s < drive.duration_s
            self.marked = (start_s, min(end_s, drive.duration_s)) if inside else None
        self.selected = None if event is None else find_event(event, drive.events)

    def leave(self) -> None:
        """Leave the drive."""
        self.drive = self.selected = self.marked = None
        self.plots.leave_drive()

    def mark(self, start_s: float | None = None, end_s: float | None = None) -> None:
        """Move an end of the marked range; beyond the other end, it moves that too."""
        duration_s = self.opened.duration_s
        before = self.marked or (self.time_s, self.time_s)
        if start_s is not None:
            start_s = min(max(start_s, 0.0), duration_s)
            self.marked = start_s, max(before[1] if self.marked else duration_s, start_s)
        if end_s is not None:
            end_s = min(max(end_s, 0.0), duration_s)
            self.marked = min(before[0] if self.marked else 0.0, end_s), end_s

    def follow_event(self) -> bool:
        """Select the worst event at this time; returns whether the selection has changed."""
        if self._near_selected():
            return False
        events, time_s = self.opened.events, self.time_s
        here = [n for n, event in enumerate(events) if event.start_s <= time_s <= event.end_s]
        if not here:
            return False
        self.selected = max(here, key=lambda number: events[number].severity)
        return True

    def next_event(self, forward: bool) -> int:
        """The number of the next event by time, or of the one before.

        Raises:
            UserError: there is none.
        """
        peaks_s = [event.peak_s for event in self.opened.events]
        order = sorted(range(len(peaks_s)), key=lambda number: peaks_s[number])
        if self.selected is not None and self._near_selected():
            index = order.index(self.selected) + (1 if forward else -1)
        elif forward:
            index = sum(peaks_s[number] <= self.time_s for number in order)
        else:
            index = sum(peaks_s[number] < self.time_s for number in order) - 1
        return _nearest(order, index)

    def next_listed(self, forward: bool) -> int:
        """The number of the next event in the sorted list, or of the one before.

        Raises:
            UserError: there is none.
        """
        order = list_order(self.review.events, self.by_time)
        if self.selected not in order:
            return _nearest(order, 0)
        return _nearest(order, order.index(self.selected) + (1 if forward else -1))

    def _near_selected(self) -> bool:
        """Whether the time is in the selected event, or just before it."""
        if self.selected is None:
            return False
        event = self.opened.events[self.selected]
        return event.start_s - LEAD_IN_S <= self.time_s <= event.end_s + LEAD_IN_S


def list_order(events: Sequence[JudgedEvent], by_time: bool) -> list[int]:
    """Numbers of the events in the order of the list."""
    ranked = by_severity(tuple(judged.event for judged in events))[:MOST_LISTED]
    return sorted(ranked) if by_time else ranked


def place_text(name: str, event: int | None = None) -> str:
    """The text that `parse_place` reads as a drive, with any characters in its name, or an event of it."""
    return f"{name}#{'' if event is None else event}"


def moment_text(name: str, moment_s: float) -> str:
    """The text that `parse_place` reads as a time of a drive, as in the address of the page."""
    return f"{name}@{moment_s:.{NOTED_DECIMALS}f}"


def parse_place(text: str) -> tuple[str, int | None, float | None]:
    """The drive that a text names, with the event (`#<number>`) or the time (`@<seconds>`)."""
    name, sign, rest = text.rpartition("@")
    if sign:
        try:
            return name, None, float(rest)
        except ValueError:
            pass
    name, sign, rest = text.rpartition("#")
    if sign and (rest.isdecimal() or not rest):
        return name, int(rest) if rest else None, None
    return text, None, None


def _nearest(order: list[int], index: int) -> int:
    if not order:
        raise UserError("there is no event in this drive")
    return order[min(max(index, 0), len(order) - 1)]
