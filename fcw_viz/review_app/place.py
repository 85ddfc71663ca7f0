"""Where somebody is: in which of the drives, at which frame, and at which event."""

from collections.abc import Sequence

from fcw.annotation.review import JudgedEvent, find_event, reference_to
from fcw.errors import UserError
from fcw_viz.review_app.drive import Drive, by_severity
from fcw_viz.review_app.plots.choice import PlotChoice
from fcw_viz.review_app.session import DriveReview, ReviewSession
from fcw_viz.review_app.triage.drive_filter import DriveFilter

LEAD_IN_S = 2.0
"""An event is played from so long before it, and whoever is so near to it is still at it."""
MOST_LISTED = 200
"""Of a long list the worst ones; the time line has them all."""
NOTED_DECIMALS = 3
"""Of the seconds in the page's address."""


class Place:
    """Where the person of one tab is.

    Attributes:
        session: what all tabs share.
        drive: that is open; None where the list of drives is seen.
        row: the frame that is shown.
        selected: number of the event that is judged; None for none.
        by_time: the order of the event list.
        asked: which drives and events they want to see.
        marked: a range of the drive that somebody has marked, in seconds; None for none.
        goes_on: whether a verdict leads to the next unjudged event.
        plots: which curves they want to see.
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
        """The drive that is open.

        Raises:
            UserError: none is.
        """
        if self.drive is None:
            raise UserError("open a drive first: click one in the list, or press ↓ and Enter there")
        return self.drive

    @property
    def review(self) -> DriveReview:
        """What is said of the open drive by now."""
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
        """Go to an event of a drive, else to a moment of it, else to its worst event."""
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
        """Be at the same moment and event of a drive that has grown, or is another one."""
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
        """Be in no drive."""
        self.drive = self.selected = self.marked = None
        self.plots.leave_drive()

    def mark(self, start_s: float | None = None, end_s: float | None = None) -> None:
        """Move an end of the marked range; over the other end it takes that along."""
        duration_s = self.opened.duration_s
        before = self.marked or (self.time_s, self.time_s)
        if start_s is not None:
            start_s = min(max(start_s, 0.0), duration_s)
            self.marked = start_s, max(before[1] if self.marked else duration_s, start_s)
        if end_s is not None:
            end_s = min(max(end_s, 0.0), duration_s)
            self.marked = min(before[0] if self.marked else 0.0, end_s), end_s

    def follow_event(self) -> bool:
        """Select the event that the moment is in, the worst of several; whether that is another one."""
        if self._near_selected():
            return False
        events, time_s = self.opened.events, self.time_s
        here = [n for n, event in enumerate(events) if event.start_s <= time_s <= event.end_s]
        if not here:
            return False
        self.selected = max(here, key=lambda number: events[number].severity)
        return True

    def next_event(self, forward: bool) -> int:
        """Number of the next event by time, or of the one before.

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
        """Number of the next event of the list as it is sorted, or of the one before.

        Raises:
            UserError: there is none.
        """
        order = list_order(self.review.events, self.by_time)
        if self.selected not in order:
            return _nearest(order, 0)
        return _nearest(order, order.index(self.selected) + (1 if forward else -1))

    def _near_selected(self) -> bool:
        """Whether the moment is in the selected event, or at it."""
        if self.selected is None:
            return False
        event = self.opened.events[self.selected]
        return event.start_s - LEAD_IN_S <= self.time_s <= event.end_s + LEAD_IN_S


def list_order(events: Sequence[JudgedEvent], by_time: bool) -> list[int]:
    """Numbers of the events as they are listed."""
    ranked = by_severity(tuple(judged.event for judged in events))[:MOST_LISTED]
    return sorted(ranked) if by_time else ranked


def place_text(name: str, event: int | None = None) -> str:
    """What `parse_place` takes for a drive, whatever signs its name has, or for an event of it."""
    return f"{name}#{'' if event is None else event}"


def moment_text(name: str, moment_s: float) -> str:
    """What `parse_place` takes for a moment of a drive, as the page's address notes it."""
    return f"{name}@{moment_s:.{NOTED_DECIMALS}f}"


def parse_place(text: str) -> tuple[str, int | None, float | None]:
    """The drive, and the event (`#<number>`) or the moment (`@<seconds>`), that a text names."""
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
